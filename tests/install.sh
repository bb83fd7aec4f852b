#!/bin/bash
# make install into an empty folder: what has to lie there does, what is started there starts, and systemd accepts the units.
set -u
src=${QUILTD_SOURCE:-.}
out=${QUILTD_BUILD:-build/release}

# shellcheck source=tests/report.sh
. "$src/tests/report.sh"

top=$(mktemp -d)
trap 'rm -rf "$top"' EXIT
prefix=$top/usr
# the variables that this make was called with, without its jobs
MAKEFLAGS=$(printf '%s' "${MAKEFLAGS-}" | sed -E 's/(^| )-?j[0-9]*( |$)/ /g; s/--jobserver[^ ]*//g; s/(^| )-j[0-9]*//g')
export MAKEFLAGS
# shellcheck disable=SC2086  # MAKE_AGAIN is a list of words
install() { ${MAKE_AGAIN:-make -C "$src" O="$out"} install "$@"; }

if ! install PREFIX="$prefix" > "$top/log" 2>&1; then
    report install "$(tail -n 20 "$top/log")"
    echo "[  PASSED  ] $passed test(s)."
    echo "[  FAILED  ] $failed test(s)."
    exit 1
fi

missing() {
    local f
    for f in bin/quiltd bin/quiltctl bin/quiltrender bin/quiltfarm bin/quiltmerge bin/quiltprint bin/quiltsim bin/quiltbench bin/quiltweb libexec/quiltd/quiltimport libexec/quiltd/quiltimport-vdb libexec/quiltd/quiltimport-picture share/quiltd/docs/scene.schema.json share/quiltd/docs/reference/scene-format.md share/quiltd/docs/reference/protocol.md share/quiltd/docs/reference/client.py share/quiltd/docs/guide/prints.md \
        share/quiltd/scenes/first-light.json share/quiltd/lenses/nominal-60.json share/quiltd/printers/epson-720.json share/man/man1/quiltd.1 share/man/man1/quiltctl.1 share/man/man1/quiltrender.1 share/man/man1/quiltfarm.1 share/man/man1/quiltmerge.1 share/man/man1/quiltprint.1 share/man/man1/quiltsim.1 share/man/man1/quiltweb.1 \
        share/bash-completion/completions/quilt{d,ctl,render,farm,print,sim,bench,web} share/zsh/vendor-completions/_quilt{d,ctl,render,farm,print,sim,bench,web} \
        share/fish/vendor_completions.d/quilt{d,ctl,render,farm,print,sim,bench,web}.fish \
        lib/systemd/system/quiltd.{service,socket} lib/systemd/system/quiltweb.{service,socket} lib/systemd/system/quiltweb-{bridge,events,webxr}.socket \
        lib/systemd/user/quiltweb.{service,socket} lib/systemd/user/quiltweb-{bridge,events,webxr,nng}.socket lib/sysusers.d/quiltd.conf \
        lib/tmpfiles.d/quiltd.conf lib/udev/rules.d/70-quiltd.rules share/polkit-1/rules.d/60-quiltd.rules; do
        [ -s "$prefix/$f" ] || echo "$f"
    done
}
report "everything is installed" "$(missing)"

# Lab notes and the sources are not installed.
dead_links() { # folder of pages
    local page target
    find "$1" -name '*.md' | while read -r page; do
        grep -oE '\]\([^)#: ]+\.md' "$page" | sed 's/^](//' | grep -vE "/lab/|(README|CONTRIBUTING|CHANGELOG)[.]md" | while read -r target; do
            [ -e "$(dirname "$page")/$target" ] || echo "$page: $target"
        done
    done
}
report "pages that are installed lead to pages that are" "$(dead_links "$prefix/share/quiltd/docs")"
printf '[a](gone.md)' > "$top/breach.md"
report "a dead link would be seen" "$(dead_links "$top" | grep -q gone || echo 'not seen')"

# g++ is part of build-essential, which every package is built with
undeclared() {
    local p
    for p in $("$src/.ci/deps" list build); do
        [ "$p" = g++ ] || grep -qE "^ +$p( |,|\$)" "$src/debian/control" || echo "$p"
    done
}
report "the Debian package is built with what .ci/deps installs" "$(undeclared)"

unfilled() { grep -rnE '@[A-Z]+@' "$prefix/lib"; }
report "no placeholder is left in the units" "$(unfilled)"

# A picture that is to stay: memory left for others, started again after every failure and however often, a reader's end not the daemon's.
lasting() {
    local line
    for line in MemoryMax=85% OOMPolicy=continue Restart=on-failure StartLimitIntervalSec=0; do
        grep -qxF "$line" "$prefix/lib/systemd/system/quiltd.service" || echo "no $line"
    done
}
report "the service's limits fit" "$(lasting)"

# What readers of files call to hold themselves to less lies in no group of calls that the unit has.
lockable() {
    local call
    for call in setrlimit prlimit64 seccomp capset landlock_create_ruleset landlock_restrict_self; do
        grep -q "^SystemCallFilter=.*\<$call\>" "$prefix/lib/systemd/system/quiltd.service" || echo "SystemCallFilter= lacks $call"
    done
}
report "the service lets readers give up rights" "$(lockable)"

