# What the cases share. A case runs in the guest as root, in an empty folder; its facts are functions that print nothing when they
# hold and complaints when not, as in tests/install.sh; it ends with `finish`.
# shellcheck shell=bash
passed=0 failed=0
fact() { # words, command…: holds when the command prints nothing; not in a subshell, so that it may start things
    local words=$1 since=${EPOCHREALTIME/./} took
    shift
    "$@" > fact.out 2>&1
    if [ ! -s fact.out ]; then
        passed=$((passed + 1))
        took=$(((${EPOCHREALTIME/./} - since) / 100000))
        echo "[       OK ] $words ($((took / 10)).$((took % 10)) s)"
    else
        failed=$((failed + 1))
        echo "[  ERROR   ] --- $words:"
        head -n 40 fact.out
    fi
}
succeeds() { local words; words=$("$@" 2>&1) || echo "exit status $?: $words"; }
finish() {
    echo "$passed passed, $failed failed"
    [ "$failed" -eq 0 ]
    exit
}
# Until the command succeeds, at most so many seconds.
within() { # seconds, command…
    local end=$((SECONDS + $1))
    shift
    until "$@" > /dev/null 2>&1; do
        [ "$SECONDS" -lt "$end" ] || return 1
        sleep 0.1
    done
}
# The nodes of the panel; nothing = none. Without other programs: starting one takes long in an emulated guest.
hid_node() {
    local node
    for node in /dev/hidraw*; do
        [ ! -e "$node" ] || echo "$node"
    done
}
usb_node() {
    local d vendor bus number
    for d in /sys/bus/usb/devices/*-*; do
        { read -r vendor < "$d/idVendor" && read -r bus < "$d/busnum" && read -r number < "$d/devnum"; } 2> /dev/null || continue
        case $vendor in
        04d8 | 1d50) printf '/dev/bus/usb/%03d/%03d\n' "$bus" "$number" ;;
        esac
    done
}
owner() { stat -c '%U %G %a' "$1" 2> /dev/null; } # node
# Whether these nodes (hid, usb) are there and udev has given them to the group.
granted() {
    local kind node
    for kind in "$@"; do
        node=$("${kind}_node")
        [ -n "$node" ] && [ "$(stat -c %G "$node")" = quiltd ] || return 1
    done
}
# The simulated panel, with its standard input at descriptor 3 and its answers in sim.log.
sim_start() { # options of quiltsim
    rm -f sim.in
    mkfifo sim.in
    "$QUILTD_BUILD/quiltsim" "$@" < sim.in > sim.log 2>&1 &
    sim_pid=$!
    exec 3> sim.in
    within 60 grep -q . sim.log || echo "quiltsim says nothing"
}
sim_tell() { # line: waits for its answer
    local before
    before=$(grep -cE '^(ok$|error: )' sim.log)
    echo "$1" >&3
    within 60 sim_answered "$before" || echo "quiltsim does not answer to: $1"
    grep -E '^error: ' sim.log | tail -n 1
}
sim_answered() { [ "$(grep -cE '^(ok$|error: )' sim.log)" -gt "$1" ]; }
sim_stop() {
    sim_tell quit
    exec 3>&-
    wait "$sim_pid"
}
# The host takes a picture of what a display of the guest shows: $RESULTS/NAME.ppm. The display is that of the machine's `# qemu:` line.
screendump() { # name
    : > "$RESULTS/$1.ask"
    within 60 test ! -e "$RESULTS/$1.ask" || echo "the host takes no picture"
}
presses() { # the buttons to press on the simulated panel; they arrive in their order
    local reader b
    "$QUILTD_BUILD/tests/kernel/panel" buttons $# > pressed 2> watching &
    reader=$!
    within 60 grep -q watched watching
    for b in "$@"; do sim_tell "press $b"; done
    wait $reader || { echo "exit status $?"; cat watching; }
    [ "$(paste -sd' ' pressed)" = "$*" ] || cat pressed
}
