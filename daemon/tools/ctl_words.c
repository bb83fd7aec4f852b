#include <stdio.h>
#include <string.h>

#include "base/former.h"
#include "daemon/server/methods.h"
#include "daemon/tools/ctl.h"

static int count_methods(void)
{
    int n = 0;
    while (lf_method_at(n))
        n++;
    return n;
}

const char *lf_ctl_operand_at(int index)
{
    static const char *const own[] = {"watch", NULL};
    int n = count_methods();
    return index < n ? lf_method_at(index)->name : own[index - n];
}

/* Word number *left of a key, counted down; its prefix is "key=". */
static bool take_word(const char *prefix, json_t *words, int *left, char *word, size_t size)
{
    size_t i;
    json_t *value;
    json_array_foreach(words, i, value)
    {
        if ((*left)-- > 0)
            continue;
        char number[24] = "";
        if (json_is_integer(value))
            snprintf(number, sizeof number, "%lld", (long long)json_integer_value(value));
        snprintf(word, size, "%s%s", prefix,
                 json_is_string(value) ? json_string_value(value) : number);
        return true;
    }
    return false;
}

static bool take_key(const char *key, const json_t *property, int *left, char *word, size_t size)
{
    const char *type = json_string_value(json_object_get(property, "type"));
    char prefix[80];
    snprintf(prefix, sizeof prefix, "%.64s=", key);
    json_t *words = json_incref(json_object_get(property, "enum"));
    if (!words && type && strcmp(type, "boolean") == 0)
        words = json_pack("[s, s]", "true", "false");
    if (!words)
        words = json_pack("[s]", "");
    bool taken = take_word(prefix, words, left, word, size);
    json_decref(words);
    return taken;
}

bool lf_ctl_follower_at(int operand, int index, char *word, size_t size)
{
    json_t *properties = json_object_get(lf_method_schema(operand), "properties"), *property;
    const char *key;
    if (operand >= count_methods())
        return false;
    if (strcmp(lf_method_at(operand)->name, "export") == 0 &&
        take_word("", json_object_get(json_object_get(properties, "kind"), "enum"), &index, word,
                  size))
        return true;
    json_object_foreach(properties, key, property)
    {
        if (!lf_former_name_of(property) && take_key(key, property, &index, word, size))
            return true;
    }
    return false;
}
