#include "daemon/web/counts.h"

static void write_one(FILE *out, const char *name, const char *type, const char *help,
                      uint64_t value)
{
    fprintf(out, "# HELP quiltweb_%s %s\n# TYPE quiltweb_%s %s\nquiltweb_%s %llu\n", name, help,
            name, type, name, (unsigned long long)value);
}

void lf_web_counts_write(const lf_web_counts *counts, FILE *out)
{
    const struct {
        const char *name, *type, *help;
        uint64_t value;
    } rows[] = {
        {"requests_total", "counter", "HTTP requests.", counts->requests},
        {"refused_total", "counter", "Requests with a wrong host, origin, body or token.",
         counts->refused},
        {"uploads_total", "counter", "Bodies received whole.", counts->uploads},
        {"connections", "gauge", "Open connections of all kinds.", (uint64_t)counts->connections},
        {"websockets", "gauge", "Open WebSockets.", (uint64_t)counts->websockets},
        {"streams", "gauge", "Clients of /preview.mjpg.", (uint64_t)counts->streams},
        {"upload_files", "gauge", "Uploads in memory.", (uint64_t)counts->upload_files},
        {"upload_bytes", "gauge", "Bytes of these uploads, also of those still on their way.",
         counts->upload_bytes},
        {"download_files", "gauge", "Exported files in memory.", (uint64_t)counts->download_files},
        {"download_bytes", "gauge", "Bytes of these files.", counts->download_bytes},
        {"bridge_requests_total", "counter", "Requests of programs that speak to Bridge.",
         counts->bridge_requests},
        {"bridge_failures_total", "counter", "Those of them that were answered with Failure.",
         counts->bridge_failures},
        {"driver_commands_total", "counter", "Commands of programs of the older protocol.",
         counts->driver_commands},
        {"driver_failures_total", "counter", "Those of them that failed.", counts->driver_failures},
        {"driver_image_bytes", "gauge", "Bytes of images of these programs.", counts->driver_bytes},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++)
        write_one(out, rows[i].name, rows[i].type, rows[i].help, rows[i].value);
}
