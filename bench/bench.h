/* What the commands of quiltbench share. A command is one file (error.c, compare.c, …) and one line
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
/* argv[0] is the program's name. */
int lf_bench_all(int argc, char **argv);

/* "0.5%" or "0.005", at least 0; option names it in the error. */
LF_NODISCARD lf_status lf_bench_parse_share(const char *option, const char *text, double *out,
                                            lf_error *err);

/* {"cpu": model, "cpus": how many this process may use, "kernel": …}: what every published number
 * needs beside it. A new reference; NULL = out of memory. */
json_t *lf_bench_machine(void);

/* A number, or null for what is not finite. */
json_t *lf_bench_number(double value);

/* Writes object to path, indented ("-" = stdout), and gives it up. NULL is LF_E_NOMEM. */
LF_NODISCARD lf_status lf_bench_write_json(const char *path, json_t *object, lf_error *err);
/* An array of objects as CSV, one a line: a column for every member that one of them has, in the
 * order in which they come; of an object in an object "OUTER_INNER"; lists are left out. Given up,
 * too. */
LF_NODISCARD lf_status lf_bench_write_csv(const char *path, json_t *rows, lf_error *err);
/* Whether a path of the command line (NULL: none) is standard output: then no table is printed. */
bool lf_bench_is_stdout(const char *path);

/* A number in a table, as %*.*f and as %*.*g; "-" for what is not finite. */
void lf_bench_put(FILE *out, int width, int digits, double value);
void lf_bench_put_short(FILE *out, int width, int digits, double value);

/* Writes text to path. NULL is LF_E_NOMEM. */
LF_NODISCARD lf_status lf_bench_write_text(const char *path, const char *text, lf_error *err);

/* Draws PREFIX.svg and PREFIX.png with gnuplot from data, which is left as PREFIX.dat, and
 * commands, left as PREFIX.gp with what sets up the two pictures around them; commands name the
 * data as `data`. Without gnuplot: both files, without a word (lf_bench_plot_begin). */
LF_NODISCARD lf_status lf_bench_plot(const char *prefix, const char *data, const char *commands,
                                     lf_error *err);

/* To be called before what is to be drawn is measured: says on stderr when there is no gnuplot. */
void lf_bench_plot_begin(const char *prefix);

/* lf_pool_create with an error. threads 0 = all CPUs. */
LF_NODISCARD lf_status lf_bench_pool(int threads, lf_pool **out_pool, lf_error *err);

/* Prints err and returns LF_EXIT_FAILED. */
int lf_bench_fail(const lf_error *err);

#endif
