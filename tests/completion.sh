#!/bin/bash
# What shells complete: every option that --help names, methods, keys, words and files, as bash would ask for them; scripts that
# bash, zsh and fish can read.
set -u
src=${QUILTD_SOURCE:-.}
out=${QUILTD_BUILD:-build/release}
out=$(cd "$out" && pwd)
# shellcheck source=tests/report.sh
. "$src/tests/report.sh"

top=$(mktemp -d)
trap 'rm -rf "$top"' EXIT
programs=(quiltd quiltctl quiltrender quiltfarm quiltmerge quiltprint quiltsim quiltbench quiltweb)
for p in "${programs[@]}"; do
    for s in bash zsh fish; do
        "$out/$p" --completion "$s" > "$top/$p.$s" || echo "$p: $s: exit status not 0" >> "$top/complaints"
    done
done
report "completions are written" "$(cat "$top/complaints" 2> /dev/null)"

# What a program says of itself; of quiltbench all commands.
help_of() {
    "$out/$1" --help
    [ "$1" != quiltbench ] || for c in $(commands); do "$out/$1" "$c" --help; done
}
commands() { "$out/quiltbench" --help | sed -n 's/^  \([a-z]*\)  *[a-z].*/\1/p'; }
# Every option that the help of a program names, in quotes of prose or in its list; completion is asked for with nothing else.
options_of() { help_of "$1" | grep -oE -- '(^|[^-a-z])--[a-z][a-z0-9-]*' | grep -oE -- '--[a-z0-9-]+' | grep -vx -- --completion | sort -u; }
lacking() {
    local p o
    for p in "${programs[@]}"; do
        [ "$(options_of "$p" | wc -l)" -gt 3 ] || echo "$p: its help names no options"
        for o in $(options_of "$p"); do
            grep -qE -- "[ ']$o([ '|)]|\$)" "$top/$p.bash" || echo "$p.bash: $o"
            grep -qE -- "'${o}[='[]" "$top/$p.zsh" || echo "$p.zsh: $o"
            grep -qE -- "-l ${o#--}( |\$)" "$top/$p.fish" || echo "$p.fish: $o"
        done
    done
}
report "no option is missing" "$(lacking)"

# What bash would offer for a line, one a line, in a folder with a file scene.json and a folder stills.
offered() { # line
    (
        mkdir -p "$top/here/stills" && touch "$top/here/scene.json" && cd "$top/here" || exit
        # shellcheck source=/dev/null
        . "$top/${1%% *}.bash"
        COMP_LINE=$1 COMP_POINT=${#1} COMP_WORDBREAKS=$' \t\n"'\''><=;|&(:'
        COMPREPLY=()
        "_${1%% *}" 2>&1
        printf '%s\n' "${COMPREPLY[@]}"
    )
}
offers() { # line, what is offered for it
    local got
    got=$(offered "$1" | paste -sd' ')
    [ "$got" = "$2" ] || echo "\"$1\": offered \"$got\", expected \"$2\""
}
has_word() { offered "$1" | grep -qxF -- "$2" || echo "\"$1\": $2 is not among: $(offered "$1" | paste -sd' ')"; }
in_bash() {
    offers 'quiltctl camera.or' 'camera.orbit'
    offers 'quiltctl camera.orbit ya' 'yaw='
    offers 'quiltctl --socket /run/x camera.orbit p' 'pitch='
    offers 'quiltctl wait for=c' 'coarse complete converged' # readline replaces what is behind the =
    offers 'quiltctl render.set paused=' 'true false'
    offers 'quiltctl --format p' 'prometheus'
    offers 'quiltctl --format=p' 'prometheus'
    offers 'quiltctl do' 'doctor'
    offers 'quiltctl scene.load file=sc' 'scene.json'
    offers 'quiltctl export ch' 'chart'
    offers 'quiltctl export chart sce' 'scene.json'
    offers 'quiltd sc' 'scene.json'
    offers 'quiltd --dev' '--device'
    offers 'quiltd --device no' 'none'
    offers 'quiltd --device sim:st' 'stills'
    offers 'quiltd --threads ' ''
    offers 'quiltrender scene.json --estimator mw' 'mwis'
    offers 'quiltbench cur' 'curve'
    offers 'quiltbench curve --contenders' '--contenders'
    offers 'quiltbench curve sc' 'scene.json'
    offers 'quiltfarm st' 'status'
    offers 'quiltfarm plan job --engine p' 'parallel'
    has_word 'quiltd --preset ' portrait
    has_word 'quiltctl ' status
}
# the daemon's table has these
methods() { sed -n 's/^    {"\([a-z.]*\)", ".*/\1/p' "$src/daemon/server/methods_table.c"; }
every_method() { for m in $(methods); do has_word 'quiltctl ' "$m"; done; }
report "bash is offered what fits" "$(in_bash)"
report "every method is offered" "$(every_method)"
every_command() { for c in $(commands); do has_word 'quiltbench ' "$c"; done; }
report "every command is offered" "$([ "$(commands | wc -l)" -ge 12 ] || echo "quiltbench --help names few commands"; every_command)"

for s in bash zsh fish; do
    if command -v "$s" > /dev/null 2>&1; then
        report "$s can read them" "$(for p in "${programs[@]}"; do "$s" -n "$top/$p.$s" 2>&1; done)"
    else
        skip "$s can read them" "no $s"
    fi
done
words=$("$out/quiltd" --completion csh 2>&1)
report "another shell is refused" "$(case $? in 2) ;; *) echo "exit status not 2: $words" ;; esac)"

end
