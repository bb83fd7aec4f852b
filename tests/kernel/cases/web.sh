# init: systemd
# memory: 2G
# limit: 600
# quiltweb under systemd, as its units are shipped: its page, its way to quiltd out of the sandbox, and who may read the token.
. "$QUILTD_SOURCE/tests/kernel/lib.sh"
url_file=/run/quiltweb/url

main_pid() { systemctl show -P MainPID quiltweb; }
becomes_active() {
    systemctl start quiltweb 2>&1
    [ "$(systemctl is-active quiltweb)" = active ] || { systemctl status --no-pager quiltweb; journalctl --no-pager -n 20 -u quiltweb; }
}
another_pid() { [ "$(main_pid)" != "$1" ] && [ "$(main_pid)" != 0 ] && [ "$(systemctl is-active quiltweb)" = active ]; }
comes_back() {
    local before
    before=$(main_pid)
    kill -SEGV "$before"
    within 60 another_pid "$before" || systemctl status --no-pager quiltweb
}
# The first line of the answer to a request.
port=8033
ask() { # address as in /dev/tcp, name for Host, path, token; method and body, where they are not GET and none
    local line
    exec 5<> "/dev/tcp/$1/$port" || return
    printf '%s %s HTTP/1.1\r\nHost: %s:'"$port"'\r\nAuthorization: Bearer %s\r\nContent-Length: %d\r\n\r\n%s' \
        "${5:-GET}" "$3" "$2" "$4" "${#6}" "${6-}" >&5
    read -r -t 60 line <&5
    exec 5>&-
    printf '%s\n' "${line%$'\r'}"
}
token() { sed 's/.*#//' "$url_file"; }
expects() { # status, arguments of ask…
    local got
    got=$(ask "${@:2}" 2>&1)
    [[ $got == "HTTP/1.1 $1"* ]] || echo "got \"$got\", expected $1"
}
has() { # mode, owner's group, file
    local got
    got=$(stat -c '%a %G' "$3")
    [ "$got" = "$1 $2" ] || echo "$3: $got, expected $1 $2"
}
at() { # port, command…
    local port=$1
    "${@:2}"
}
is_url() { grep -qxE 'http://(127\.0\.0\.1|\[::1\]):8033/#[0-9a-f]{32}' "$url_file" || cat "$url_file"; }
# Somebody of this machine, in the group or not.
reads() { setpriv --reuid 4711 --regid 4711 --groups "$1" cat "$url_file" > read.log 2>&1; }
group_alone() {
    reads "$(getent group quiltd | cut -d: -f3)" || cat read.log
    ! reads 4711 || echo "others can read $url_file"
}
not_root() {
    local user
    user=$(stat -c %u "/proc/$(main_pid)")
    [ "$user" -ge 61184 ] || echo "it runs as $user, which is not a dynamic user"
}
apart() { [ "$(readlink "/proc/$(main_pid)/ns/net")" != "$(readlink /proc/1/ns/net)" ] || echo "it has the network of the machine"; }
hardened() {
    local level
    level=$(systemd-analyze security quiltweb --no-pager | sed -n 's/.*exposure level[^:]*: \([0-9.]*\).*/\1/p')
    awk -v e="$level" 'BEGIN { exit !(e == "" || e > 1.0) }' && echo "exposure level $level, expected at most 1.0"
}
off() { systemctl --quiet is-enabled "$1" && echo "$1 is enabled"; }

fact "users are made" succeeds systemd-sysusers
fact "folders are made" succeeds systemd-tmpfiles --create /usr/lib/tmpfiles.d/quiltd.conf
printf '%s\n' 'QUILTD_OPTIONS="--views 4 --view-size 60x80 --threads 2 --target-error 0.1"' > /etc/default/quiltd
fact "the service is off" off quiltweb.service
fact "the socket is off" off quiltweb.socket
for service in bridge events webxr; do fact "the socket $service is off" off "quiltweb-$service.socket"; done
fact "it becomes active" becomes_active
fact "as a user of its own" not_root
fact "without a network" apart
fact "hardened" hardened
fact "there is a URL" is_url
fact "its folder is for the group" has 750 quiltd /run/quiltweb
fact "its file is for the group" has 640 quiltd "$url_file"
fact "the group reads it, and nobody else" group_alone
fact "the page is there" expects 200 127.0.0.1 localhost / none
fact "by IPv6, too" expects 200 ::1 '[::1]' / none
fact "without the token nothing is told" expects 401 127.0.0.1 localhost /api/status none
fact "the socket of quiltd is there" succeeds systemctl --quiet is-active quiltd.socket
fact "with the token quiltd answers, started by its socket" expects 200 127.0.0.1 localhost /api/status "$(token)"
fact "which becomes active" succeeds within 120 systemctl --quiet is-active quiltd
fact "it keeps an upload in memory" expects 201 127.0.0.1 localhost '/api/upload?name=a.txt' "$(token)" PUT words
fact "quiltd says what it cannot show of one" expects 422 127.0.0.1 localhost '/api/quilt?cols=1&rows=1' "$(token)" PUT words
before=$(token)
fact "it comes back after a crash" comes_back
fact "with another token" succeeds test "$(token)" != "$before"
fact "for the group" has 640 quiltd "$url_file"
fact "which quiltd answers" expects 200 127.0.0.1 localhost /api/status "$(token)"
fact "it stops" succeeds systemctl stop quiltweb
fact "the URL is gone" succeeds test ! -e "$url_file"
fact "a request starts it again" expects 200 127.0.0.1 localhost / none
fact "it stops" succeeds systemctl stop quiltweb.service
fact "services for other programs open" succeeds systemctl start quiltweb-bridge.socket quiltweb-webxr.socket
fact "a program of Bridge starts it" at 33334 expects 200 127.0.0.1 localhost / none
fact "events are beside" at 9724 expects 200 ::1 '[::1]' / none
fact "and WebXR" at 11222 expects 200 127.0.0.1 localhost / none
fact "a form of a page is refused" at 33334 expects 405 127.0.0.1 localhost / none POST
fact "the page is there, too" expects 200 127.0.0.1 localhost / none
finish
