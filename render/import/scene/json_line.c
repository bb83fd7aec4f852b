/* Finds the line of a JSON pointer by walking the text beside it: the parser keeps no positions. */
#include <string.h>

#include "base/number.h"
#include "render/import/scene/former_keys.h"
#include "render/import/scene/json_reader.h"

typedef struct cursor {
    const char *at, *end;
    int line;
} cursor;

static void step(cursor *c)
{
    if (c->at < c->end && *c->at++ == '\n')
        c->line++;
}

static void skip_space(cursor *c)
{
    while (c->at < c->end && strchr(" \t\r\n", *c->at))
        step(c);
}

/* Over a string; the cursor stands on its opening quote. */
static void skip_string(cursor *c)
{
    step(c);
    while (c->at < c->end && *c->at != '"') {
        if (*c->at == '\\')
            step(c);
        step(c);
    }
    step(c);
}

static void skip_value(cursor *c)
{
    int depth = 0;
    do {
        skip_space(c);
        if (c->at >= c->end)
            return;
        if (*c->at == '"') {
            skip_string(c);
        } else if (strchr("{[", *c->at)) {
            depth++;
            step(c);
        } else if (strchr("}]", *c->at)) {
            depth--;
            step(c);
        } else if (strchr(",:", *c->at)) {
            step(c);
        } else {
            while (c->at < c->end && !strchr(",:]} \t\r\n", *c->at))
                step(c);
        }
    } while (depth > 0);
}

/* One token of a pointer without its escapes; returns what follows it. */
static const char *next_token(const char *pointer, char *out, size_t size)
{
    size_t n = 0;
    for (pointer++; *pointer && *pointer != '/'; pointer++) {
        char c = *pointer;
        if (c == '~' && (pointer[1] == '0' || pointer[1] == '1'))
            c = *++pointer == '0' ? '~' : '/';
        if (n + 1 < size)
            out[n++] = c;
    }
    out[n] = '\0';
    return pointer;
}

/* Whether the string literal [begin, end), quotes included, is key. */
static bool literal_is(const char *begin, const char *end, const char *key)
{
    json_t *value =
        json_loadb(begin, (size_t)(end - begin), JSON_DECODE_ANY | JSON_ALLOW_NUL, NULL);
    bool same = value && json_string_length(value) == strlen(key) &&
                strcmp(json_string_value(value), key) == 0;
    json_decref(value);
    return same;
}

/* Moves from the opening bracket of an object to the value of key. */
static bool enter_object(cursor *c, const char *key)
{
    step(c);
    for (;;) {
        skip_space(c);
        if (c->at >= c->end || *c->at != '"')
            return false;
        const char *begin = c->at;
        skip_string(c);
        bool found = literal_is(begin, c->at, key);
        skip_space(c);
        step(c);
        skip_space(c);
        if (found)
            return true;
        skip_value(c);
        skip_space(c);
        if (c->at >= c->end || *c->at != ',')
            return false;
        step(c);
    }
}

static bool enter_array(cursor *c, const char *token)
{
    uint64_t index;
    if (!lf_whole_is(token, &index))
        return false;
    step(c);
    skip_space(c);
    for (uint64_t i = 0; i < index; i++) {
        skip_value(c);
        skip_space(c);
        if (c->at >= c->end || *c->at != ',')
            return false;
        step(c);
        skip_space(c);
    }
    return c->at < c->end && *c->at != ']';
}

int lf_json_line(const char *text, size_t size, const char *pointer)
{
    cursor c = {text, text + size, 1};
    skip_space(&c);
    int line = c.line;
    while (*pointer == '/' && c.at < c.end) {
        char token[256];
        pointer = next_token(pointer, token, sizeof token);
        const cursor before = c;
        bool found = *c.at == '{'   ? enter_object(&c, token)
                     : *c.at == '[' ? enter_array(&c, token)
                                    : false;
        const char *former = found ? NULL : lf_former_key(token);
        if (former && *before.at == '{') {
            c = before;
            found = enter_object(&c, former);
        }
        if (!found)
            break;
        line = c.line;
    }
    return line;
}
