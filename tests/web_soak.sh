#!/bin/bash
# The gateway among slow and hostile clients (tests/page/soak.js): 20 seconds of it, or SOAK_SECONDS. make soak adds a browser.
set -u
src=$(cd "${QUILTD_SOURCE:-.}" && pwd)
out=$(cd "${QUILTD_BUILD:-build/release}" && pwd)
# shellcheck source=tests/report.sh
. "$src/tests/report.sh"
# shellcheck source=tests/node_modules.sh
. "$src/tests/node_modules.sh"

why=$(node_missing 18)
if [ -n "$why" ]; then
    skip "slow and hostile clients" "$why"
    end
fi
top=$(mktemp -d)
trap 'rm -rf "$top"' EXIT
export QUILTD_BUILD=$out
unset QUILTD_NODE
if [ -n "${SOAK_STRICT-}" ]; then
    why=$(browser_missing "$src" "${out%/*}/node")
    if [ -n "$why" ]; then
        echo "without a browser: $why"
    else
        export QUILTD_NODE=${out%/*}/node
    fi
fi
node --test-reporter=tap "$src/tests/page/soak.js" > "$top/log" 2>&1 < /dev/null
rc=$?
grep -E '^# .*[:;] ' "$top/log" | grep -v '^# Subtest'
tap_results "$top/log" "$rc" soak
end