startable() {
    local p words
    for p in quiltd quiltctl quiltrender quiltfarm quiltmerge quiltprint quiltsim quiltbench quiltweb; do
        words=$("$prefix/bin/$p" --version 2>&1) || echo "$p --version: $words"
        words=$("$prefix/bin/$p" --help 2>&1) || echo "$p --help: $words"
        "$prefix/bin/$p" --no-such-option > /dev/null 2>&1
        [ $? -eq 2 ] || echo "$p --no-such-option: exit status not 2"
    done
}
report "installed programs start and know their usage" "$(startable)"

# The shipped profiles are found from where the programs are installed.
profiles() { env -u QUILTD_PROFILES XDG_CONFIG_HOME="$top" "$prefix/bin/quiltprint" list; }
report "installed profiles are found" "$(profiles | grep -q "^lens  *nominal-60 " || profiles 2>&1)"

# Scenes name their files relative to themselves: away from the source tree they must be whole.
whole_scenes() {
    local scene words few
    for scene in "$prefix"/share/quiltd/scenes/*.json; do
        few=(-o "$top/out.png" --views 1 --quilt 1x1)
        grep -q '"rows"' "$scene" && few=(-o "$top/out/" --camera-rows 0:0)
        words=$(timeout 120 "$prefix/bin/quiltrender" "$scene" "${few[@]}" --view-size 24x32 --passes 1 2>&1) || echo "$scene: $words"
        rm -rf "$top"/out*
    done
}
report "installed scenes render" "$(whole_scenes)"

staged() {
    install PREFIX=/usr DESTDIR="$top/stage" > "$top/log" 2>&1 || tail -n 20 "$top/log"
    [ -x "$top/stage/usr/bin/quiltd" ] || echo "no $top/stage/usr/bin/quiltd"
    grep -rn "$top" "$top/stage/usr/lib"
}
report "DESTDIR is where, PREFIX is what for" "$(staged)"

if command -v systemd-analyze > /dev/null 2>&1; then
    units=("$prefix"/lib/systemd/system/quilt*)
    report "systemd accepts the units" "$(systemd-analyze verify --man=no "${units[@]}" 2>&1 | grep -i quilt)"
    units=("$prefix"/lib/systemd/user/quilt*)
    report "systemd accepts the units for a session" "$(XDG_RUNTIME_DIR=$top systemd-analyze --user verify --man=no "${units[@]}" 2>&1 | grep -i quilt)"
    hardened() { # unit, most exposure
        systemd-analyze security --offline=true "$prefix/lib/systemd/system/$1" 2> /dev/null | sed -n 's/.*exposure level[^:]*: \([0-9.]*\).*/\1/p' |
            awk -v most="$2" '{ n++; if ($1 > most) print "exposure " $1 ", expected at most " most } END { if (n != 1) print "no exposure was told" }'
    }
    report "the service is hardened" "$(hardened quiltd.service 2.0)"
    report "the gateway to browsers is hardened more" "$(hardened quiltweb.service 1.0)"
    report "too much exposure would be seen" "$(hardened quiltd.service 0.1 | grep -q expected || echo 'not seen')"
else
    for words in "systemd accepts the units" "systemd accepts the units for a session" "the service is hardened" "the gateway to browsers is hardened more" "too much exposure would be seen"; do
        skip "$words" "no systemd-analyze"
    done
fi
# Browsers reach it: what its unit must not lose, whatever the sum of its other lines is.
closed() {
    local line
    for line in DynamicUser=yes Group=quiltd PrivateNetwork=yes PrivateDevices=yes IPAddressDeny=any IPAddressAllow=localhost RestrictAddressFamilies=AF_UNIX ProtectSystem=strict MemoryMax=3500M; do
        grep -qxF "$line" "$prefix/lib/systemd/system/quiltweb.service" || echo "no $line"
    done
    grep -h '^ListenStream=' "$prefix"/lib/systemd/*/quiltweb*.socket | grep -vxE 'ListenStream=((127\.0\.0\.1|\[::1\]):(8033|33334|9724|11222)|/tmp/holoplay-driver\.ipc)'
}
report "the gateway's units keep it on this machine" "$(closed)"
# quiltweb knows a service by the name of its socket (daemon/web/quiltweb.c), and all sockets are for the one service.
services() {
    local folder name file line
    for folder in system user; do
        for name in bridge events webxr nng; do
            file=$prefix/lib/systemd/$folder/quiltweb-$name.socket
            [ "$folder $name" != "system nng" ] || continue # it would belong to root
            for line in "FileDescriptorName=$name" Service=quiltweb.service; do
                grep -qxF "$line" "$file" || echo "$folder/quiltweb-$name.socket: no $line"
            done
        done
    done
    grep -qxF SocketMode=0600 "$prefix/lib/systemd/user/quiltweb-nng.socket" || echo "others may open nng's socket"
    grep -qF "\$QUILTWEB_OPTIONS" "$prefix"/lib/systemd/system/quiltweb.service || echo "no way to --allow-origin"
    for line in RestrictAddressFamilies=AF_UNIX NoNewPrivileges=yes MemoryDenyWriteExecute=yes MemoryMax=3500M; do
        grep -qxF "$line" "$prefix/lib/systemd/user/quiltweb.service" || echo "for a session: no $line"
    done
}
report "each service of the gateway has its socket" "$(services)"
if command -v groff > /dev/null 2>&1; then
    report "groff accepts the man pages" "$(for m in "$prefix"/share/man/man*/*.[1-9]; do groff -ww -Tutf8 -man "$m" 2>&1 > /dev/null; done)"
else
    skip "groff accepts the man pages" "no groff"
fi

end
