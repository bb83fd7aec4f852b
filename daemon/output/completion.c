#include "daemon/output/completion.h"

#include <string.h>

enum { MAX_OPTIONS = 256 };

/* An option from either kind of table. */
typedef struct described {
    const char *name;
    const lf_param *row;           /* NULL: from the program's own table … */
    const lf_options_words *words; /* … with these words; NULL = none */
    bool takes;                    /* takes an argument */
} described;

typedef struct described_list {
    const lf_options_rules *rules;
    int n;
    described options[MAX_OPTIONS];
} described_list;

/* Several commands may have the same option. */
static void list_add(described_list *list, described option)
{
    for (int i = 0; i < list->n; i++)
        if (strcmp(list->options[i].name, option.name) == 0)
            return;
    if (list->n < MAX_OPTIONS)
        list->options[list->n++] = option;
}

static const char *shell_at(int index)
{
    static const char *const names[] = {"bash", "zsh", "fish", NULL};
    return names[index];
}

static const lf_options_words shell_words[] = {{"completion", shell_at}, {0}};

static void list_own(described_list *list, const lf_options_rules *rules)
{
    for (const struct option *own = rules->table; own && own->name; own++) {
        const lf_options_words *words = rules->words;
        while (words && words->option && strcmp(words->option, own->name) != 0)
            words++;
        list_add(list, (described){.name = own->name,
                                   .words = words && words->option ? words : NULL,
                                   .takes = own->has_arg == required_argument});
    }
    list_add(list, (described){.name = "help"});
    list_add(list, (described){.name = "version"});
    list_add(list, (described){.name = "completion", .words = shell_words, .takes = true});
}

static void list_rules(described_list *list, const lf_options_rules *rules)
{
    for (const lf_options_part *part = rules->parts; part && part->params; part++)
        for (const lf_param *row = part->params; row->name || row->option; row = lf_param_next(row))
            if (!row->former && lf_param_among(row, part->names))
                list_add(list, (described){.name = row->option,
                                           .row = row,
                                           .takes = (row->type != LF_PARAM_SWITCH || row->words) &&
                                                    !row->optional});
    list_own(list, rules);
}

static const char *word_at(const described *option, int index)
{
    const lf_param *row = option->row;
    if (!row)
        return option->words ? option->words->word_at(index) : NULL;
    if (row->type == LF_PARAM_LIST) {
        if (index < 2)
            return index == 0 ? "all" : "none";
        index -= 2;
    }
    return row->word_at ? row->word_at(index) : row->words ? row->words[index] : NULL;
}

/* Numbers are not completed; an argument that is neither word nor number may be a file. */
static bool takes_file(const described *option)
{
    return option->takes && !word_at(option, 0) &&
           (!option->row || option->row->type == LF_PARAM_TEXT);
}

/* Writes text in single quotes of a shell; a quote in it closes them, is escaped, and opens them
 * again. */
static void write_quoted(FILE *out, const char *text, const char *brackets)
{
    for (; *text != '\0'; text++)
        if (*text == '\'')
            fputs("'\\''", out);
        else if (brackets && (*text == '[' || *text == ']'))
            fputc(brackets[*text == ']'], out);
        else
            fputc(*text, out);
}

static void write_words(FILE *out, const described *option)
{
    const char *word;
    for (int i = 0; (word = word_at(option, i)); i++)
        fprintf(out, "%s%s", i > 0 ? " " : "", word);
}

static void write_operands(FILE *out, const lf_options_rules *rules)
{
    const char *word;
    for (int i = 0; (word = rules->operand_at(i)); i++)
        fprintf(out, "%s%s", i > 0 ? " " : "", word);
}

/* Writes a `case` branch for every operand with followers: the words between two texts. */
static void write_cases(FILE *out, const lf_options_rules *rules, const char *before,
                        const char *after)
{
    char word[128];
    for (int i = 0; rules->operand_at(i); i++) {
        for (int k = 0; rules->follower_at(i, k, word, sizeof word); k++) {
            if (k == 0)
                fprintf(out, "    %s)\n        %s", rules->operand_at(i), before);
            fprintf(out, "%s%s", k > 0 ? " " : "", word);
        }
        if (rules->follower_at(i, 0, word, sizeof word))
            fprintf(out, "%s\n        ;;\n", after);
    }
}

/* -------------------------------------------------------------------------------------- bash -- */

