/* Shared by the commands of quiltbench. A command is one file (error.c, compare.c, …) and one line
 * of the table in quiltbench.c. Commands print their table to stdout, errors in one line to stderr,
 * and return an exit code (daemon/output/options.h). */
#ifndef LF_BENCH_H
#define LF_BENCH_H

#include <stdio.h>

#include <jansson.h>

#include "base/status.h"
#include "base/thread.h"

#define LF_BENCH_PROGRAM "quiltbench"

/* argv[0] is the command's name. */
int lf_bench_error(int argc, char **argv);
int lf_bench_compare(int argc, char **argv);
int lf_bench_curve(int argc, char **argv);
int lf_bench_table(int argc, char **argv);
int lf_bench_papers(int argc, char **argv);
int lf_bench_shown(int argc, char **argv);
int lf_bench_views(int argc, char **argv);
int lf_bench_micro(int argc, char **argv);
int lf_bench_live(int argc, char **argv);
int lf_bench_quilt(int argc, char **argv);
int lf_bench_skip(int argc, char **argv);
int lf_bench_usb(int argc, char **argv);
int lf_bench_video(int argc, char **argv);
int lf_bench_plan(int argc, char **argv);
/* argv[0] is the program's name. */
int lf_bench_all(int argc, char **argv);

/* "0.5%" or "0.005", at least 0; option names it in the error. */
LF_NODISCARD lf_status lf_bench_parse_share(const char *option, const char *text, double *out,
                                            lf_error *err);

/* {"cpu": model, "cpus": number this process may use, "kernel": …}: to be published with every
 * measurement. A new reference; NULL = out of memory. */
json_t *lf_bench_machine(void);

/* A number, or null if it is not finite. */
json_t *lf_bench_number(double value);

/* Writes object to path, indented ("-" = stdout), and releases it. object NULL: LF_E_NOMEM. */
LF_NODISCARD lf_status lf_bench_write_json(const char *path, json_t *object, lf_error *err);
/* Writes an array of objects as CSV, one per line, and releases it. There is a column for every
 * member of any object, in order of appearance. Members of a nested object become "OUTER_INNER";
 * lists are skipped. */
LF_NODISCARD lf_status lf_bench_write_csv(const char *path, json_t *rows, lf_error *err);
/* True if a path of the command line (NULL: none) is standard output; no table is then printed. */
bool lf_bench_is_stdout(const char *path);

/* Prints a number in a table, as %*.*f and as %*.*g; "-" if it is not finite. */
void lf_bench_put(FILE *out, int width, int digits, double value);
void lf_bench_put_short(FILE *out, int width, int digits, double value);

/* Writes text to path. text NULL: LF_E_NOMEM. */
LF_NODISCARD lf_status lf_bench_write_text(const char *path, const char *text, lf_error *err);

/* Draws PREFIX.svg and PREFIX.png with gnuplot. Writes data to PREFIX.dat, and commands, with the
 * set-up of the two pictures, to PREFIX.gp; commands refer to the data as `data`. Without gnuplot
 * it writes only both files, silently (lf_bench_plot_begin warns). */
LF_NODISCARD lf_status lf_bench_plot(const char *prefix, const char *data, const char *commands,
                                     lf_error *err);

/* To be called before the measurement: warns on stderr if there is no gnuplot. */
void lf_bench_plot_begin(const char *prefix);

/* lf_pool_create with an error. threads 0 = all CPUs. */
LF_NODISCARD lf_status lf_bench_pool(int threads, lf_pool **out_pool, lf_error *err);

/* Prints err and returns LF_EXIT_FAILED. */
int lf_bench_fail(const lf_error *err);

#endif
