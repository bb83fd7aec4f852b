#!/bin/bash
# Writes quiltd/methods.d.ts from the answer of `hello` of this quiltd, which it starts: make_types.sh QUILTD
set -eu
here=$(cd "$(dirname "$0")" && pwd)
command -v node > /dev/null || { echo "quiltd: there is no node; clients/js/quiltd/methods.d.ts stays as it is" >&2 && exit 0; }
folder=$(mktemp -d)
"$1" --device none --socket "$folder/s" --run-for 600 2> "$folder/log" &
quiltd=$!
trap 'kill "$quiltd" && wait "$quiltd"; rm -rf "$folder"' EXIT
while [ ! -S "$folder/s" ]; do
    kill -0 "$quiltd" 2> /dev/null || { cat "$folder/log" >&2 && exit 1; }
    sleep 0.05
done
node "$here/make_types.js" "$folder/s" > "$folder/types"
cmp -s "$folder/types" "$here/quiltd/methods.d.ts" || cp "$folder/types" "$here/quiltd/methods.d.ts"
