#!/bin/bash
# A minute of a slideshow on the simulated panel, from the Makefile, with O and SRCDIR set: a quilt video of 30 frames a second, a picture
# and a scene, with crossfades of a second. Prints what was shown, and the intervals between the images that the panel took.
set -eu
src=$(cd "$SRCDIR" && pwd)
out=$(cd "$O" && pwd)
seconds=${BENCH_SECONDS:-60}
top=$(mktemp -d)
daemon=
finish() {
    [ -z "$daemon" ] || kill "$daemon" 2> /dev/null || true
    rm -rf "$top"
}
trap finish EXIT
mkdir "$top/show"
make_quilt() { # file, more arguments of ffmpeg
    local file=$1
    shift
    ffmpeg -loglevel error -f lavfi -i testsrc2=size=3360x3360:rate=30 "$@" "$top/show/$file"
}
make_quilt 1_qs8x6a0.75.mp4 -t 6 -pix_fmt yuv420p -preset ultrafast
make_quilt 2_qs8x6a0.75.png -frames:v 1
cp "$src/tests/scenes/live-fog.json" "$top/show/3.json"
ctl() { "$out/quiltctl" --socket "$top/s" "$@"; }
"$out/quiltd" --playlist "$top/show" --seconds 6 --crossfade 1 --device "sim:$top/sim" --socket "$top/s" 2> "$top/log" &
daemon=$!
for ((i = 0; i < seconds; i++)); do
    sleep 1
    ctl status >> "$top/status" 2> /dev/null || true
done
ctl shutdown > /dev/null || true
wait "$daemon" || true
daemon=
echo "entries, in the order in which they were shown:"
sed -n 's/^  slideshow  \(entry [0-9]*\) of [0-9]*, \([^,]*\),.*/  \1: \2/p' "$top/status" | uniq
echo "frames of each video, and where it was when it was asked last:"
awk '/^  position / { at = $2 } /^  frames / { now = $2; if (now + 0 < shown + 0) print line; shown = now; line = "  " $0 ", at " at " s" }
    END { if (line) print line }' "$top/status"
awk -F '[:,]' -v seconds="$seconds" '
    $2 != seq { seq = $2; now = $NF + 0; for (i = 1; i < NF; i++) if ($i ~ /"time_ns"/) now = $(i + 1) + 0
        if (n++) { gap = (now - last) / 1e6; if (gap < 250) gaps[m++] = gap }
        last = now }
    END {
        for (i = 1; i < m; i++) for (k = i; k > 0 && gaps[k - 1] > gaps[k]; k--) { t = gaps[k]; gaps[k] = gaps[k - 1]; gaps[k - 1] = t }
        printf "%d images in %d s; intervals of moving images: median %.1f ms, 95 %% %.1f ms, longest %.1f ms\n",
            n, seconds, gaps[int(m / 2)], gaps[int(0.95 * m)], gaps[m - 1]
    }' "$top/sim/updates.jsonl"
sed -n 's/^quiltd: \(.*\(skipped\|dropped\).*\)/\1/p' "$top/log"
