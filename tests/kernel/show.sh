# What the cases of the drm device share.
# shellcheck shell=bash
trap '' PIPE # a program that has ended reads no more
# The program, with its standard input at descriptor 3 until show_end.
show_start() { # spec, size, pushes
    rm -f show.in
    mkfifo show.in
    "$QUILTD_BUILD/tests/kernel/drm_show" "$1" "$2" "$3" < show.in > show.log 2>&1 &
    show_pid=$!
    exec 3> show.in
}
shown() {
    within 200 grep -qE '^(shown|failed|LF_E_)' show.log
    grep -q '^shown' show.log || cat show.log
}
# Whether the display shows what the program has pushed. The host may still be writing its picture: asked until it is whole.
pictured() { # name
    screendump "$1"
    within 60 equal "$1" || tail -n 1 show.log
}
equal() {
    local lines
    lines=$(wc -l < show.log)
    echo "$RESULTS/$1.ppm" >&3
    within 60 answered "$lines"
    tail -n 1 show.log | grep -q '^equal'
}
answered() { [ "$(wc -l < show.log)" -gt "$1" ]; }
show_end() {
    exec 3>&-
    wait "$show_pid"
    show_status=$?
}
show_kill() { kill -9 "$show_pid"; }
ended_well() { [ "$show_status" -eq 0 ] || { echo "exit status $show_status"; cat show.log; }; }