static void write_bash_options(const described_list *list, FILE *out)
{
    fputs("        case $takes in\n", out);
    for (int i = 0; i < list->n; i++) {
        const described *option = &list->options[i];
        if (!option->takes)
            continue;
        fprintf(out, "        --%s)", option->name);
        if (takes_file(option)) {
            fputs(" files=1 ;;\n", out);
        } else {
            fputs(" words='", out);
            write_words(out, option);
            fputs("' ;;\n", out);
        }
    }
    fputs("        esac\n    elif [[ $cur == -* ]]; then\n        words='", out);
    for (int i = 0; i < list->n; i++)
        fprintf(out, "%s--%s", i > 0 ? " " : "", list->options[i].name);
    fputs("'\n", out);
}

static void write_bash_operands(const lf_options_rules *rules, FILE *out)
{
    if (!rules->operand_at) {
        fputs("    else\n        files=1\n    fi\n", out);
        return;
    }
    fputs("    elif [ -z \"$operand\" ]; then\n        words='", out);
    write_operands(out, rules);
    fputs("'\n    else\n    case $operand in\n", out);
    write_cases(out, rules, "words='", "'");
    fputs("    esac\n    fi\n", out);
}

/* Takes the words before the cursor from the line, because bash splits its own at every = and :. */
static void write_bash_words(const described_list *list, FILE *out)
{
    fputs(
        "    local line=${COMP_LINE:0:COMP_POINT} cur operand= takes= words= files= word prefix=\n"
        "    local -a before\n"
        "    cur=${line##*[[:space:]]}\n"
        "    read -ra before <<< \"${line%\"$cur\"}\"\n"
        "    for word in \"${before[@]:1}\"; do\n"
        "        if [ -n \"$takes\" ]; then\n"
        "            takes=\n"
        "            continue\n"
        "        fi\n"
        "        case $word in\n"
        "        ",
        out);
    bool first = true;
    for (int i = 0; i < list->n; i++) {
        if (list->options[i].takes)
            fprintf(out, "%s--%s", first ? "" : " | ", list->options[i].name);
        first = first && !list->options[i].takes;
    }
    fputs(") takes=$word ;;\n"
          "        -*) ;;\n"
          "        *) operand=${operand:-$word} ;;\n"
          "        esac\n"
          "    done\n"
          "    if [[ -z $takes && $cur == --*=* ]]; then\n"
          "        takes=${cur%%=*} prefix=${cur%%=*}=\n"
          "    fi\n"
          "    if [ -n \"$takes\" ]; then\n",
          out);
}

static void write_bash(const described_list *list, FILE *out)
{
    const char *program = list->rules->program;
    fprintf(out,
            "# bash completion for %s, generated by `%s --completion bash`\n"
            "_%s() {\n",
            program, program, program);
    write_bash_words(list, out);
    write_bash_options(list, out);
    write_bash_operands(list->rules, out);
    fputs(
        "    local value=${cur#\"$prefix\"} breaks=\n"
        "    mapfile -t COMPREPLY < <(compgen -P \"$prefix\" -W \"$words\" -- \"$value\")\n"
        "    # no word, or a whole one: what stands behind it may be a file\n"
        "    if [[ -z $files && (${#COMPREPLY[@]} -eq 0 || ${COMPREPLY[0]-} == \"$prefix$value\") "
        "&&\n"
        "        ((-z $takes && $cur != -*) || $value == *:*) ]]; then\n"
        "        files=1 prefix+=${value%\"${value##*[=:]}\"} value=${value##*[=:]}\n"
        "    fi\n"
        "    if [ -n \"$files\" ]; then\n"
        "        mapfile -t COMPREPLY < <(compgen -P \"$prefix\" -f -- \"$value\")\n"
        "        compopt -o filenames 2> /dev/null\n"
        "    elif [[ ${COMPREPLY[0]-} == *[=:] ]]; then\n"
        "        compopt -o nospace 2> /dev/null\n"
        "    fi\n"
        "    # readline replaces what stands behind the last of its breaks\n"
        "    [[ $COMP_WORDBREAKS == *=* ]] && breaks+='='\n"
        "    [[ $COMP_WORDBREAKS == *:* ]] && breaks+=':'\n"
        "    [ -z \"$breaks\" ] || "
        "COMPREPLY=(\"${COMPREPLY[@]#\"${cur%\"${cur##*[$breaks]}\"}\"}\")\n",
        out);
    fprintf(out, "}\ncomplete -F _%s %s\n", program, program);
}

/* --------------------------------------------------------------------------------------- zsh -- */

static void write_zsh_option(const described *option, FILE *out)
{
    fprintf(out, "    '--%s%s", option->name, option->takes ? "=" : "");
    if (option->row && option->row->help) {
        fputc('[', out);
        write_quoted(out, option->row->help, "()");
        fputc(']', out);
    }
    if (word_at(option, 0)) {
        fputs(":word:(", out);
        write_words(out, option);
        fputc(')', out);
    } else if (option->takes) {
        fprintf(out, ":%s: %s", takes_file(option) ? "file" : "value",
                takes_file(option) ? "_files" : "");
    }
    fputs("' \\\n", out);
}

