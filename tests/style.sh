#!/bin/bash
# The rules of the house that a grep can hold, each shown first to catch a breach in a small tree made for it.
# Prints its results as cmocka does.
set -u
src=${QUILTD_SOURCE:-.}
out=${QUILTD_BUILD:-build}

# Every rule prints the places that break it, in the tree $1.
sources() { # tree, find expressions
    local tree=$1
    shift
    (cd "$tree" && find base render quilt device daemon bench scenes tests -type f \( "$@" \) 2> /dev/null | sort)
}
code() { sources "$1" -name '*.[ch]' -o -name '*.cc'; }
grep_code() { # tree, grep arguments
    local tree=$1
    shift
    code "$tree" | (cd "$tree" && xargs -r -d '\n' grep -nE "$@" /dev/null)
}

tabs_and_trailing_blanks() { grep_code "$1" $'\t|[ \t]$'; }
# .clang-format keeps code at 132; comments are not reflowed
long_lines() { grep_code "$1" '^.{141,}'; }
missing_final_newline() {
    code "$1" | while read -r f; do
        [ -z "$(tail -c 1 "$1/$f")" ] || echo "$f"
    done
}
unfinished_words() { grep_code "$1" '\b(TODO|FI''XME|XX''X)\b'; }
fast_math_and_clones() {
    (cd "$1" && grep -nE -e '-ffast-''math|target_''clones' Makefile .ci/*.mk ./*/module.mk 2> /dev/null)
    grep_code "$1" 'ffast-''math|target_''clones'
}
rooms_apart() {
    local room other
    for room in render quilt device base; do
        other=$(echo render quilt device daemon bench tests | tr ' ' '\n' | grep -vx "$room" | paste -sd '|')
        sources "$1" -path "$room/*.[ch]" -o -path "$room/*.cc" |
            (cd "$1" && xargs -r -d '\n' grep -nE "#include +[\"<](\.\./)*($other)/" /dev/null)
    done
}
cxx_only_for_openvdb() { sources "$1" -name '*.cc' -o -name '*.cpp' -o -name '*.cxx' | grep -vE '^(render/vdb_import|scenes/make_[a-z_]*)\.cc$'; }
top_level() {
    (cd "$1" && if [ -e .git ]; then git ls-files 2> /dev/null | cut -d/ -f1 | sort -u; else ls; fi) |
        grep -vE '^(\..*|Makefile|README\.md|LICENSE|CONTRIBUTING(\.md)?|base|render|quilt|device|daemon|tests|systemd|scenes|bench|docs|debian|build)$'
}
# Linux braces: a function's body stands between lines that hold one brace.
long_functions() {
    sources "$1" -name '*.c' -o -name '*.cc' | while read -r f; do
        awk -v f="$f" '/^\{$/ { start = NR } /^\}$/ && start { if (NR - start + 1 > 80) print f ":" start ": " NR - start + 1 " lines"; start = 0 }' "$1/$f"
    done
}
# A name of the house (functions, types, constants) belongs to one file, or to a header and its .c file.
one_name_one_thing() {
    sources "$1" -name '*.[ch]' -not -path 'tests/*' | (cd "$1" && ctags -x --kinds-C=defgsu --languages=C --langmap=C:.c.h -L - 2> /dev/null) |
        awk '{ file = $4; sub(/\.[ch]$/, "", file) }
            $1 ~ /^(lf|LF)_/ && !seen[$1, file]++ { places[$1] = places[$1] " " $4; n[$1]++ }
            END { for (name in n) if (n[name] > 1) print name ":" places[name] }' | sort
}
empty_assertions() { grep_code "$1" 'assert_true\((1|true)\)|assert_int_equal\(([0-9]+), \2\)'; }

# A tree in which every rule is broken once.
make_breaches() {
    mkdir -p "$1"/{render,quilt,tests/quilt,attic}
    touch "$1/attic/old"
    {
        printf '#include "quilt/quilt.h"\n\tint x; /* TO''DO */\n'
        printf '/* %0141d */\nvoid f(void)\n{\n' 0
        for _ in $(seq 90); do echo '    g();'; done
        printf '}\n'
    } > "$1/render/bad.c"
    printf 'struct lf_twice {\n    int x;\n};\n' | tee "$1/render/once.h" > "$1/quilt/twice.h"
    printf '__attribute__((target_''clones("avx2"))) int y;' > "$1/quilt/cloned.cc"
    printf 'assert_true(1);\n' > "$1/tests/quilt/test_bad.c"
}

passed=0 failed=0
report() { # name, breaches
    if [ -z "$2" ]; then
        passed=$((passed + 1))
        echo "[       OK ] $1"
    else
        failed=$((failed + 1))
        echo "[  ERROR   ] --- $1:"
        echo "$2" | head -n 20
    fi
}

breaches=$(mktemp -d)
trap 'rm -rf "$breaches"' EXIT
make_breaches "$breaches"
for rule in tabs_and_trailing_blanks long_lines missing_final_newline unfinished_words fast_math_and_clones rooms_apart \
    cxx_only_for_openvdb top_level long_functions one_name_one_thing empty_assertions; do
    if [ -z "$($rule "$breaches")" ]; then
        report "$rule" "the rule does not notice a breach of it"
    else
        report "$rule" "$($rule "$src")"
    fi
done

# What the object files show. C names that other files see begin with lf_.
foreign_names() {
    nm -A -g --defined-only "$out"/lib*.a 2> /dev/null | awk '$2 ~ /^[0-9a-f]+$/ && $3 ~ /^[TDBRC]$/ && $4 !~ /^(lf_|_Z|__|DW\.|_?asan)/ { print $1, $4 }'
}
# A file compiled for one instruction set holds functions and one table: a writable global there might be initialised, and an
# inline function from a header might be chosen by the linker, on a machine without the instructions.
isa_globals() {
    local o
    for o in "$out"/render/*_avx2.c.o "$out"/render/*_avx512.c.o; do
        [ -e "$o" ] || continue
        objdump -t "$o" | awk -v o="${o##*/}" '/^[0-9a-f]+ +[lgu].* O \.(data|bss)[ \t]/ { print o, $NF, "(writable)" }
            /^[0-9a-f]+ +(w|u)/ && !/\*UND\*/ { print o, $NF, "(weak)" }
            /^[0-9a-f]+ +g/ && ++n > 1 { print o, $NF, "(a second name)" }'
    done
}
report foreign_names "$(foreign_names)"
case ${BUILD:-release} in
release | debug) report isa_globals "$(isa_globals)" ;;
esac

echo "[==========] $((passed + failed)) test(s) run."
echo "[  PASSED  ] $passed test(s)."
[ "$failed" -eq 0 ] || echo "[  FAILED  ] $failed test(s)."
[ "$failed" -eq 0 ]
