#include "device/find/drive.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/errno_text.h"
#include "device/device_table.h"

#define FOLDER "LKG_calibration"
#define FILE_NAME "visual.json"
#define LABEL "LKG-"

const lf_drive_places lf_drive_system = {.mountinfo = "/proc/self/mountinfo",
                                         .by_label = "/dev/disk/by-label"};

/* ----------------------------------------------------------------------------------- reading -- */

static lf_status cannot(const char *volume, lf_error *err)
{
    if (errno == ENOENT || errno == ENOTDIR)
        return lf_error_set(err, LF_E_NODEV, volume, "%s/%s does not exist", FOLDER, FILE_NAME);
    if (errno == ELOOP)
        return lf_error_set(err, LF_E_FORMAT, volume,
                            "%s/%s is a symbolic link; quiltd reads only regular files", FOLDER,
                            FILE_NAME);
    if (errno == EACCES || errno == EPERM)
        return lf_error_set(err, LF_E_IO, volume,
                            "no permission to read %s/%s, which is mounted for another user; "
                            "unmount it, or pass a copy with --calibration",
                            FOLDER, FILE_NAME);
    return lf_error_set(err, LF_E_IO, volume, "cannot read %s/%s: %s", FOLDER, FILE_NAME,
                        lf_errno_text(errno));
}

