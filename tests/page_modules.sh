#!/bin/bash
# The modules of quiltweb's page that need no browser: their tests in tests/web/page, run by Node.
set -u
src=$(cd "${QUILTD_SOURCE:-.}" && pwd)
# shellcheck source=tests/report.sh
. "$src/tests/report.sh"
# shellcheck source=tests/node_modules.sh
. "$src/tests/node_modules.sh"

why=$(node_missing 18)
if [ -n "$why" ]; then
    skip "the modules of the page" "$why"
    end
fi
top=$(mktemp -d)
trap 'rm -rf "$top"' EXIT

# Node reports a test per line in TAP: "ok 1 - NAME", "not ok 2 - NAME", and why below it.
results() { # log, exit status, module
    local line name
    while IFS= read -r line; do
        name="$3: ${line#*ok * - }"
        case $line in
        ok*) report "$name" '' ;;
        *) report "$name" "$(sed -n "/^${line%% - *} - /,/^  \.\.\.$/p" "$1")" ;;
        esac
    done < <(grep -E '^(not )?ok [0-9]+ - ' "$1")
    # what failed without such a line
    [ "$2" -eq 0 ] || [ "$failed" -ne "$before" ] || report "$3" "$(tail -n 25 "$1")"
}
for file in "$src"/tests/web/page/test_*.mjs; do
    module=${file##*/}
    module=${module%.mjs}
    before=$failed
    node --test-reporter=tap "$file" > "$top/log" 2>&1 < /dev/null
    results "$top/log" $? "$module"
done
end
