#!/bin/bash
# A node of a cluster: the programs of debian/quiltd-node.install, in a root with the libraries that they link and nothing else. The root
# is read only. There is no /dev/dri, no systemd, no home and no /tmp; the user has a number and no name.
set -u
src=$(cd "${QUILTD_SOURCE:-.}" && pwd)
out=$(cd "${QUILTD_BUILD:-build/release}" && pwd)
# shellcheck source=tests/report.sh
. "$src/tests/report.sh"

top=$(mktemp -d)
trap 'rm -rf "$top"' EXIT
root=$top/root job=$top/job
number=54321
readers='quiltimport quiltimport-vdb quiltimport-picture'
mapfile -t programs < <(sed -n 's|^usr/bin/||p' "$src/debian/quiltd-node.install")

# --- what is linked and listed ---

in_build() { printf "$out/%s\n" "$@"; }
libraries() { ldd "$@" 2> /dev/null | awk '$2 == "=>" && $3 ~ /^\// { print $3 } $1 ~ /^\/.*ld-linux/ { print $1 }' | sort -u; }
no_node_needs() { # programs
    libraries "$@" | grep -E '/lib(systemd|udev|usb|hidapi|drm|gbm|SDL2|microhttpd|wslay|X11|wayland|GL|EGL|dbus|polkit|sane)[-.0-9a-zA-Z]*[.]so'
}
report "the package has a program" "$([ ${#programs[@]} -ge 1 ] || cat "$src/debian/quiltd-node.install")"
# shellcheck disable=SC2046,SC2086  # lists of words
{
    report "what the package has is built" "$(ls $(in_build "${programs[@]}" $readers) 2>&1 > /dev/null)"
    report "no device, no systemd and no page is linked" "$(no_node_needs $(in_build "${programs[@]}" $readers))"
    report "one would be seen" "$(no_node_needs "$out/quiltd" | grep -q libusb || echo 'not seen')"
}

# Outside an image, where a scheduler is, quiltfarm has to run without libraries.
if [ -e "$("${CXX:-g++}" -print-file-name=libjansson.a 2> /dev/null)" ]; then
    alone=$top/quiltfarm
    report "quiltfarm can be one file" "$("${CXX:-g++}" -static -o "$alone" "$out"/daemon/tools/quiltfarm.c.o "$out"/lib{farm,engine,base}.a -ljansson -lnettle -lm 2>&1 | tail -n 5
        [ -z "$(libraries "$alone")" ] || echo "it has libraries"
        "$alone" --version > /dev/null 2>&1 || echo "it does not start")"
else
    skip "quiltfarm can be one file" "no static libjansson"
fi

# A package of the image is ours, or one that ours suggests.
image() { sed -n 's/.*apt-get install -y --no-install-recommends \(.*\) \\$/\1/p' "$1/debian/node/Containerfile" | tr ' ' '\n'; }
node_stanza() { awk '/^Package: / { on = $2 == "quiltd-node" } on' "$1/debian/control"; }
unlisted() {
    local p
    for p in $(image "$1"); do
        node_stanza "$1" | grep -qE "^(Package:|Suggests:.*) $p(,|\$)" || echo "$p is in the image and not in debian/control"
    done
    image "$1" | grep -qx quiltd-node || echo "quiltd-node is not in the image"
}
report "the image has what the package names" "$(unlisted "$src")"
mkdir -p "$top/breach/debian/node"
cp "$src/debian/control" "$top/breach/debian/"
sed 's/ quiltd-node ffmpeg/ quiltd-node ffmpeg libusb-1.0-0/' "$src/debian/node/Containerfile" > "$top/breach/debian/node/Containerfile"
report "a package too many would be seen" "$(unlisted "$top/breach" | grep -q libusb || echo 'not seen')"
# Both kinds of image have the same packages.
of_definition() { sed -n 's/.*apt-get install -y --no-install-recommends //p' "$src/debian/node/quiltd-node.def" | tr ' ' '\n'; }
report "Apptainer's image has the same packages" "$(diff <(image "$src") <(of_definition))"

# --- a root of their own ---

