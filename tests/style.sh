#!/bin/bash
# The rules of the project that a grep can hold, each shown first to catch a breach in a small tree made for it.
set -u
export LC_ALL=C.UTF-8 # a line has characters, not bytes
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
# what .clang-format is told not to touch has the same width
long_lines() { grep_code "$1" '^.{101,}'; }
# A rule between the sections of a file is one line, which the formatter does not break: its end is at column 100.
broken_section_rules() { grep_code "$1" '^/\* -{8}' | grep -vE ':/\* -+ [^-].* -- \*/$'; grep_code "$1" '^/\* -{8}.* -- \*/$' | awk '{ sub(/^[^:]*:[0-9]*:/, "") } length($0) != 100'; }
# An expression that clang-format took for a template: `i<n && * p> 0`. The other way round (`*p > 0 && i < n`) it does not.
torn_expressions() { grep_code "$1" '[a-z0-9_]<[a-z0-9_][^>"]*&& \* [a-z]'; }
# Pointers are asked as `p` and `!p`.
pointers_compared() { grep_code "$1" '[!=]= NULL\b|\bNULL [!=]=' | grep -v '^tests/arm64/cmocka.h:'; }
# A block's first declarations and what follows them stand together.
blanks_after_declarations() {
    sources "$1" -name '*.c' | (cd "$1" && xargs -r -d '\n' awk '
            FNR == 1 { start = 0 }
            /\{$/ { start = FNR; plain = 1; next }
            start && /^$/ { if (plain && FNR > start + 1) print FILENAME ":" FNR ": blank line after declarations"; start = 0; next }
            start && (/^ +(return|goto|break|continue|case|else)\>/ ||
                !/^ +((const|static|unsigned|struct|enum|volatile) +)*[A-Za-z_][A-Za-z0-9_]*( const)? +\**[A-Za-z_][A-Za-z0-9_]*(\[[^]]*\])?( = [^;]*|, [^;(]*)?;$/) { plain = 0 }
            /^\}|^#|^(static const|typedef|struct|enum|const)/ { start = 0 }')
}
missing_final_newline() { code "$1" | (cd "$1" && xargs -r -d '\n' grep -LzP '\n\z'); }
unfinished_words() { grep_code "$1" '\b(TODO|FI''XME|XX''X)\b'; }
fast_math_and_clones() {
    (cd "$1" && grep -nE -e '-ffast-''math|target_''clones' Makefile .ci/*.mk ./*/module.mk 2> /dev/null)
    grep_code "$1" 'ffast-''math|target_''clones'
}
modules_apart() {
    local module other
    for module in render quilt device base; do
        other=$(echo render quilt device daemon bench tests | tr ' ' '\n' | grep -vx "$module" | paste -sd '|')
        sources "$1" -path "$module/*.[ch]" -o -path "$module/*.cc" |
            (cd "$1" && xargs -r -d '\n' grep -nE "#include +[\"<](\.\./)*($other)/" /dev/null)
    done
}
# Which folder may include which others of its module, and the headers in the module's own folder, one by one. Arrows go one way: what
# stands below knows nothing of what is above it. Headers of other modules but base are included by name alone (exported).
layers() {
    cat << 'END'
render/scene:
render/transport:
render/transport/surface: render/scene
render/transport/light: render/scene render/transport render/transport/surface
render/transport/path: render/scene render/transport render/transport/surface render/transport/light
render/transport/lanes: render/scene render/transport render/transport/surface render/transport/light render/transport/path
render/import/scene: render/render.h render/scene render/transport render/transport/surface render/transport/light render/transport/path
render/import/reader: render/scene render/transport/surface render/import/scene
render/film: render/render.h render/transport render/transport/surface/albedo.h
render/plane: render/render.h render/scene render/transport/surface render/transport/light render/transport/path render/transport/lanes render/film
render/rows: render/integrator.h render/visit_lattice.h render/scene render/transport render/transport/surface render/transport/light render/transport/path render/transport/lanes render/film render/plane
render/cameras: render/render.h render/integrator.h render/scene render/transport render/transport/light render/transport/path render/transport/lanes render/film render/plane/rig.h render/visit_lattice.h
render/papers: render/render.h render/integrator.h render/visit_lattice.h render/scene render/transport render/transport/light render/transport/path render/transport/lanes render/film render/plane/rig.h render/rows/adaptive.h
render/layers: render/renderer.h render/transport render/transport/path render/plane/rig.h
render/reconstruct: render/render.h render/film
render: render/scene render/transport render/transport/path render/transport/lanes render/film render/plane render/rows render/cameras render/reconstruct
quilt/kernel:
quilt: quilt/kernel
quilt/panel: quilt/quilt.h quilt/lens.h quilt/kernel
quilt/hologram: quilt/quilt.h quilt/holograms.h
quilt/profile: quilt/quilt.h quilt/prints.h quilt/profiles.h quilt/lens.h
quilt/print: quilt/quilt.h quilt/prints.h quilt/lens.h quilt/axis.h quilt/font.h quilt/photo.h
quilt/chart: quilt/quilt.h quilt/prints.h quilt/lens.h quilt/axis.h quilt/font.h quilt/photo.h quilt/print/print.h quilt/print/label.h
quilt/proof: quilt/quilt.h quilt/prints.h quilt/profiles.h quilt/lens.h quilt/print/pdf.h
device:
device/hid: device/device.h device/device_table.h
device/find: device/device.h device/device_table.h device/hid
device/drm: device/device.h device/device_table.h device/handover.h device/pixels.h device/find
device/window: device/device.h device/device_table.h device/handover.h device/pixels.h device/find
device/usb: device/device.h device/device_table.h device/handover.h device/find
device/sim: device/device.h device/device_table.h
device/model: device/usb
daemon/wire:
daemon/threads:
daemon/media:
daemon/output: daemon/media
daemon/engine: daemon/media daemon/output daemon/threads
daemon/show: daemon/threads daemon/engine/mailbox.h
daemon/parts: daemon/media/movie.h daemon/output/content.h daemon/output/render_words.h daemon/output/preview.h daemon/output/thumbnail.h daemon/engine daemon/threads daemon/wire
daemon/server: daemon/output/options.h daemon/engine daemon/parts daemon/show daemon/threads daemon/wire
daemon/farm: daemon/output/options.h
daemon/tools: daemon/media/movie.h daemon/output daemon/farm/farm.h daemon/farm/farm_process.h daemon/wire daemon/server daemon/parts/doctor.h
daemon/web: daemon/output/options.h daemon/wire
base:
base/sandbox: base
bench:
END
    cat "$1/tests/layers" 2> /dev/null # a tree's own rows: that of breaches has some
}
# The headers that other modules may include, and the files that may include private ones.
exported='render/render\.h|quilt/(quilt|prints|holograms|profiles|rgbd|chart/reading|proof/(print_file|simulate|study|check))\.h|device/device\.h|device/sim/optics\.h|device/hid/(hid|buttons)\.h|device/find/(find|edid)\.h|device/usb/(gud|usb|gud_host)\.h|device/model/[a-z_]*\.h|render/rows/rows\.h|render/papers/papers\.h|render/film/film_merge\.h|daemon/(output/(options|content|render_job|completion)|engine/loader|media/decoder)\.h'
private_allowed='bench/micro[.]c render/(renderer|transport/lanes/suffix_batch)[.]h'
modules='base|render|quilt|device|daemon|bench|scenes|tests'
# The rules below read includes as they are written: from the root, in quotes, and not by another way.
includes_not_from_the_root() {
    grep_code "$1" '^ *# *include' |
        grep -vE ":#include (<[^.]+(\.h)?>|\"($modules)(/[A-Za-z0-9_]+)+\.h\"|\"gen/(scene_schema|web_pages)\.h\")" # gen/: of the build
}
own_headers_in_angles() { grep_code "$1" "#include <($modules)/"; }
foreign_internal_headers() {
    sources "$1" -name '*.[ch]' -o -name '*.cc' | (cd "$1" && xargs -r -d '\n' grep -nHoE '#include "[a-z_0-9/]+_internal\.h"') |
        awk -F'[:"]' '{ from = $1; sub(/\/[^\/]*$/, "", from); to = $4; sub(/\/[^\/]*$/, "", to)
            if (from != to) print $1 ":" $2 ": includes " $4 }'
}
# The objects of daemon/parts (NAME.h, NAME.c, NAME_*.[ch]) see neither the server nor each other.
parts_apart() {
    sources "$1" -path 'daemon/parts/*.[ch]' | (cd "$1" && xargs -r -d '\n' grep -nHoE '#include "daemon/(parts|server)/[a-z_]+\.h"') |
        awk -F'[:"]' '{ from = $1; to = $4; sub(/[._][^/]*$/, "", from); sub(/[._][^/]*$/, "", to); if (from != to) print $1 ":" $2 ": includes " $4 }'
}
# The server's struct is seen by its own files alone.
server_seen_from_outside() { grep_code "$1" '\blf_server\b' | grep -vE '^daemon/server/'; }
layers_in_a_circle() {
    layers "$1" | awk '{ folder = $1; sub(/:$/, "", folder); for (i = 2; i <= NF; i++) print folder, $i }' | { tsort > /dev/null; } 2>&1
}
# Prints "row", "layer" or "exported", and the include that breaks it.
include_complaints() {
    sources "$1" -name '*.[ch]' -not -path 'tests/*' -not -path 'scenes/*' -o -name '*.cc' -not -path 'scenes/*' |
        (cd "$1" && xargs -r -d '\n' grep -nHoE '#include "(base|render|quilt|device|daemon|bench)/[a-z_0-9/]+\.h"') |
        awk -F'[:"]' -v exported="^($exported)$" -v behind="^($private_allowed)\$" '
            FILENAME != "-" { split($0, row, /: */); n = split(row[2], to, " "); known[row[1]] = 1
                for (i = 1; i <= n; i++) may[row[1], to[i]] = 1; next }
            { from = $1; sub(/\/[^\/]*$/, "", from); header = $4; to_folder = header; sub(/\/[^\/]*$/, "", to_folder)
              module = from; sub(/\/.*/, "", module); to_module = header; sub(/\/.*/, "", to_module)
              what = $1 ":" $2 ": includes " header
              if (!known[from]) print "row " what ", and " from " stands in no row of the table"
              else if (from != to_folder && module == to_module && !may[from, to_folder] && !may[from, header]) print "layer " what
              else if (module != to_module && to_module != "base" && header !~ exported && $1 " " header !~ behind) print "exported " what }' <(layers "$1") -
}
folders_in_no_row() { include_complaints "$1" | sed -n 's/^row //p'; }
upward_includes() { include_complaints "$1" | sed -n 's/^layer //p'; }
includes_of_private_headers() { include_complaints "$1" | sed -n 's/^exported //p'; }
cxx_only_for_libraries() { sources "$1" -name '*.cc' -o -name '*.cpp' -o -name '*.cxx' | grep -vE '^(render/import/reader/(vdb|draco)_read|scenes/make_[a-z_]*)\.cc$'; }
top_level() {
    (cd "$1" && if [ -e .git ]; then git ls-files 2> /dev/null | cut -d/ -f1 | sort -u; else ls; fi) |
        grep -vE '^(\..*|Makefile|README\.md|CHANGELOG\.md|LICENSE|CONTRIBUTING(\.md)?|base|render|quilt|device|daemon|clients|web|tests|systemd|scenes|bench|docs|debian|build)$'
}
# Linux braces: a function's body stands between lines that hold one brace.
long_functions() {
    sources "$1" -name '*.c' -o -name '*.cc' | (cd "$1" && xargs -r -d '\n' awk '
        FNR == 1 { start = 0 }
        /^\{$/ { start = FNR }
        /^\}$/ && start { if (FNR - start + 1 > 80) print FILENAME ":" start ": " FNR - start + 1 " lines"; start = 0 }')
}
# A file has at most 700 lines.
long_files() {
    code "$1" | (cd "$1" && xargs wc -l) | awk '$1 > 700 && $2 != "total" { print $2 ": " $1 " lines" }'
}
# A name of the project (functions, types, constants) belongs to one file, or to a header and its .c file.
one_name_one_thing() {
    sources "$1" -name '*.[ch]' -not -path 'tests/*' | (cd "$1" && ctags -x --kinds-C=defgsu --languages=C --langmap=C:.c.h -L - 2> /dev/null) |
        awk '{ file = $4; sub(/\.[ch]$/, "", file) }
            $1 ~ /^(lf|LF)_/ && !seen[$1, file]++ { places[$1] = places[$1] " " $4; n[$1]++ }
            END { for (name in n) if (n[name] > 1) print name ":" places[name] }' | sort
}
# A struct has at most 30 fields.
wide_structs() {
    sources "$1" -name '*.[ch]' | (cd "$1" && ctags -x --kinds-C=m --languages=C --langmap=C:.c.h --_xformat='%{scope} %F %N' -L - 2> /dev/null) |
        awk '{ n[$2 ": " $1]++ } END { for (s in n) if (n[s] > 30) print s " has " n[s] " fields" }' | sort
}
# make mutants changes lines that are there.
stale_mutants() { SRCDIR=$1 O=$out "$src"/tests/mutants/run --stale; }
# Links of Markdown to files, and to headings as GitHub names them.
headings_of() { sed -nE 's/^#+ //p' "$1" 2> /dev/null | tr '[:upper:]' '[:lower:]' | sed -E 's/[^a-z0-9 _-]//g; s/ /-/g'; }
pages() { (cd "$1" && find . -maxdepth 1 -name '*.md' && find ./docs -name '*.md' 2> /dev/null) | sort; }
links_that_lead_nowhere() {
    local f link file
    pages "$1" | while read -r f; do
        grep -oE '\]\([^)]+\)' "$1/$f" | sed -E 's/^\]\(|\)$//g' | grep -vE '^https?:' | while read -r link; do
            file=${link%%#*}
            file=${file:+$(dirname "$f")/$file}
            file=$1/${file:-$f}
            [ -e "$file" ] || echo "$f: $link: no such file"
            case $link in *'#'*) headings_of "$file" | grep -qxF -- "${link#*#}" || echo "$f: $link: no such heading" ;; esac
        done
    done
}
# A page that begins with a map of its sections has all of them in it.
sections_in_no_map() {
    local f h
    pages "$1" | while read -r f; do
        grep -qx '| part | sections |' "$1/$f" || continue
        sed -n 's/^## /# /p' "$1/$f" > "$breaches/.sections"
        headings_of "$breaches/.sections" | while read -r h; do
            grep -qF "(#$h)" "$1/$f" || echo "$f: $h"
        done
    done
}
empty_assertions() { grep_code "$1" 'assert_true\((1|true)\)|assert_int_equal\(([0-9]+), \2\)'; }
# Numbers are read by base/number.h; texts of the kernel and of our own may be read by a pattern. HDR headers are older than the rule.
numbers_by_the_library() {
    grep_code "$1" '\b(strto(d|f|ld|l|ul|ll|ull|imax|umax)|ato[ifl]|f?s?scanf)\(' |
        grep -vE '^(tests|scenes)/|^base/(number|image_hdr)\.c:|^device/(model/vhci|sim/sim_unplug|drm/kms)\.c:'
}
scenes_of_no_test() { # tests load scenes by name
    (cd "$1" && find tests/scenes -name '*.json' -printf '%f\n' 2> /dev/null | while read -r scene; do
        grep -qrF --include='*.[ch]' "\"${scene%.json}\"" tests || echo "tests/scenes/$scene is loaded by no test"
    done)
}
# CI's lists name programs, and tests of programs, that are there.
listed_tests_are_there() {
    local list lists=()
    for list in statistics threads longest; do
        [ ! -e "$1/.ci/$list" ] || lists+=(".ci/$list")
    done
    (cd "$1" && find tests -name 'test_*.c' -o -name '*.sh' | awk '
        FILENAME == "-" { programs = programs "\n" $0; next }
        !index(programs, $0) { print FILENAME ": " $0 }' - "${lists[@]}")
    [ ! -e "$1/.ci/repeated" ] || while IFS=': ' read -r program name; do
        grep -qs "cmocka_unit_test[a-z_]*(${name}[,)]" "$1/$program.c" || echo ".ci/repeated: $program: $name"
    done < "$1/.ci/repeated"
}

# The newest commits, where the history is there: a subject fits into 72 characters.
long_commit_subjects() {
    GIT_CEILING_DIRECTORIES=$(dirname "$(realpath "$1")") git -C "$1" log -20 --no-merges --format='%h %s' 2> /dev/null |
        awk 'length(substr($0, index($0, " ") + 1)) > 72'
}

# Arrows that modules of render/ must not have: a folder, and a header that nothing in it may include.
forbidden() {
    cat << 'END'
render/scene render/render.h
render/scene render/transport/surface/surface.h
render/transport/surface render/transport/light/light.h
render/transport/light render/transport/path/track.h
render/transport/path render/transport/lanes/suffix.h
render/import/scene render/import/reader/source_material.h
render/import/scene render/film/film.h
render/film render/import/scene/scene_parse.h
render/film render/plane/rig.h
render/plane render/rows/visit.h
render/rows render/cameras/any_cameras.h
render/cameras render/plane/kernel.h
render/cameras render/papers/general.h
render/papers render/rows/visit.h
render/layers render/rows/visit.h
render/reconstruct render/plane/rig.h
render render/import/scene/scene_parse.h
render render/papers/general.h
END
}

# A tree in which every rule is broken once.
make_breaches() {
    mkdir -p "$1"/{render,quilt,tests/quilt,attic,.ci}
    touch "$1/attic/old"
    echo tests/render/test_gone > "$1/.ci/statistics"
    {
        printf '#include "quilt/quilt.h"\n\tint x; /* TO''DO */\n'
        printf '/* %0101d */\nvoid f(void)\n{\n    int y = 1;\n\n    if (p == NULL)\n' 0
        for _ in $(seq 90); do echo '    g();'; done
        printf '}\n'
    } > "$1/render/bad.c"
    printf '%0701d' 0 | tr 0 '\n' > "$1/render/long.c"
    printf '/* %090d name --\n */\nint t = i<2 * N && * left> zero;\n' 0 | sed 's/0/-/g' > "$1/render/torn.c"
    printf 'struct lf_wide {\n    int a%s;\n};\n' "$(seq -s ', a' 31)" > "$1/render/wide.h"
    printf 'struct lf_twice {\n    int x;\n};\n' | tee "$1/render/once.h" > "$1/quilt/twice.h"
    mkdir -p "$1/daemon/engine"
    printf '#include "daemon/server/server.h"\n' > "$1/daemon/engine/up.c"
    printf '#include "../server/server.h"\n' > "$1/daemon/engine/relative.c"
    printf '#include <render/rows/rows.h>\n' > "$1/daemon/engine/angles.c"
    printf '#include "daemon/output/output_internal.h"\n' > "$1/daemon/engine/internal.c"
    printf '#include "render/rows/visit.h"\n' > "$1/daemon/engine/behind.c"
    printf 'double x = ato''f("0x10");\n' > "$1/daemon/engine/number.c"
    forbidden | while read -r from header; do
        mkdir -p "$1/$from"
        printf '#include "%s"\n' "$header" >> "$1/$from/up.c"
    done
    mkdir -p "$1/daemon/parts" "$1/daemon/cellar"
    printf '#include "daemon/parts/watch.h"\nstruct lf_server *owner;\n' > "$1/daemon/parts/play_more.c"
    printf '#include "daemon/output/output.h"\n' > "$1/daemon/cellar/new.c"
    printf 'daemon/output: daemon/engine\n' > "$1/tests/layers"
    printf '__attribute__((target_''clones("avx2"))) int y;' > "$1/quilt/cloned.cc"
    mkdir -p "$1/tests/mutants" "$1/tests/scenes"
    touch "$1/tests/scenes/nobody.json"
    printf 'render/bad.c  a line that is not there\n- h();\n+ i();\n! render/test_bad\n' > "$1/tests/mutants/render.txt"
    printf 'assert_true(1);\n' > "$1/tests/quilt/test_bad.c"
    git -C "$1" init -q
    git -C "$1" add -A
    git -C "$1" -c user.name=x -c user.email=x@localhost commit -q --allow-empty -m "$(printf '%073d' 0)"
    printf '# Page\n\n| part | sections |\n|---|---|\n| one | [here](#here) [away](away.md) |\n\n## Hier (`x.c`)\n' > "$1/page.md"
}

# shellcheck source=tests/report.sh
. "$src/tests/report.sh"

breaches=$(mktemp -d)
trap 'rm -rf "$breaches"' EXIT
make_breaches "$breaches"
forbidden | while read -r from header; do
    echo "$from/up.c includes $header"
done | sort > "$breaches/.forbidden"
report forbidden "$(upward_includes "$breaches" | sed -E 's/:[0-9]+: / /' | sort | comm -13 - "$breaches/.forbidden")"
for rule in tabs_and_trailing_blanks long_lines broken_section_rules torn_expressions pointers_compared blanks_after_declarations missing_final_newline unfinished_words fast_math_and_clones modules_apart \
    includes_not_from_the_root own_headers_in_angles foreign_internal_headers parts_apart server_seen_from_outside layers_in_a_circle folders_in_no_row upward_includes includes_of_private_headers \
    cxx_only_for_libraries top_level long_functions long_files one_name_one_thing wide_structs stale_mutants empty_assertions numbers_by_the_library listed_tests_are_there scenes_of_no_test links_that_lead_nowhere sections_in_no_map long_commit_subjects; do
    if [ -z "$($rule "$breaches")" ]; then
        report "$rule" "the rule does not notice a breach of it"
    else
        report "$rule" "$($rule "$src")"
    fi
done

# What the object files show. C names that other files see begin with lf_, private ones of daemon/engine and daemon/output with their folder.
foreign_names() { # objects, libraries
    nm -A -g --defined-only "$@" 2> /dev/null |
        awk '$2 ~ /^[TDBRC]$/ && $3 !~ /^(lf_|engine_|output_|_Z|__|DW\.|_?asan)/ { sub(/:[0-9a-f]*$/, "", $1); print $1, $3 }'
}
mapfile -t isa_objects < <(find "$out"/render "$out"/quilt -name '*_avx2.c.o' -o -name '*_avx512.c.o' | sort)
# A file compiled for one instruction set holds functions and one table: a writable global there might be initialised, and an
# inline function from a header might be chosen by the linker, on a machine without the instructions.
isa_globals() {
    local o
    for o in "${isa_objects[@]}"; do
        objdump -t "$o" | awk -v o="${o##*/}" '/^[0-9a-f]+ +[lgu].* O \.(data|bss)[ \t]/ { print o, $NF, "(writable)" }
            /^[0-9a-f]+ +(w|u)/ && !/\*UND\*/ { print o, $NF, "(weak)" }
            /^[0-9a-f]+ +g/ && ++n > 1 { print o, $NF, "(a second name)" }'
    done
}
# A file of AVX uses wide registers, and clears their upper halves before it returns: code behind it would run at half its speed.
without_vzeroupper() { # objects
    local o
    for o in "$@"; do
        [ ! -e "$o" ] || objdump -d --no-show-raw-insn "$o" | grep -qm 1 vzeroupper || echo "$o"
    done
}
# Files of a folder call each other in one direction: of two of them at most one calls the other, by whatever way. hello lists the
# table that it stands in.
calls_in_a_circle() { # what nm -A says of them
    sed -E 's|^.*/([^/]*)\.c\.o:|\1 |' "$1" | awk '$2 == "U" { used[$1, $3] } $3 == "T" { where[$4] = $1 }
        END { for (u in used) { split(u, of, SUBSEP); if (of[2] in where && where[of[2]] != of[1]) print of[1], where[of[2]] } }' |
        grep -vx 'methods_table methods_status' | { tsort > /dev/null; } 2>&1
}
# What reads files from outside is not in the programs that go on when it ends.
reading_libraries() { # programs
    local p
    for p in "$@"; do
        [ ! -e "$out/$p" ] || readelf -d "$out/$p" | sed -nE "s/.*NEEDED.*\\[(lib(assimp|openvdb|webp|draco|meshoptimizer)[^]]*)\\].*/$p needs \\1/p"
        ! nm "$out/$p" 2> /dev/null | grep -qE ' [Tt] _Z' || echo "$p holds C++ of ours"
    done
}
if [ -n "$(reading_libraries quiltimport)" ] && [ -n "$(reading_libraries quiltimport-vdb)" ]; then
    report reading_libraries "$(reading_libraries quiltd quiltctl quiltrender quiltfarm quiltmerge quiltprint quiltsim quiltbench quiltweb)"
else
    report reading_libraries "the rule does not see what quiltimport needs"
fi
if command -v "${CC:-gcc}" > /dev/null && [ "$(uname -m)" = x86_64 ]; then
    printf '#include <immintrin.h>\nvoid f(float *p) { _mm256_storeu_ps(p, _mm256_add_ps(_mm256_loadu_ps(p), _mm256_loadu_ps(p))); }\n' > "$breaches/upper.c"
    "${CC:-gcc}" -O2 -mavx2 -mno-vzeroupper -c -o "$breaches/upper.o" "$breaches/upper.c"
    if [ -n "$(foreign_names "$breaches/upper.o")" ]; then
        report foreign_names "$(foreign_names "$out"/lib*.a)"
    else
        report foreign_names "the rule does not notice a breach of it"
    fi
    if [ -n "$(without_vzeroupper "$breaches/upper.o")" ]; then
        report without_vzeroupper "$(without_vzeroupper "${isa_objects[@]}")"
    else
        report without_vzeroupper "the rule does not notice a breach of it"
    fi
fi
if command -v "${CC:-gcc}" > /dev/null; then
    for name in one:two two:one; do
        printf 'void %s(void);\nvoid %s(void);\nvoid %s(void) { %s(); }\n' "${name%:*}" "${name#*:}" "${name%:*}" "${name#*:}" > "$breaches/${name%:*}.c"
        "${CC:-gcc}" -c -o "$breaches/${name%:*}.c.o" "$breaches/${name%:*}.c"
    done
    nm -A "$breaches"/{one,two}.c.o > "$breaches/circle.names"
    if [ -n "$(calls_in_a_circle "$breaches/circle.names")" ]; then
        for module in server parts; do
            (cd "$src" && printf '%s\n' daemon/"$module"/*.c) | sed "s|.*|$out/&.o|" | xargs nm -A 2> /dev/null > "$breaches/$module.names"
        done
        report calls_in_a_circle "$(calls_in_a_circle "$breaches/server.names")$(calls_in_a_circle "$breaches/parts.names")"
    else
        report calls_in_a_circle "the rule does not notice a breach of it"
    fi
fi
case ${BUILD:-release} in
release | debug) report isa_globals "$(isa_globals)" ;;
esac

end
