#!/bin/bash
# The parts that need no library, built for arm64 and run by an emulator: their tests pass, the NEON kernels among them, and what they
# make of pseudo-random inputs has the same bytes as here, whatever the kernels. make check-arm64 installs what this needs; else it is
# skipped. QUILTD_LONG=1 runs the tests that take the emulator minutes too.
set -u
src=${QUILTD_SOURCE:-.}
out=${QUILTD_BUILD:-build/release}
cc=${ARM64_CC:-aarch64-linux-gnu-gcc}
ar=${ARM64_AR:-aarch64-linux-gnu-ar}
emulator=${ARM64_RUN:-qemu-aarch64}
slow=the_formulas_agree_with_themselves_in_higher_precision,the_interlacer_matches_the_formulas_on_whole_panels,single_points_are_uniform

no_chance() {
    echo "skipped: $1"
    exit 77
}
[ "${BUILD:-release}" = release ] || no_chance "built for release alone"
[ "$(uname -m)" = x86_64 ] || no_chance "compares with x86-64, this is $(uname -m)"
for tool in "$cc" "$emulator"; do
    command -v "${tool##* }" > /dev/null 2>&1 || no_chance "no ${tool##* } (make check-arm64 installs it)"
done

# shellcheck source=tests/report.sh
. "$src/tests/report.sh"

top=$(mktemp -d)
trap 'rm -rf "$top"' EXIT
# a make of its own: nothing that the one above was told is for another machine
build() {
    env -u MAKEFLAGS -u MFLAGS -u CFLAGS -u CPPFLAGS make --no-print-directory -C "$src" -j "$(nproc)" O="$out/arm64" BUILD=release PORTABLE=1 \
        CC="$cc" CXX="$cc" AR="$ar" CFLAGS=-g1 LDFLAGS=-static "$@"
}
if ! build portable > "$top/log" 2>&1; then
    report "the portable parts compile for arm64" "$(tail -n 30 "$top/log")"
    end
fi
report "the portable parts compile for arm64" "$(grep -A5 warning: "$top/log")"

# their own reports are added up by tests/run
[ -n "${QUILTD_LONG-}" ] && slow=
programs=$(build -s portable-tests)
echo "$programs" | tr ' ' '\n' | LF_TEST_SKIP=$slow xargs -P "$(nproc)" -I{} sh -c '"$1" "$2" > "$3/${2##*/}.log" 2>&1' - "$emulator" {} "$top"
for program in $programs; do
    log=$top/${program##*/}.log
    cat "$log"
    grep -q '^\[  PASSED  \]' "$log" || report "${program##*/}" "no results"
done

# what a results program printed, and which kernels it used
results() { # name, kernels, words of the command
    local name=$1 kernels=$2
    shift 2
    "$@" > "$top/$name" 2> "$top/$name.kernels"
    if [ "$(wc -l < "$top/$name")" -lt 4 ] || ! grep -qx "kernels: $kernels" "$top/$name.kernels"; then
        report "results, $name" "$(cat "$top/$name.kernels" "$top/$name")"
    fi
}
results here '.*' "$out/tests/arm64/results"
results arm64 neon "$emulator" "$out/arm64/tests/arm64/results"
results here-c c env LF_CPU=c "$out/tests/arm64/results" kernels
results arm64-c c env LF_CPU=c "$emulator" "$out/arm64/tests/arm64/results" kernels
head -n "$(wc -l < "$top/here-c")" "$top/here" > "$top/here-kernels"
report "arm64, with NEON, has the results of this machine" "$(diff "$top/here" "$top/arm64")"
report "plain C has the results of this machine's best kernels" "$(diff "$top/here-kernels" "$top/here-c")"
report "plain C has the same results on arm64" "$(diff "$top/here-kernels" "$top/arm64-c")"

# the comparison can fail: plain C with fused multiply-adds is another kernel
fused_is_noticed() {
    $cc -std=c11 -D_GNU_SOURCE -O3 -ffp-contract=fast -I"$src" -idirafter /usr/include -c -o "$top/fused.o" "$src/render/plane/kernel_c.c" &&
        $cc -static -pthread -o "$top/fused" "$out/arm64/tests/arm64/results.c.o" "$top/fused.o" "$out"/arm64/lib{render,quilt,base}.a -lm || return
    results with-fma c env LF_CPU=c "$emulator" "$top/fused" kernels
    ! cmp -s "$top/here-c" "$top/with-fma" || echo "the same results with and without"
}
report "fused multiply-adds would be noticed" "$(fused_is_noticed 2>&1)"
end