put() { # files: each where it lies here
    local f
    for f in "$@"; do
        mkdir -p "$root/${f%/*}"
        [ -e "$root/$f" ] || cp -L "$f" "$root/$f"
    done
}
# shellcheck disable=SC2046,SC2086  # lists of words
make_root() {
    local d
    mkdir -p "$root"/{usr/bin,usr/lib,usr/lib64,usr/libexec/quiltd,dev,proc,scratch,"$job"} "$top/scratch" "$job"
    ln -s usr/bin "$root/bin"
    ln -s usr/lib "$root/lib"
    ln -s usr/lib64 "$root/lib64"
    ln -s /proc/self/fd "$root/dev/fd"
    for d in null zero urandom; do : > "$root/dev/$d"; done
    cp $(in_build "${programs[@]}") "$root/usr/bin/"
    cp $(in_build $readers) "$root/usr/libexec/quiltd/"
    put $(libraries $(in_build "${programs[@]}" $readers))
    put /bin/sh $(libraries /bin/sh)
    chmod 1777 "$top/scratch" "$job"
    chmod 755 "$top"
}
# A command in that root. As root a user without a name runs it; another user gets namespaces of their own for the same.
inside() { # command…
    local again=() as
    as=(unshare --mount --propagation slave)
    [ "$(id -u)" -eq 0 ] || as=(unshare --user --map-root-user --mount)
    if [ "$(id -u)" -eq 0 ]; then
        again=(/usr/sbin/chroot --userspec="$number:$number" --groups= "$root")
    else
        again=(/usr/bin/unshare --user "--map-user=$number" "--map-group=$number" "--root=$root" --)
    fi
    "${as[@]}" sh -c '
        root=$1 job=$2 scratch=$3
        shift 3
        mount --bind "$root" "$root" && mount --rbind /proc "$root/proc" && mount --bind "$scratch" "$root/scratch" &&
            mount --bind "$job" "$root$job" || exit 125
        for d in null zero urandom; do mount --bind /dev/$d "$root/dev/$d" || exit 125; done
        mount -o remount,bind,ro "$root" || exit 125
        exec env -i PATH=/usr/bin TMPDIR=/scratch "$@"' sh "$root" "$job" "$top/scratch" "${again[@]}" "$@"
}
expect() { # status, command…: its complaints
    local wanted=$1 rc=0
    shift
    inside "$@" > "$top/said" 2>&1 || rc=$?
    [ "$rc" -eq "$wanted" ] || echo "exit status $rc, expected $wanted: $*: $(tail -n 3 "$top/said")"
}

tests=("its programs start" "exit status 2 for a wrong option" "a mesh, a volume and a sky render to the same bytes as here"
    "nothing but its job can be written" "a film of quilts is joined" "TERM ends it with 75 and a state" "and it goes on to the same bytes"
    "a job of tasks runs: the same film" "nothing is left behind" "a node without readers says so")
make_root
rc=0
inside quiltrender --version > "$top/said" 2>&1 || rc=$?
if [ "$rc" -ne 0 ] && grep -qE '^(unshare|mount|sh: .*mount)' "$top/said"; then
    for t in "${tests[@]}"; do skip "$t" "no mounts here: $(head -n 1 "$top/said")"; done
    end
fi

cp -L "$(dirname "$out")"/scenes/{cloud.vdb,sky.hdr,still.glb,motion.json} "$job/"
cat > "$job/scene.json" << 'END'
{ "quiltd": 1,
  "camera": { "target": [0, 0, 0], "position": [0, 0, 12], "fov_y": 14, "aspect": 0.75, "views": 4, "cone": 20 },
  "volumes": { "cloud": { "file": "cloud.vdb", "scale": 44, "albedo": 0.99 } },
  "meshes": { "still": { "file": "still.glb", "transform": { "translate": [0, -1, -2] } } },
  "lights": { "sky": { "type": "environment", "file": "sky.hdr" } } }
END
small="--quilt 2x2 --views 4 --view-size 24x32"
few="$small --threads 1"

programs_start() {
    local p
    for p in "${programs[@]}"; do
        expect 0 "$p" --version
        expect 0 "$p" --help
    done
}
report "${tests[0]}" "$(programs_start)"
report "${tests[1]}" "$(for p in "${programs[@]}"; do expect 2 "$p" --no-such-option; done)"

