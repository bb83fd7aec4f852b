# shellcheck shell=bash
# What the tests in shell share; they source it. Results are printed as cmocka does: `report`, `skip`, at last `end`.

passed=0 failed=0 skipped=0
report() { # name, complaints: none = it holds
    if [ -z "$2" ]; then
        passed=$((passed + 1))
        echo "[       OK ] $1"
    else
        failed=$((failed + 1))
        echo "[  ERROR   ] --- $1:"
        echo "$2" | head -n 30
    fi
}
skip() { # name, why
    skipped=$((skipped + 1))
    echo "[  SKIPPED ] $1: $2"
}
end() { # the script
    echo "[==========] $((passed + failed + skipped)) test(s) run."
    echo "[  PASSED  ] $passed test(s)."
    [ "$skipped" -eq 0 ] || echo "[  SKIPPED ] $skipped test(s)."
    [ "$failed" -eq 0 ] || echo "[  FAILED  ] $failed test(s)."
    [ "$failed" -eq 0 ]
    exit
}
