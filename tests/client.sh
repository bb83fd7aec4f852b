#!/bin/bash
# The client of docs/reference, run as it is there: it turns the camera and takes a quilt.
set -u
src=${QUILTD_SOURCE:-.}
out=${QUILTD_BUILD:-build/release}
# shellcheck source=tests/report.sh
. "$src/tests/report.sh"

if ! command -v python3 > /dev/null; then
    skip "the client in Python takes a quilt" "there is no python3"
    end
fi
top=$(mktemp -d)
cat > "$top/scene.json" << 'END'
{"quiltd": 1, "camera": {"views": 6, "cone": 30},
 "volumes": {"fog": {"shape": "sphere", "density": 4, "albedo": 0.9}},
 "lights": {"sky": {"type": "environment", "radiance": 0.7}}}
END
"$out/quiltd" "$top/scene.json" --socket "$top/s" --device none --view-size 24x32 2> "$top/log" &
daemon=$!
trap 'kill "$daemon" 2> /dev/null; wait "$daemon"; rm -rf "$top"' EXIT
for ((i = 0; i < 3000; i++)); do
    [ -S "$top/s" ] && break
    sleep 0.02
done
taken() {
    python3 "$src/docs/reference/client.py" "$top/s" "$top/quilt.png" 2>&1 || return
    [ "$(od -An -c -N4 "$top/quilt.png" | tr -d ' ')" = '211PNG' ] || echo "quilt.png is no PNG"
}
report "the client in Python takes a quilt" "$(taken)"
refused() {
    python3 "$src/docs/reference/client.py" "$top/nothing" "$top/quilt.png" > /dev/null 2>&1 && echo "it ended with 0"
}
report "without a daemon it fails" "$(refused)"

end