same_bytes() {
    # shellcheck disable=SC2086  # words
    expect 0 quiltrender "$job/scene.json" -o "$job/node.png" $few --passes 2 &&
        "$out/quiltrender" "$job/scene.json" -o "$top/here.png" $few --passes 2 > /dev/null 2>&1 &&
        cmp "$job"/node_qs*.png "$top"/here_qs*.png 2>&1
}
report "${tests[2]}" "$(same_bytes)"
# shellcheck disable=SC2086  # words
report "${tests[3]}" "$(expect 1 quiltrender "$job/scene.json" -o /usr/out.png $few --passes 1; grep -q '/usr/out' "$top/said" || cat "$top/said")"

if command -v ffmpeg > /dev/null 2>&1; then
    program=$(command -v ffmpeg)
    # shellcheck disable=SC2046  # a list of words
    { cp -L "$program" "$root/usr/bin/ffmpeg" && put $(libraries "$program"); }
    # shellcheck disable=SC2086  # words
    report "${tests[4]}" "$(expect 0 quiltrender "$job/motion.json" -o "$job/film.mp4" --frames 1:2 $few --passes 1; ls "$job"/film_qs2x2*.mp4 2>&1 > /dev/null)"
else
    skip "${tests[4]}" "no ffmpeg"
fi

# As a cluster ends a task: by a signal to the program, which saves its work.
long="$few --passes 600"
processor_time() { awk '{ print $14 + $15 }' "/proc/$1/stat" 2> /dev/null || echo 0; } # in hundredths of a second
stopped() {
    local shell pid n=0
    # shellcheck disable=SC2016,SC2086  # of another shell; words
    inside /bin/sh -c 'echo $$ > "$1/pid"; shift; exec "$@"' sh "$job" quiltrender "$job/motion.json" -o "$job/long.png" $long \
        --state "$job/long.lfstate" > "$top/said" 2>&1 &
    shell=$!
    while kill -0 "$shell" 2> /dev/null; do
        pid=$(cat "$job/pid" 2> /dev/null)
        [ -z "$pid" ] || [ "$(processor_time "$pid")" -lt 50 ] || break
        sleep 0.1
    done
    kill -TERM "$pid"
    wait "$shell"
    n=$?
    [ "$n" -eq 75 ] || echo "exit status $n, expected 75: $(tail -n 3 "$top/said")"
    [ -s "$job/long.lfstate" ] || echo "no state"
    [ -z "$(ls "$job"/long_qs* 2> /dev/null)" ] || echo "an output is there before its time"
}
report "${tests[5]}" "$(stopped)"
continued() {
    # shellcheck disable=SC2086  # words
    expect 0 quiltrender "$job/motion.json" -o "$job/long.png" $long --state "$job/long.lfstate"
    # shellcheck disable=SC2086  # words
    "$out/quiltrender" "$job/motion.json" -o "$top/long.png" $long > /dev/null 2>&1
    cmp "$job"/long_qs*.png "$top"/long_qs*.png 2>&1
}
report "${tests[6]}" "$(continued)"
# The lines of a job's lists, as any farm runs them.
listed() {
    # shellcheck disable=SC2086  # words
    expect 0 quiltfarm plan "$job/farm" --engine list --threads 1 --task-minutes 0.001 -- "$job/motion.json" -o "$job/farmed.mp4" --frames 1:2 $small --passes 1
    expect 0 sh "$job/farm/tasks"
    expect 0 sh "$job/farm/finishes"
    [ "$(wc -l < "$job/farm/tasks")" -ge 2 ] || echo "one task is no farm"
    cmp "$job"/farmed_qs*.mp4 "$job"/film_qs*.mp4 2>&1
}
if [ -x "$root/usr/bin/ffmpeg" ]; then
    report "${tests[7]}" "$(listed)"
else
    skip "${tests[7]}" "no ffmpeg"
fi
report "${tests[8]}" "$(find "$top/scratch" -mindepth 1; find "$job" -name '.*' -o -name '*.new')"

rm "$root/usr/libexec/quiltd/quiltimport"
# shellcheck disable=SC2086  # words
report "${tests[9]}" "$(expect 1 quiltrender "$job/scene.json" -o "$job/none.png" $few --passes 1; grep -q quiltimport "$top/said" || cat "$top/said")"
end
