#!/bin/bash
# Every command of README.md, as it stands there, in a folder with what a reader would have: a model.
set -u
# shellcheck source=tests/commands.sh
. "${QUILTD_SOURCE:-.}/tests/commands.sh"

set_up_reader "$top" 105x140
run_page "$src/README.md" '' stop_daemon
report "the README has commands to run" "$([ "$commands" -ge 10 ] || echo "$commands were found")"
report "the README is at most 100 lines" "$([ "$(wc -l < "$src/README.md")" -le 100 ] || wc -l "$src/README.md")"
end
