# shellcheck shell=bash
# Runs the commands of a page of documentation as they stand, for the tests that source this: set_up_reader, then run_page for each.
# A line that starts quiltd is left running, as in a terminal of its own, until another one starts or a line renders by itself.

src=$(cd "${QUILTD_SOURCE:-.}" && pwd)
out=$(cd "${QUILTD_BUILD:-build/release}" && pwd)
# shellcheck source=tests/report.sh
. "$src/tests/report.sh"

top=$(mktemp -d)
daemon='' daemon_command='quiltd helmet.glb'
stop_daemon() {
    [ -n "$daemon" ] || return 0
    kill "$daemon" 2> /dev/null
    wait "$daemon" 2> /dev/null
    daemon=''
}
trap 'stop_daemon; rm -rf "$top"' EXIT

# What stands before the programs in the path: the same command with small numbers, since all that is asked is whether it works.
smaller() {
    cat << 'END'
#!/bin/bash
case " $* " in *' --chart '* | *' --simulate '*) exec "$PROGRAMS/quiltrender" "$@" ;; esac
program=${0##*/} option='' length='' size='' device='' arguments=()
for word in "$@"; do
    # there is no cluster here, and options of sbatch and ssh name machines
    case "$program $1 $word" in
    'quiltfarm plan slurm') word=parallel ;;
    quiltfarm\ submit\ -- | quiltfarm\ resume\ --) break ;;
    esac
    case $option in
    --view-size) word=$VIEW_SIZE ;;
    --spp | --passes) word=1 ;;
    --frames) word=1:2 ;;
    --turntable) word=2 ;;
    --camera-rows) word=0:1 ;;
    --print-size) word=30x20 ;;
    --time) word=0.02 ;;
    --seeds | --budgets) word=2 ;;
    esac
    option=$word
    case $word in
    --spp | --passes | --time) length=1 ;;
    --view-size | --print-size) size=1 ;;
    --state-info | --panel) size=1 length=1 ;;
    --device) device=1 ;;
    esac
    arguments+=("$word")
done
case $1 in photos/ | photo.jpg | *_qs*.png | *_rgbd.png | holiday.jpg | album/) size=1 length=1 ;; esac # a finished image
case "$program $1" in
quiltd\ *) arguments+=(--threads 1 --target-error 0.5) && [ -n "$device" ] || arguments+=(--device sim:panel) ;;
quiltrender\ *) [ -n "$length" ] || arguments+=(--passes 1) ;;
quiltsim\ *) arguments+=(--listen 0) size=1 ;;
quiltbench\ curve) arguments+=(--reference-spp 2) size=1 ;;
quiltfarm\ plan) [ -n "$length" ] || arguments+=(--passes 1) ;;
*) size=1 ;;
esac
case " $*" in *' scenes/hologram.json '*' --hologram '*) arguments+=(--camera-rows 0:1) ;; esac # two rows of 114
[ -n "$size" ] || arguments+=(--view-size "$VIEW_SIZE")
exec "$PROGRAMS/$program" "${arguments[@]}"
END
}
set_up_reader() { # folder, size of views: the reader's programs, home, session and model
    export PROGRAMS=$out VIEW_SIZE=$2 HOME=$1 XDG_RUNTIME_DIR=$1/run PATH="$1/bin:$out:$PATH" PYTHONPATH=$src/clients/python
    unset QUILTD_SOCKET XDG_CONFIG_HOME
    mkdir -p "$1/bin"
    mkdir -m 700 "$XDG_RUNTIME_DIR"
    cd "$1" || exit 1
    local program
    for program in quiltd quiltrender quiltbench quiltsim quiltfarm; do
        smaller > "bin/$program"
        chmod 755 "bin/$program"
    done
    report "the reader's model is copied" "$(cp "$src/scenes/still.glb" helmet.glb 2>&1)"
}

