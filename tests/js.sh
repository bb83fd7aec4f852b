#!/bin/bash
# The client in JavaScript: its own tests (clients/js/tests), also with a quiltd on a simulated panel, and its types.
set -u
src=$(cd "${QUILTD_SOURCE:-.}" && pwd)
out=$(cd "${QUILTD_BUILD:-build/release}" && pwd)
# shellcheck source=tests/report.sh
. "$src/tests/report.sh"
# shellcheck source=tests/node_modules.sh
. "$src/tests/node_modules.sh"

why=$(node_missing 18)
if [ -n "$why" ]; then
    skip "the client in JavaScript" "$why"
    end
fi
top=$(mktemp -d)
trap 'rm -rf "$top"' EXIT
export QUILTD_BUILD=$out

for file in "$src"/clients/js/tests/*.test.js; do
    node --test-reporter=tap "$file" > "$top/log" 2>&1 < /dev/null
    tap_results "$top/log" $? "$(basename "$file" .test.js)"
done

why=$(packages_missing "$src" "${out%/*}/node")
if [ -n "$why" ]; then
    skip "types are what tsc reads" "$why"
else
    report "types are what tsc reads" "$(node "${out%/*}/node/node_modules/typescript/bin/tsc" -p "$src/clients/js/tests" 2>&1)"
fi
end
