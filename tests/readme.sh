#!/bin/bash
# Every command of README.md, as it stands there, in a folder with what a reader would have: a model.
# A line that starts quiltd is left running, as in a terminal of its own, until the next heading or a line that renders by itself.
set -u
src=$(cd "${QUILTD_SOURCE:-.}" && pwd)
out=$(cd "${QUILTD_BUILD:-build/release}" && pwd)
# shellcheck source=tests/report.sh
. "$src/tests/report.sh"

top=$(mktemp -d)
daemon=''
stop_daemon() {
    [ -n "$daemon" ] || return 0
    kill "$daemon" 2> /dev/null
    wait "$daemon" 2> /dev/null
    daemon=''
}
trap 'stop_daemon; rm -rf "$top"' EXIT
# As they stand there but for the size of views, a sixteenth of the pixels: what is asked is whether they work.
mkdir "$top/bin"
for program in quiltd quiltrender; do
    printf '%s\n' '#!/bin/bash' \
        "case \" \$* \" in *' --chart '* | *' --panel '* | *' --print '*) size=() ;; *) size=(--view-size 105x140) ;; esac" \
        "exec '$out/$program' \"\$@\" \"\${size[@]}\"" > "$top/bin/$program"
    chmod 755 "$top/bin/$program"
done
export PATH="$top/bin:$out:$PATH" HOME=$top XDG_RUNTIME_DIR=$top/run
unset QUILTD_SOCKET
mkdir -m 700 "$XDG_RUNTIME_DIR"
cd "$top" || exit 1

# The file that the README calls helmet.glb.
report "the reader's model is copied" "$(cp "$src/scenes/still.glb" helmet.glb 2>&1)"

# Run elsewhere: make check-distro (what installs packages, or is this test itself).
elsewhere() {
    case $1 in make\ * | sudo\ * | "echo 'deb "*) ;; *) return 1 ;; esac
}
# Exit statuses that are an answer, not a failure: doctor finds no panel on this machine.
expected() { # command, status
    [ "$2" -eq 0 ] || { [ "$2" -eq 1 ] && [ "$1" = "quiltctl doctor" ]; }
}
start_daemon() { # command
    stop_daemon
    eval "exec $1" > daemon.log 2>&1 &
    daemon=$!
    until quiltctl hello > /dev/null 2>&1; do
        kill -0 "$daemon" 2> /dev/null || return 1
        sleep 0.1
    done
}
# quiltrender and quiltbench need no daemon, which would take processor time from them.
run() { # command
    case $1 in
    quiltd\ *) start_daemon "$1" || cat daemon.log ;;
    *)
        case $1 in quiltrender\ * | quiltbench\ *) stop_daemon ;; esac
        (eval "$1") > log 2>&1
        local rc=$?
        expected "$1" "$rc" || { echo "exit status $rc" && tail -n 5 log; }
        ;;
    esac
}

commands=0 document=''
while IFS= read -r line; do
    case $line in
    '#'*) stop_daemon ;;
    '    { "quiltd"'*) document=1 && printf '%s\n' "$line" > scene.json ;;
    '    '*)
        if [ -n "$document" ]; then
            printf '%s\n' "$line" >> scene.json
            continue
        fi
        command=$(printf '%s\n' "$line" | sed -E 's/^ +//; s/ +# .*$//')
        elsewhere "$command" && continue
        commands=$((commands + 1))
        run "$command" > complaints 2>&1 # not in a subshell, which would lose the daemon
        report "$command" "$(cat complaints)"
        ;;
    *) document='' ;;
    esac
done < "$src/README.md"
stop_daemon
report "the README has commands to run" "$([ "$commands" -ge 10 ] || echo "$commands were found")"
report "the README is at most 100 lines" "$([ "$(wc -l < "$src/README.md")" -le 100 ] || wc -l "$src/README.md")"
end
