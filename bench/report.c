/* Output of numbers: tables and CSV. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/bench.h"

void lf_bench_put(FILE *out, int width, int digits, double value)
{
    if (isfinite(value))
        fprintf(out, "%*.*f", width, digits, value);
    else
        fprintf(out, "%*s", width, "-");
}

void lf_bench_put_short(FILE *out, int width, int digits, double value)
{
    if (isfinite(value))
        fprintf(out, "%*.*g", width, digits, value);
    else
        fprintf(out, "%*s", width, "-");
}

/* --------------------------------------------------------------------------------------- csv -- */

/* Members of a nested object become PARENT_NAME; lists are skipped. */
static void flatten(const json_t *from, const char *parent, json_t *into)
{
    const char *key;
    json_t *value;
    json_object_foreach((json_t *)(uintptr_t)from, key, value)
    {
        char name[128];
        snprintf(name, sizeof name, "%s%s%s", parent, parent[0] ? "_" : "", key);
        if (json_is_object(value))
            flatten(value, name, into);
        else if (!json_is_array(value))
            (void)json_object_set(into, name, value);
    }
}

static void put_text(FILE *out, const char *text)
{
    if (!strpbrk(text, ",\"\r\n")) {
        fputs(text, out);
        return;
    }
    fputc('"', out);
    for (; *text != '\0'; text++)
        fprintf(out, *text == '"' ? "\"\"" : "%c", *text);
    fputc('"', out);
}

/* Writes nothing for null (unknown). */
static void put_value(FILE *out, const json_t *value)
{
    if (json_is_string(value))
        put_text(out, json_string_value(value));
    else if (json_is_integer(value))
        fprintf(out, "%lld", (long long)json_integer_value(value));
    else if (json_is_real(value))
        fprintf(out, "%.9g", json_real_value(value));
    else if (json_is_boolean(value))
        fputs(json_is_true(value) ? "true" : "false", out);
}

static void put_csv(FILE *out, const json_t *flat, const json_t *columns)
{
    const char *name, *comma = "";
    json_t *unused;
    const json_t *row;
    size_t i;
    json_object_foreach((json_t *)(uintptr_t)columns, name, unused)
    {
        fputs(comma, out);
        put_text(out, name);
        comma = ",";
    }
    json_array_foreach(flat, i, row)
    {
        comma = "\n";
        json_object_foreach((json_t *)(uintptr_t)columns, name, unused)
        {
            fputs(comma, out);
            put_value(out, json_object_get(row, name));
            comma = ",";
        }
    }
    fputc('\n', out);
}

lf_status lf_bench_write_csv(const char *path, json_t *rows, lf_error *err)
{
    json_t *flat = json_array(), *columns = json_object();
    const json_t *row;
    char *text = NULL;
    size_t i, size = 0;
    json_array_foreach(rows, i, row)
    {
        json_t *one = json_object();
        flatten(row, "", one);
        (void)json_object_update(columns, one);
        (void)json_array_append_new(flat, one);
    }
    FILE *out = rows && flat && columns ? open_memstream(&text, &size) : NULL;
    if (out) {
        put_csv(out, flat, columns);
        fclose(out);
    }
    lf_status status = LF_OK;
    if (text && lf_bench_is_stdout(path))
        fputs(text, stdout);
    else
        status = lf_bench_write_text(path, text, err);
    json_decref(rows);
    json_decref(flat);
    json_decref(columns);
    free(text);
    return status;
}
