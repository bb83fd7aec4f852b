#include "tests/docs/tables.h"

#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "daemon/server/methods.h"
#include "render/papers/papers.h"

#define BEGINNING "<!-- table: "
#define END "<!-- end -->"

const char *const lf_table_pages[] = {"docs/reference/protocol.md", "docs/reference/options.md",
                                      "docs/reference/scene-format.md", NULL};

static const struct {
    const char *word;
    bool (*print)(const lf_table_source *source, const char *name, FILE *out);
} families[] = {
    {"method ", lf_table_method}, {"options ", lf_table_options}, {"scene ", lf_table_scene}};

void lf_tables_init(void)
{
    (void)lf_method_schema(0); /* of the daemon, which has no reference estimators */
    lf_papers_add();
}

/* ------------------------------------------------------------------------------------- texts -- */

void lf_table_number(double value, FILE *out)
{
    const double power = value != 0.0 ? round(log10(fabs(value))) : 0.0;
    if (value != 0.0 && fabs(pow(10.0, power) / fabs(value) - 1.0) < 1e-12 &&
        (power >= 6.0 || power < -4.0))
        fprintf(out, "%s1e%.0f", value < 0.0 ? "-" : "", power);
    else
        fprintf(out, "%.10g", value);
}

char *lf_table_default(const char *text, char *kept, char *default_text, size_t size)
{
    const size_t length = strlen(text);
    const char *open = strrchr(text, '(');
    snprintf(kept, size, "%s", text);
    default_text[0] = '\0';
    if (!open || open == text || text[length - 1] != ')')
        return kept;
    snprintf(kept, size, "%.*s", (int)(open - text - 1), text);
    snprintf(default_text, size, "%.*s", (int)(text + length - 2 - open), open + 1);
    return kept;
}

/* The length of the longest heading of a page that a text begins with; 0: none. */
static size_t heading_at(const char *page, const char *text)
{
    size_t longest = 0;
    for (const char *at = page; at && (at = strstr(at, "\n##"));) {
        at += strspn(at, "\n#");
        at += *at == ' ';
        const size_t length = strcspn(at, "\n");
        if (length > longest && strncmp(at, text, length) == 0 &&
            !isalnum((unsigned char)text[length]))
            longest = length;
    }
    return longest;
}

/* [Motion blur](#motion-blur) */
static void print_link(const char *heading, size_t length, const char *page, FILE *out)
{
    fprintf(out, "[%.*s](%s#", (int)length, heading, page);
    for (size_t i = 0; i < length; i++) {
        const int c = tolower((unsigned char)heading[i]);
        if (isalnum(c) || c == ' ' || c == '-' || c == '_')
            fputc(c == ' ' ? '-' : c, out);
    }
    fputc(')', out);
}

static bool is_among(const json_t *words, const char *word, size_t length)
{
    size_t i;
    json_t *each;
    json_array_foreach(words, i, each)
    {
        const char *text = json_string_value(each);
        if (text && strlen(text) == length && strncmp(text, word, length) == 0)
            return true;
    }
    return false;
}

/* An option, a name with an underscore, a text in quotes, a known word before a colon. */
static bool is_code(const char *word, size_t length, char next, const json_t *words)
{
    if (length > 2 && word[0] == '"' && word[length - 1] == '"')
        return true;
    if (length > 2 && strncmp(word, "--", 2) == 0)
        return true;
    return (memchr(word, '_', length) && !memchr(word, ' ', length)) ||
           (next == ':' && is_among(words, word, length));
}

static void print_escaped(const char *text, size_t length, FILE *out)
{
    for (size_t i = 0; i < length; i++)
        fprintf(out, "%s%c", text[i] == '|' ? "\\" : "", text[i]);
}

void lf_table_text(const lf_table_source *source, const char *text, const json_t *words, FILE *out)
{
    bool see = false;
    while (*text != '\0') {
        const size_t space = strspn(text, " ("), own = see ? heading_at(source->page, text) : 0,
                     far = see ? heading_at(source->scene_page, text) : 0;
        fprintf(out, "%.*s", (int)space, text);
        text += space;
        if (own > 0 || far > 0) {
            print_link(text, own > 0 ? own : far, own > 0 ? "" : "scene-format.md", out);
            text += own > 0 ? own : far;
        }
        size_t whole = strcspn(text, " "), core = whole;
        while (core > 0 && strchr(".,;:)", text[core - 1]))
            core--;
        const bool code = is_code(text, core, text[core], words);
        see = whole == 3 && strncmp(text, "see", 3) == 0;
        fputs(code ? "`" : "", out);
        print_escaped(text, core, out);
        fputs(code ? "`" : "", out);
        print_escaped(text + core, whole - core, out);
        text += whole;
        if (see && *text == ' ') {
            fputc(' ', out);
            text++;
        }
    }
}

/* ------------------------------------------------------------------------------------- pages -- */

static bool print_table(const lf_table_source *source, const char *name, FILE *out)
{
    for (size_t i = 0; i < sizeof families / sizeof *families; i++) {
        const size_t length = strlen(families[i].word);
        if (strncmp(name, families[i].word, length) == 0)
            return families[i].print(source, name + length, out);
    }
    return false;
}

/* The text between the markers of a table, as it has to be (free); NULL: it is not known. */
static char *make_table(const lf_table_source *source, const char *name)
{
    char *text = NULL;
    size_t size;
    FILE *out = open_memstream(&text, &size);
    const bool known = print_table(source, name, out);
    fclose(out);
    if (known)
        return text;
    free(text);
    return NULL;
}

/* From a marker to the one of its end, or NULL. */
static const char *fill_one(const lf_table_source *source, const char *at, FILE *out, char *name,
                            size_t size, bool *out_differs)
{
    const char *start = strchr(at, '\n'), *end = start ? strstr(start, END) : NULL;
    at += strlen(BEGINNING);
    snprintf(name, size, "%.*s", (int)strcspn(at, "\n"), at);
    char *arrow = strstr(name, " -->");
    if (arrow)
        *arrow = '\0';
    char *table = end && arrow ? make_table(source, name) : NULL;
    if (!table)
        return NULL;
    start++;
    *out_differs =
        strlen(table) != (size_t)(end - start) || strncmp(table, start, strlen(table)) != 0;
    fprintf(out, BEGINNING "%s -->\n%s", name, table);
    free(table);
    return end;
}

char *lf_tables_fill(const lf_table_source *source, char *out_name, size_t size)
{
    char *text = NULL, name[128];
    size_t length;
    FILE *out = open_memstream(&text, &length);
    const char *at = source->page, *next;
    out_name[0] = '\0';
    while ((next = strstr(at, BEGINNING))) {
        bool differs = false;
        fwrite(at, 1, (size_t)(next - at), out);
        at = fill_one(source, next, out, name, sizeof name, &differs);
        if ((!at || differs) && (!at || out_name[0] == '\0'))
            snprintf(out_name, size, "%s", name);
        if (!at)
            break;
    }
    if (at)
        fputs(at, out);
    fclose(out);
    if (at)
        return text;
    free(text);
    return NULL;
}
