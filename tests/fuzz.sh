#!/bin/bash
# Runs fuzz targets, as many at a time as there are processors: tests/fuzz.sh PROGRAM…   from the Makefile, with O set. $FUZZ_SECONDS
# each (60). Seeds are in tests/fuzz/corpus/NAME, what a run learns beside the program; an input that breaks something is kept as
# $O/crash-NAME-….
set -u
src=$(cd "$(dirname "$0")/.." && pwd)
seconds=${FUZZ_SECONDS:-60}

fuzz() { # program
    local name=${1##*/fuzz_} log=$1.log learnt=$1.corpus seeds runs covered
    seeds=$src/tests/fuzz/corpus/$name
    [ -d "$seeds" ] || seeds=
    mkdir -p "$learnt"
    if ! "$1" -max_total_time="$seconds" -timeout=10 -rss_limit_mb=2048 -max_len=8192 -print_final_stats=1 \
        -artifact_prefix="${O:-build/fuzz}/crash-$name-" "$learnt" ${seeds:+"$seeds"} > "$log" 2>&1; then
        echo "fuzz: $name: broken:"
        grep -v -E '^(INFO|#[0-9]|stat::)' "$log" | head -n 60
        return 1
    fi
    runs=$(sed -n 's/^stat::number_of_executed_units: *//p' "$log")
    covered=$(sed -n 's/.*DONE *cov: *\([0-9]*\).*/\1/p' "$log")
    echo "fuzz: $name: nothing found in $seconds s, $runs inputs, $covered edges"
}
export -f fuzz
export src seconds

printf '%s\0' "$@" | xargs -0 -r -n 1 -P "$(nproc 2> /dev/null || echo 1)" bash -uc 'fuzz "$1"' fuzz
