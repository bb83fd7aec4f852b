#!/bin/bash
# Prints times of the page (tests/page/bench.js): bench.sh SCENE, from the Makefile, with O and SRCDIR set.
set -eu
src=$(cd "$SRCDIR" && pwd)
out=$(cd "$O" && pwd)
# shellcheck source=tests/node_modules.sh
. "$src/tests/node_modules.sh"
why=$(browser_missing "$src" "${out%/*}/node")
[ -z "$why" ] || { echo "quiltd: bench-page: $why" >&2 && exit 1; }
BENCH_SCENE=$(realpath "$1")
export BENCH_SCENE QUILTD_BUILD=$out QUILTD_NODE=${out%/*}/node
exec node "$src/tests/page/bench.js"
