#!/bin/bash
# The page of quiltweb in Debian's Chromium (tests/page). Screenshots come into build/page.
set -u
src=$(cd "${QUILTD_SOURCE:-.}" && pwd)
out=$(cd "${QUILTD_BUILD:-build/release}" && pwd)
# shellcheck source=tests/report.sh
. "$src/tests/report.sh"
# shellcheck source=tests/node_modules.sh
. "$src/tests/node_modules.sh"

export QUILTD_BUILD=$out QUILTD_NODE=${out%/*}/node
why=$(browser_missing "$src" "$QUILTD_NODE")
if [ -n "$why" ]; then
    skip "the page in a browser" "$why"
    end
fi
top=$(mktemp -d)
trap 'rm -rf "$top"' EXIT
node --test-reporter=tap "$src/tests/page/page.test.js" > "$top/log" 2>&1 < /dev/null
tap_results "$top/log" $? page
end