# What cannot run here: it installs or builds something (make check-distro does that), needs root or systemd, needs an installed quiltd,
# is a file of settings, is a formula, or is a part of a scene.
elsewhere() { # command
    case $1 in
    *\ --read-chart\ *) ;;
    make\ * | *' make '* | *\ -m\ pip\ * | sudo\ * | systemctl\ * | journalctl\ * | "echo 'deb "*) ;;
    podman\ * | apptainer\ * | scp\ * | *\ \~/bin*) ;;
    *\ /usr/share/*) ;;
    python3\ *) ! command -v python3 > /dev/null ;;
    [A-Z]*=*) ;;
    [a-z]*\ =\ *) ;;
    '"'*) ;;
    *) return 1 ;;
    esac
}
# Exit statuses that are an answer, not a failure: doctor finds no panel on this machine.
expected() { # command, status
    [ "$2" -eq 0 ] || { [ "$2" -eq 1 ] && [ "$1" = "quiltctl doctor" ]; }
}
start_daemon() { # command
    stop_daemon
    daemon_command=$1
    eval "exec $1" > daemon.log 2>&1 &
    daemon=$!
    until quiltctl hello > /dev/null 2>&1; do
        kill -0 "$daemon" 2> /dev/null || return 1
        sleep 0.1
    done
    quiltctl wait for=coarse timeout=120 > /dev/null # a reader goes on when there is an image
}
# It is a server: it has to say how to plug its panel in.
start_simulator() { # command
    local simulator
    : > sim.log
    eval "exec $1" > sim.log 2>&1 < <(sleep 600) &
    simulator=$!
    until grep -q ' attach -r ' sim.log; do
        kill -0 "$simulator" 2> /dev/null || break
        sleep 0.1
    done
    kill "$simulator" 2> /dev/null
    wait "$simulator" 2> /dev/null
    grep -q ' attach -r ' sim.log
}
# A server, too, at ports that are free: it has to print its URL.
start_gateway() { # command
    local gateway command=$1
    command=${command/ --bridge/ --bridge=0,0}
    command=${command/ --webxr/ --webxr=0}
    command=${command/ --nng/ --nng=nng.ipc}
    : > web.log
    eval "exec $command --listen 127.0.0.1:0" > web.log 2>&1 &
    gateway=$!
    until grep -q '^https\?://' web.log; do
        kill -0 "$gateway" 2> /dev/null || break
        sleep 0.1
    done
    kill "$gateway" 2> /dev/null
    wait "$gateway" 2> /dev/null
    grep -q '^https\?://' web.log
}
needs_daemon() { # command
    case $1 in *quiltctl\ doctor | *--help) return 1 ;; *quiltctl\ * | python3\ *) ;; *) return 1 ;; esac
}
# quiltrender and quiltbench need no daemon, which would take processor time from them.
run() { # command
    case $1 in
    quiltd\ *) start_daemon "$1" || cat daemon.log ;;
    quiltsim\ *) start_simulator "$1" || cat sim.log ;;
    quiltweb | quiltweb\ *) start_gateway "$1" || cat web.log ;;
    export\ *) eval "$1" ;;
    *)
        if [[ $1 =~ ^[a-z_]+=[^\ ]*$ ]]; then
            eval "$1"
            return
        fi
        case $1 in quiltrender\ * | quiltbench\ * | quiltfarm\ *) stop_daemon ;; esac
        if needs_daemon "$1" && [ -z "$daemon" ]; then start_daemon "$daemon_command" || cat daemon.log; fi
        (eval "$1") > log 2>&1
        local rc=$?
        expected "$1" "$rc" || { echo "exit status $rc" && tail -n 5 log; }
        ;;
    esac
}

# A block of code is commands, or the file that the sentence before it names: "Save this as `NAME`".
commands=0
run_page() { # file, prefix of the names of tests, what to do at a heading
    local line text='' file='' fence='' command=''
    while IFS= read -r line <&3; do
        case $line in
        '```'*)
            if [ -z "$fence" ]; then
                fence=${file:-/dev/null}
                : > "$fence"
            else
                fence='' file=''
            fi
            continue
            ;;
        esac
        if [ -n "$fence" ]; then
            printf '%s\n' "$line" >> "$fence"
            continue
        fi
        case $line in
        '#'*) $3 ;;
        '') ;;
        '    '*)
            text=$(printf '%s\n' "$line" | sed -E 's/^ +//; s/ +# .*$//')
            case $text in
            '{ "quiltd"'*)
                file=${file:-scene.json}
                : > "$file"
                ;;
            esac
            if [ -n "$file" ]; then
                printf '%s\n' "$text" >> "$file"
                continue
            fi
            command=${command:+$command$'\n'}$text
            if elsewhere "$command"; then
                command=''
                continue
            fi
            bash -n -c "$command" 2> /dev/null || continue # goes on in the next line
            commands=$((commands + 1))
            command=${command//\/tmp\//$top/}
            run "${command//\/var\/lib\//$top/}" > complaints 2>&1 # not in a subshell, which would lose the daemon
            report "$2${command//$'\n'/; }" "$(cat complaints)"
            command=''
            ;;
        *)
            file=''
            case $line in *'Save '*'`'*) file=$(printf '%s\n' "$line" | sed -nE 's/.*Save [a-z]+ as `([^`]+)`.*/\1/p') ;; esac
            ;;
        esac
    done 3< "$1"
    [ -z "$command" ] || report "$2$command" "it is not a whole command"
    stop_daemon
}
