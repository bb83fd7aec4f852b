#!/bin/bash
# Runs fuzz targets one after the other: tests/fuzz.sh PROGRAM…   from the Makefile, with O set. $FUZZ_SECONDS each (60). Seeds are in
# tests/fuzz/corpus/NAME, what a run learns beside the program; an input that breaks something is kept as $O/crash-NAME-….
set -u
src=$(cd "$(dirname "$0")/.." && pwd)
seconds=${FUZZ_SECONDS:-60}
rc=0
for program in "$@"; do
    name=${program##*/fuzz_}
    log=$program.log
    learnt=$program.corpus
    seeds=$src/tests/fuzz/corpus/$name
    [ -d "$seeds" ] || seeds=
    mkdir -p "$learnt"
    if "$program" -max_total_time="$seconds" -timeout=10 -rss_limit_mb=2048 -max_len=8192 -print_final_stats=1 \
        -artifact_prefix="${O:-build/fuzz}/crash-$name-" "$learnt" ${seeds:+"$seeds"} > "$log" 2>&1; then
        runs=$(sed -n 's/^stat::number_of_executed_units: *//p' "$log")
        covered=$(sed -n 's/.*DONE *cov: *\([0-9]*\).*/\1/p' "$log")
        echo "fuzz: $name: nothing found in $seconds s, $runs inputs, $covered edges"
    else
        echo "fuzz: $name: broken:"
        grep -v -E '^(INFO|#[0-9]|stat::)' "$log" | head -n 60
        rc=1
    fi
done
exit $rc
