#!/bin/bash
# The client in Python: its own tests (clients/python/tests), also with a quiltd on a simulated panel.
set -u
src=$(cd "${QUILTD_SOURCE:-.}" && pwd)
out=$(cd "${QUILTD_BUILD:-build/release}" && pwd)
# shellcheck source=tests/report.sh
. "$src/tests/report.sh"

if ! command -v python3 > /dev/null; then
    skip "the client in Python" "there is no python3"
    end
fi
# The package python3-numpy is for the system's Python, which may not be the first one of PATH.
python=python3
! /usr/bin/python3 -c 'import numpy' 2> /dev/null || python=/usr/bin/python3
top=$(mktemp -d)
trap 'rm -rf "$top"' EXIT
export QUILTD_BUILD=$out PYTHONPATH=$src/clients/python PYTHONDONTWRITEBYTECODE=1

# A line of unittest per test: NAME (module.Class.NAME) ... ok, FAIL, ERROR or skipped 'why'. Classes and modules fail without one.
results() { # log, exit status
    local name result
    while IFS=$'\t' read -r name result; do
        case $result in
        ok) report "$name" '' ;;
        skipped*) skip "$name" "${result#skipped }" ;;
        *) report "$name" "$(sed -n "/^\(FAIL\|ERROR\): ${name#*: } /,/^=====/p" "$1")" ;;
        esac
    done < <(sed -nE 's/^(test_[a-z0-9_]+) \(.*\) \.\.\. (ok|FAIL|ERROR|skipped .*)$/'"$3"': \1\t\2/p' "$1")
    # what failed without such a line
    [ "$2" -eq 0 ] || [ "$failed" -ne "$before" ] || report "$3" "$(tail -n 25 "$1")"
}
for file in "$src"/clients/python/tests/test_*.py; do
    module=${file##*/}
    module=${module%.py}
    before=$failed
    (cd "$src/clients/python/tests" && "$python" -m unittest -v "$module") > "$top/log" 2>&1 < /dev/null
    results "$top/log" $? "$module"
done
end
