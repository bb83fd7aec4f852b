# init: systemd
# memory: 2G
# limit: 2400
# stage: bare
# needs: deb
# The Debian packages of `make deb`, by apt out of their folder: installed, started, showing a scene on a simulated panel, upgraded,
# removed and purged. What is upgraded from are the same packages under an older version.
. "$QUILTD_SOURCE/tests/kernel/lib.sh"
new=$QUILTD_DEB old=$PWD/old
packages='quiltd quiltd-tools quiltd-node quiltd-data'

# The packages once more, as version 0.1.
make_older() {
    local p file
    mkdir -p "$old"
    for p in $packages; do
        file=$(echo "$new/${p}"_[0-9]*.deb)
        dpkg-deb -R "$file" tree || return
        sed -i -e 's/^Version: .*/Version: 0.1/' -e 's/(= [^)]*)/(= 0.1)/' tree/DEBIAN/control
        dpkg-deb -Znone -b tree "$old/$p.deb" || return
        rm -rf tree
    done
    (cd "$old" && apt-ftparchive packages . > Packages)
}
apt_here() {
    DEBIAN_FRONTEND=noninteractive apt-get -q -y -o Dir::Etc::SourceList="$PWD/sources.list" -o Dir::Etc::SourceParts=- \
        -o Dpkg::Options::=--force-confold -o APT::Install-Recommends=false "$@"
}
apt_from() { # folder, words…
    echo "deb [trusted=yes] file:$1 ./" > sources.list
    apt_here update && apt_here "${@:2}"
}
absent() { ! command -v quiltd || echo "quiltd is there before it is installed"; }
version_is() { # version
    local v
    v=$(dpkg-query -W -f '${Version}' quiltd)
    [ "$v" = "$1" ] || echo "version $v, expected $1"
}
is_active() {
    within 120 systemctl --quiet is-active quiltd || systemctl status --no-pager quiltd
    systemctl --quiet is-active quiltd.socket || systemctl status --no-pager quiltd.socket
    systemctl --quiet is-enabled quiltd || echo "it is not enabled"
    ! systemctl --quiet is-enabled quiltweb.service quiltweb.socket || echo "quiltweb is enabled"
    ! systemctl --quiet is-active quiltweb.service quiltweb.socket || echo "quiltweb runs"
}
main_pid() { systemctl show -P MainPID quiltd; }
restarted() { [ "$(main_pid)" != "$1" ] && [ "$(main_pid)" != 0 ]; } # its process before
shows() { within 120 test -s /var/lib/quiltd/sim/panel.png || journalctl --no-pager -n 20 -u quiltd; }
keeps() { # files
    local f
    for f in "$@"; do [ -e "$f" ] || echo "$f is gone"; done
}
has_no() { # files
    local f
    for f in "$@"; do [ ! -e "$f" ] || echo "$f is there"; done
}
not_running() { [ -z "$(pgrep -x quiltd)" ] || pgrep -lx quiltd; }

rm -f /usr/sbin/policy-rc.d # of a container, which starts no services
fact "nothing is installed" absent
fact "older packages are made" succeeds make_older
fact "apt installs them" succeeds apt_from "$old" install quiltd
fact "their version is the older one" version_is 0.1
fact "the service is active" is_active
fact "users are made" succeeds id quiltd
printf '%s\n' 'QUILTD_SCENE=/usr/share/quiltd/scenes/fog.json' \
    'QUILTD_OPTIONS="--device sim:/var/lib/quiltd/sim --views 4 --view-size 60x80 --target-error 0.1"' > /etc/default/quiltd
mkdir /var/lib/quiltd/sim && chown quiltd: /var/lib/quiltd/sim
fact "it is restarted" succeeds systemctl restart quiltd
fact "it shows a scene on a simulated panel" shows
fact "and answers" succeeds timeout 60 quiltctl status
echo picture > /var/lib/quiltd/export/kept.png
before=$(main_pid)
fact "apt upgrades it" succeeds apt_from "$new" install quiltd
fact "its version is the new one" version_is "$(dpkg-deb -f "$(echo "$new"/quiltd_[0-9]*.deb)" Version)"
fact "the new one runs" succeeds within 60 restarted "$before"
fact "and is active" is_active
fact "what was configured is kept" succeeds grep -q sim: /etc/default/quiltd
fact "it answers" succeeds timeout 60 quiltctl status
fact "a file's readers are there" succeeds timeout 60 quiltctl scene.load file=/usr/share/quiltd/scenes/cloud.json
fact "apt removes it" succeeds apt_from "$new" remove $packages
fact "nothing of it runs" not_running
fact "programs are gone" has_no /usr/bin/quiltd /usr/bin/quiltctl /usr/libexec/quiltd /usr/share/quiltd
fact "configuration and pictures are kept" keeps /etc/default/quiltd /var/lib/quiltd/export/kept.png
fact "apt purges it" succeeds apt_from "$new" purge $packages
fact "what it kept for itself is gone" has_no /etc/default/quiltd /var/cache/quiltd /run/quiltd
fact "pictures are left" keeps /var/lib/quiltd/export/kept.png
finish