static void write_zsh(const described_list *list, FILE *out)
{
    const lf_options_rules *rules = list->rules;
    fprintf(out,
            "#compdef %s\n# made by `%s --completion zsh`\n"
            "local curcontext=$curcontext state line\ntypeset -A opt_args\n_arguments -C \\\n",
            rules->program, rules->program);
    for (int i = 0; i < list->n; i++)
        write_zsh_option(&list->options[i], out);
    if (!rules->operand_at) {
        fputs("    '*:file: _files'\n", out);
        return;
    }
    fputs("    '1:word:(", out);
    write_operands(out, rules);
    fputs(")' \\\n    '*:word:->followers' && return\n[[ $state == followers ]] || return 1\n"
          "case $line[1] in\n",
          out);
    write_cases(out, rules, "compadd -S '' -- ", "");
    fputs("esac\ncompset -P '*='\n_files\n", out);
}

/* -------------------------------------------------------------------------------------- fish -- */

static void write_fish_option(const char *program, const described *option, FILE *out)
{
    fprintf(out, "complete -c %s -l %s", program, option->name);
    if (option->takes)
        fputs(takes_file(option) ? " -r -F" : " -x", out);
    if (word_at(option, 0)) {
        fputs(" -a '", out);
        write_words(out, option);
        fputc('\'', out);
    }
    if (option->row && option->row->help) {
        fputs(" -d '", out);
        write_quoted(out, option->row->help, NULL);
        fputc('\'', out);
    }
    fputc('\n', out);
}

static void write_fish(const described_list *list, FILE *out)
{
    const lf_options_rules *rules = list->rules;
    char word[128];
    fprintf(out, "# fish completion for %s, generated by `%s --completion fish`\n", rules->program,
            rules->program);
    for (int i = 0; i < list->n; i++)
        write_fish_option(rules->program, &list->options[i], out);
    if (!rules->operand_at)
        return;
    fprintf(out, "complete -c %s -n __fish_use_subcommand -f -a '", rules->program);
    write_operands(out, rules);
    fputs("'\n", out);
    for (int i = 0; rules->operand_at(i); i++) {
        for (int k = 0; rules->follower_at(i, k, word, sizeof word); k++)
            fprintf(out, "complete -c %s -n '__fish_seen_subcommand_from %s' -a '%s'\n",
                    rules->program, rules->operand_at(i), word);
    }
}

static lf_status write_list(const described_list *list, const char *shell, FILE *out, lf_error *err)
{
    static const struct {
        const char *shell;
        void (*write)(const described_list *list, FILE *out);
    } shells[] = {{"bash", write_bash}, {"zsh", write_zsh}, {"fish", write_fish}};
    for (size_t i = 0; i < sizeof shells / sizeof *shells; i++) {
        if (strcmp(shell, shells[i].shell) == 0) {
            shells[i].write(list, out);
            return LF_OK;
        }
    }
    return lf_error_set(err, LF_E_ARG, "--completion", "\"%.40s\": expected bash, zsh or fish",
                        shell);
}

lf_status lf_completion_write(const lf_options_rules *rules, const char *shell, FILE *out,
                              lf_error *err)
{
    described_list list = {.rules = rules};
    list_rules(&list, rules);
    return write_list(&list, shell, out, err);
}

/* ---------------------------------------------------------------------------------- commands -- */

/* Set while commands report their rules; one per process, like getopt's state. */
static described_list *asking;
static const lf_completion_command *asked;
static int n_asked;

bool lf_completion_takes_rules(const lf_options_rules *rules)
{
    if (asking)
        list_rules(asking, rules);
    return asking;
}

static const char *command_at(int index)
{
    for (int i = 0; i < n_asked; i++)
        if (asked[i].name && index-- == 0)
            return asked[i].name;
    return NULL;
}

static bool no_follower(int operand, int index, char *word, size_t size)
{
    (void)operand, (void)index;
    if (size > 0)
        word[0] = '\0';
    return false;
}

lf_status lf_completion_write_commands(const char *program, const lf_completion_command *commands,
                                       int n, const char *shell, FILE *out, lf_error *err)
{
    const lf_options_rules rules = {
        .program = program, .operand_at = command_at, .follower_at = no_follower};
    described_list list = {.rules = &rules};
    asked = commands;
    n_asked = n;
    asking = &list;
    for (int i = 0; i < n; i++) {
        char name[64];
        snprintf(name, sizeof name, "%s", commands[i].name ? commands[i].name : program);
        (void)commands[i].run(1, (char *[]){name, NULL});
    }
    asking = NULL;
    return write_list(&list, shell, out, err);
}
