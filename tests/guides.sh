#!/bin/bash
# Every command of docs/guide/, as it stands there, in a folder for each page with what its reader would have: a model, the shipped
# scenes, the calibration of a panel, photos, and images of other pages. Panels are simulated.
set -u
# shellcheck source=tests/commands.sh
. "${QUILTD_SOURCE:-.}/tests/commands.sh"

scenes=$(dirname "$out")/scenes
path=$PATH
reader() { # name of a page
    PATH=$path
    set_up_reader "$top/$1" 24x32
    mkdir -p photos "$top/prometheus/node-exporter"
    cp -rL "$scenes" scenes
    [ ! -e ../getting-started/scene.json ] || cp ../getting-started/scene.json . # which the page on scripts goes on from
    printf '{ "pitch": 52, "slope": -7, "center": 0.5, "DPI": 324, "screenW": 300, "screenH": 400 }\n' > visual.json
    # what --read-chart makes of a photo of paper
    printf '{ "quiltd_chart_reading": 1, "visual_lpi": 60.13, "error_lpi": 0.001, "distance_mm": 400, "phase_mm": 0.02 }\n' > result.json
    quiltrender helmet.glb -o helmet.png && quiltrender helmet.glb -o photo.jpg --still && cp photo.jpg photos/1.jpg && cp photo.jpg photos/2.jpg
    quiltrender helmet.glb -o photo_rgbd.png --rgbd right && quiltrender helmet.glb -o top.png --rgbd top && mv top.png holiday.jpg
    quiltrender helmet.glb -o depth.png --still && mkdir album && cp photo_rgbd.png album/1.png && cp photo_rgbd.png album/2.png
}

# A page with mistakes: each has to be reported.
breaches() {
    cat << 'END'
# Breaches

    quiltrender helmet.glb -o a.png --no-such-option 1
    quiltctl no.such.method
    quiltd gone.glb --no-such-option
    for i in 1 2; do
        false
    done
    sudo this is not run
    for i in 1; do
END
}
reader breaches > "$top/setup.log" 2>&1
breaches > page.md
found=$(run_page page.md '' : | grep -c '^\[  ERROR   \]')
report "mistakes of a page are found" "$([ "$found" -eq 5 ] || echo "$found of 5")"

for page in "$src"/docs/guide/*.md; do
    name=${page##*/}
    reader "${name%.md}" > "$top/setup.log" 2>&1
    rc=$?
    report "$name: what its reader has" "$([ "$rc" -eq 0 ] || cat "$top/setup.log")"
    before=$commands
    run_page "$page" "$name: " :
    written=$(grep -cE "^    quilt(d|ctl|render|print|sim|bench|web|merge|farm)( |$)" "$page")
    [ "$name" != farms.md ] || report "$name: the jobs made their files" "$(ls film_qs*.mp4 turn_qs*.mp4 walk_qs*.mp4 large_qs*.png hologram/manifest.json 2>&1 > /dev/null)"
    report "$name: its commands ran" "$([ "$((commands - before))" -ge "$written" ] || echo "$((commands - before)) of $written")"
done
end