/* Opens the file through its folders, so that no link leads out of the volume. */
static lf_status open_file(const char *volume, int *out_fd, lf_error *err)
{
    struct stat st;
    lf_status status = LF_OK;
    int fd = -1, folder = -1, root = open(volume, O_PATH | O_DIRECTORY | O_CLOEXEC);
    if (root >= 0)
        folder = openat(root, FOLDER, O_PATH | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
    if (folder < 0 || fstatat(folder, FILE_NAME, &st, AT_SYMLINK_NOFOLLOW) != 0)
        status = cannot(volume, err);
    else if (!S_ISREG(st.st_mode))
        status = lf_error_set(err, LF_E_FORMAT, volume, "%s/%s is not a regular file", FOLDER,
                              FILE_NAME);
    else {
        fd = openat(folder, FILE_NAME, O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
        if (fd < 0)
            status = cannot(volume, err);
    }
    if (folder >= 0)
        close(folder);
    if (root >= 0)
        close(root);
    *out_fd = fd;
    return status;
}

/* At most max bytes, whatever size the file says it has. */
static lf_status read_file(int fd, const char *volume, char *data, size_t max, size_t *out_n,
                           lf_error *err)
{
    size_t n = 0;
    while (n < max) {
        ssize_t got = read(fd, data + n, max - n);
        if (got < 0 && errno == EINTR)
            continue;
        if (got < 0)
            return cannot(volume, err);
        if (got == 0)
            break;
        n += (size_t)got;
    }
    *out_n = n;
    return LF_OK;
}

lf_status lf_drive_read(const char *volume, lf_calibration *out, lf_error *err)
{
    int fd;
    size_t n = 0;
    char *text = NULL;
    lf_status status = open_file(volume, &fd, err);
    if (status != LF_OK)
        return status;
    text = lf_calloc(LF_CALIBRATION_MAX_BYTES + 1, 1);
    if (!text)
        status = lf_error_set(err, LF_E_NOMEM, volume, "out of memory");
    else
        status = read_file(fd, volume, text, LF_CALIBRATION_MAX_BYTES + 1, &n, err);
    close(fd);
    if (status == LF_OK) {
        char where[300];
        snprintf(where, sizeof where, "%.250s/%s/%s", volume, FOLDER, FILE_NAME);
        status = lf_calibration_parse(text, n, where, out, err);
    }
    lf_free(text);
    return status;
}

/* ------------------------------------------------------------------------------------ labels -- */

static int hex(char c)
{
    return c >= '0' && c <= '9' ? c - '0' : c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
}

/* udev writes what may not stand in a name as \xNN. */
static void decode_label(const char *name, char *out, size_t size)
{
    size_t n = 0;
    while (*name != 0 && n + 1 < size) {
        int high = name[0] == '\\' && name[1] == 'x' ? hex(name[2]) : -1;
        int low = high >= 0 ? hex(name[3]) : -1;
        out[n++] = (char)(low >= 0 ? high << 4 | low : name[0]);
        name += low >= 0 ? 4 : 1;
    }
    out[n] = 0;
}

/* The device that a link of the folder names; false when it names none. */
static bool device_of(const char *by_label, const char *name, char out[PATH_MAX])
{
    char path[PATH_MAX];
    int n = snprintf(path, sizeof path, "%s/%s", by_label, name);
    return n > 0 && (size_t)n < sizeof path && realpath(path, out);
}

/* The label of a mounted volume: udev's word for its device, else the name of the folder, which is
 * the label where a desktop has mounted it. */
static void label_of(const char *by_label, const char *device, const char *folder, char *out,
                     size_t size)
{
    char label[256], target[PATH_MAX];
    const char *slash = strrchr(folder, '/');
    lf_device_text(out, size, slash ? slash + 1 : folder);
    DIR *dir = opendir(by_label);
    if (!dir)
        return;
    for (struct dirent *e = readdir(dir); e; e = readdir(dir)) {
        if (e->d_name[0] == '.' || !device_of(by_label, e->d_name, target) ||
            strcmp(target, device) != 0)
            continue;
        decode_label(e->d_name, label, sizeof label);
        lf_device_text(out, size, label);
        break;
    }
    closedir(dir);
}

static bool is_panel_label(const char *label)
{
    return strncmp(label, LABEL, strlen(LABEL)) == 0;
}

/* --------------------------------------------------------------------------- mounted volumes -- */

/* The kernel writes blanks, line ends and backslashes as \NNN. */
static void decode_octal(char *s)
{
    char *to = s;
    while (*s != 0) {
        bool escape = s[0] == '\\' && s[1] >= '0' && s[1] <= '3' && s[2] >= '0' && s[2] <= '7' &&
                      s[3] >= '0' && s[3] <= '7';
        int byte = escape ? (s[1] - '0') << 6 | (s[2] - '0') << 3 | (s[3] - '0') : *s;
        *to++ = (char)byte;
        s += escape ? 4 : 1;
    }
    *to = 0;
}

typedef struct mounted {
    char *root, *folder, *source;
} mounted;

/* A line of mountinfo (proc(5)): "ID PARENT MAJOR:MINOR ROOT FOLDER OPTIONS [OPTIONAL…] - TYPE
 * SOURCE OPTIONS". Cuts it up. */
static bool parse_line(char *line, mounted *out)
{
    enum { ROOT = 3, FOLDER_FIELD = 4, OPTIONS = 5, SOURCE = 2 };
    char *rest = NULL;
    int n = 0, behind = -1;
    *out = (mounted){0};
    for (char *field = strtok_r(line, " \n", &rest); field;
         field = strtok_r(NULL, " \n", &rest), n++)
        if (n == ROOT)
            out->root = field;
        else if (n == FOLDER_FIELD)
            out->folder = field;
        else if (n > OPTIONS && behind < 0 && strcmp(field, "-") == 0)
            behind = n;
        else if (behind >= 0 && n - behind == SOURCE)
            out->source = field;
    if (!out->source)
        return false;
    decode_octal(out->root);
    decode_octal(out->folder);
    decode_octal(out->source);
    return true;
}

/* Whole volumes on block devices: nothing is asked of network and pseudo file systems, which might
 * not answer. */
static bool is_volume(const mounted *m)
{
    return m->folder[0] == '/' && strcmp(m->root, "/") == 0 && strncmp(m->source, "/dev/", 5) == 0;
}

static void fill(lf_found *out, const char *path, const char *label, lf_status status,
                 const lf_error *why)
{
    lf_device_text(out->path, sizeof out->path, path);
    lf_device_text(out->label, sizeof out->label, label);
    if (status != LF_OK)
        lf_device_problem(out->problem, sizeof out->problem, why);
}

/* A volume without the file is a drive like any other, unless its label says that it is a panel's.
 */
static bool look_at_volume(const lf_drive_places *places, const mounted *m, lf_found *out)
{
    char device[PATH_MAX], path[PATH_MAX + 64], label[sizeof out->label];
    lf_error why = {0};
    *out = (lf_found){.source = LF_SOURCE_DRIVE};
    lf_status status = lf_drive_read(m->folder, &out->calibration, &why);
    const char *source = realpath(m->source, device) ? device : m->source;
    label_of(places->by_label, source, m->folder, label, sizeof label);
    if ((status == LF_E_NODEV || status == LF_E_IO) && !is_panel_label(label))
        return false;
    snprintf(path, sizeof path, "%s/%s/%s", m->folder, FOLDER, FILE_NAME);
    fill(out, path, label, status, &why);
    return true;
}

static int list_mounted(const lf_drive_places *places, lf_found *out, int max)
{
    FILE *file = fopen(places->mountinfo, "re");
    char *line = NULL;
    size_t size = 0;
    int n = 0;
    if (!file)
        return 0;
    while (n < max && getline(&line, &size, file) > 0) {
        mounted m;
        if (parse_line(line, &m) && is_volume(&m))
            n += look_at_volume(places, &m, &out[n]);
    }
    free(line);
    fclose(file);
    return n;
}

/* -------------------------------------------------------------------------- unmounted drives -- */

static bool is_mounted(const lf_drive_places *places, const char *device)
{
    FILE *file = fopen(places->mountinfo, "re");
    char *line = NULL, real[PATH_MAX];
    size_t size = 0;
    bool found = false;
    while (file && !found && getline(&line, &size, file) > 0) {
        mounted m;
        if (parse_line(line, &m) && m.source[0] == '/')
            found = strcmp(realpath(m.source, real) ? real : m.source, device) == 0;
    }
    free(line);
    if (file)
        fclose(file);
    return found;
}

/* False when it is mounted by now: then it is read where that is. */
static bool look_at_device(const char *device, const char *label, lf_found *out)
{
    lf_udisks *mount = NULL;
    lf_error why = {0};
    *out = (lf_found){.source = LF_SOURCE_DRIVE};
    lf_status status = lf_udisks_mount(device, lf_udisks_patient_ms, &mount, &why);
    if (status == LF_E_BUSY)
        return false;
    if (status == LF_OK)
        status = lf_drive_read(lf_udisks_folder(mount), &out->calibration, &why);
    fill(out, device, label, status, &why);
    lf_udisks_unmount(mount);
    return true;
}

static int list_unmounted(const lf_drive_places *places, lf_found *out, int max)
{
    char label[256], device[PATH_MAX];
    int n = 0;
    DIR *dir = opendir(places->by_label);
    if (!dir)
        return 0;
    for (struct dirent *e = readdir(dir); e && n < max; e = readdir(dir)) {
        decode_label(e->d_name, label, sizeof label);
        if (is_panel_label(label) && device_of(places->by_label, e->d_name, device) &&
            !is_mounted(places, device))
            n += look_at_device(device, label, &out[n]);
    }
    closedir(dir);
    return n;
}

int lf_drive_list(const lf_drive_places *places, lf_found *out, int max)
{
    /* In this order: what is mounted by others meanwhile is not missed. */
    int n = list_unmounted(places, out, max);
    return n + list_mounted(places, out + n, max - n);
}

bool lf_drive_is_there(const lf_drive_places *places, char out_label[64])
{
    char label[256];
    bool there = false;
    DIR *dir = opendir(places->by_label);
    for (struct dirent *e = dir ? readdir(dir) : NULL; e && !there; e = readdir(dir)) {
        decode_label(e->d_name, label, sizeof label);
        there = is_panel_label(label);
    }
    if (dir)
        closedir(dir);
    if (there)
        lf_device_text(out_label, 64, label);
    return there;
}
