/* Calibrations on drives: mounted ones by a list of mounts made for the test, unmounted ones
 * through a udisks2 of the test's own on a private bus, and what hostile drives hold. */
#include "tests/testing.h"

#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <systemd/sd-bus.h>

#include "base/alloc.h"
#include "base/file.h"
#include "device/find/drive.h"

static const char good[] =
    "{\"serial\":\"LKG-PORT-TEST\",\"pitch\":52.5,\"slope\":-7.25,\"center\":0.375,\"viewCone\":40,"
    "\"DPI\":324,\"screenW\":1536,\"screenH\":2048}";

/* The number of the test's block devices, which are files. */
enum { NO_DEVICE = 0 };

/* A machine of the test's own: volumes, a list of mounts and a folder of labels. */
typedef struct machine {
    char *folder;
    char mountinfo[PATH_MAX], by_label[PATH_MAX], mounts[8192], paths[16][PATH_MAX];
    int n_paths;
    lf_drive_places places;
} machine;

static int set_up(void **state)
{
    machine *m = calloc(1, sizeof *m);
    assert_non_null(m);
    m->folder = lf_test_folder();
    snprintf(m->by_label, sizeof m->by_label, "%s/by-label", m->folder);
    assert_int_equal(mkdir(m->by_label, 0700), 0);
    snprintf(m->mountinfo, sizeof m->mountinfo, "%s", lf_test_write(m->folder, "mountinfo", ""));
    m->places = (lf_drive_places){m->mountinfo, m->by_label};
    *state = m;
    return 0;
}

static int tear_down(void **state)
{
    machine *m = *state;
    lf_test_folder_remove(m->folder);
    free(m);
    return 0;
}

/* A path of the test's machine; as long as that lives. */
LF_PRINTF(2, 3) static const char *path_of(machine *m, const char *fmt, ...)
{
    char relative[256];
    va_list arguments;
    va_start(arguments, fmt);
    vsnprintf(relative, sizeof relative, fmt, arguments);
    va_end(arguments);
    assert_true(m->n_paths < 16);
    char *path = m->paths[m->n_paths++];
    snprintf(path, PATH_MAX, "%s", lf_test_path(m->folder, relative));
    return path;
}

/* A volume's folder; with a calibration of this text (NULL = the folder for it is missing). */
static const char *make_volume(machine *m, const char *name, const char *text, size_t n)
{
    char relative[256];
    const char *volume = path_of(m, "%s", name);
    assert_int_equal(mkdir(volume, 0700), 0);
    if (!text)
        return volume;
    snprintf(relative, sizeof relative, "%s/LKG_calibration", name);
    assert_int_equal(mkdir(lf_test_path(m->folder, relative), 0700), 0);
    snprintf(relative, sizeof relative, "%s/LKG_calibration/visual.json", name);
    FILE *file = fopen(lf_test_path(m->folder, relative), "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(text, 1, n, file), n);
    assert_int_equal(fclose(file), 0);
    return volume;
}

static void write_mounts(machine *m)
{
    lf_test_write(m->folder, "mountinfo", m->mounts);
}

static void add_mount(machine *m, const char *folder, const char *source)
{
    size_t n = strlen(m->mounts);
    snprintf(m->mounts + n, sizeof m->mounts - n,
             "310 30 8:17 / %s ro,nosuid,nodev,noexec,relatime shared:172 master:3 - vfat %s "
             "ro,fmask=0022\n",
             folder, source);
    write_mounts(m);
}

/* A block device (here a file) with a label as udev writes it; its path. */
static const char *add_label(machine *m, const char *device, const char *label)
{
    const char *path = path_of(m, "%s", device);
    lf_test_write(m->folder, device, "");
    assert_int_equal(symlink(path, lf_test_path(m->by_label, label)), 0);
    return path;
}

/* The device by a path as mountinfo has it: sources are looked at only below /dev. */
static const char *below_dev(machine *m, const char *device)
{
    assert_true(m->n_paths < 16);
    char *path = m->paths[m->n_paths++];
    snprintf(path, PATH_MAX, "/dev/..%.4000s", device);
    return path;
}

static void a_mounted_volume_tells_its_calibration(void **state)
{
    machine *m = *state;
    lf_found found[4];
    lf_calibration expected;
    lf_assert_ok(lf_calibration_parse(good, strlen(good), "good", &expected, NULL), NULL);
    add_mount(m, make_volume(m, "stick", NULL, 0), "/dev/nonexistent1");
    add_mount(m, make_volume(m, "LKG-P00671", good, strlen(good)), "/dev/nonexistent2");
    assert_int_equal(lf_drive_list(&m->places, found, 4), 1);
    assert_memory_equal(&found[0].calibration, &expected, sizeof expected);
    assert_int_equal(found[0].source, LF_SOURCE_DRIVE);
    assert_string_equal(found[0].label, "LKG-P00671");
    assert_string_equal(found[0].problem, "");
    assert_string_equal(found[0].path, path_of(m, "LKG-P00671/LKG_calibration/visual.json"));
    assert_int_equal(lf_drive_list(&m->places, found, 0), 0);
}

static void blanks_and_backslashes_in_names_are_decoded(void **state)
{
    machine *m = *state;
    lf_found found[4];
    char encoded[PATH_MAX];
    make_volume(m, "my\tpanel \\040\n1", good, strlen(good));
    snprintf(encoded, sizeof encoded, "%s/my\\011panel\\040\\134040\\0121", m->folder);
    add_mount(m, encoded, "/dev/nonexistent1");
    assert_int_equal(lf_drive_list(&m->places, found, 4), 1);
    assert_string_equal(found[0].problem, "");
    assert_string_equal(found[0].label, "my?panel \\040?1");
}

static void only_whole_volumes_of_block_devices_are_looked_at(void **state)
{
    machine *m = *state;
    lf_found found[4];
    const char *volume = make_volume(m, "LKG-P1", good, strlen(good));
    static const char *const lines[] = {
        "310 30 0:17 / %s rw - nfs4 server:/export rw\n",
        "310 30 0:17 / %s rw - tmpfs tmpfs rw\n",
        "310 30 8:17 /below %s rw - vfat /dev/nonexistent1 rw\n",
        "310 30 8:17 / %s rw\n",
        "310 30 8:17 / %s rw - vfat\n",
        "310 30 8:17 /\n",
        "\n",
        "- - - - - - - - -\n",
        "310 30 8:17 / relative rw - vfat /dev/nonexistent1 rw\n",
        "%s",
    };
    for (size_t i = 0; i < sizeof lines / sizeof lines[0]; i++) {
        const char *at = strstr(lines[i], "%s");
        size_t before = at ? (size_t)(at - lines[i]) : strlen(lines[i]);
        snprintf(m->mounts, sizeof m->mounts, "%.*s%s%s", (int)before, lines[i], at ? volume : "",
                 at ? at + 2 : "");
        write_mounts(m);
        assert_int_equal(lf_drive_list(&m->places, found, 4), 0);
    }
    m->mounts[0] = 0;
    add_mount(m, volume, "/dev/nonexistent1");
    assert_int_equal(lf_drive_list(&m->places, found, 4), 1);
    m->places.mountinfo = "/nonexistent";
    assert_int_equal(lf_drive_list(&m->places, found, 4), 0);
}

/* What stands in the place of the file, and what is said of it. */
static void assert_problem(machine *m, const char *word)
{
    lf_found found[2];
    lf_calibration nothing = {0};
    assert_int_equal(lf_drive_list(&m->places, found, 2), 1);
    if (!strstr(found[0].problem, word))
        fail_msg("\"%s\" does not say \"%s\"", found[0].problem, word);
    assert_memory_equal(&found[0].calibration, &nothing, sizeof nothing);
    for (const char *p = found[0].problem; *p != 0; p++)
        assert_true((unsigned char)*p >= 0x20 && *p != 0x7f);
}

static void no_link_leads_out_of_a_volume(void **state)
{
    machine *m = *state;
    const char *volume = make_volume(m, "LKG-P1", good, strlen(good));
    const char *file = path_of(m, "LKG-P1/LKG_calibration/visual.json"),
               *folder = path_of(m, "LKG-P1/LKG_calibration");
    const char *elsewhere = path_of(m, "secret.json");
    lf_test_write(m->folder, "secret.json", good);
    add_mount(m, volume, "/dev/nonexistent1");
    assert_int_equal(unlink(file), 0);
    assert_int_equal(symlink(elsewhere, file), 0);
    assert_problem(m, "not a regular file");
    assert_int_equal(unlink(file), 0);
    assert_problem(m, "LKG_calibration/visual.json does not exist");
    assert_int_equal(rmdir(folder), 0);
    make_volume(m, "other", good, strlen(good));
    assert_int_equal(symlink(path_of(m, "other/LKG_calibration"), folder), 0);
    assert_problem(m, "LKG_calibration/visual.json does not exist");
}

static void what_is_no_file_is_not_waited_for(void **state)
{
    machine *m = *state;
    const char *volume = make_volume(m, "LKG-P1", good, strlen(good));
    const char *file = path_of(m, "LKG-P1/LKG_calibration/visual.json");
    add_mount(m, volume, "/dev/nonexistent1");
    assert_int_equal(unlink(file), 0);
    assert_int_equal(mkfifo(file, 0600), 0);
    assert_problem(m, "not a regular file");
    assert_int_equal(unlink(file), 0);
    assert_int_equal(mkdir(file, 0700), 0);
    assert_problem(m, "not a regular file");
}

static void damaged_files_are_told_with_the_reason(void **state)
{
    machine *m = *state;
    static char large[LF_CALIBRATION_MAX_BYTES + 1];
    memset(large, ' ', sizeof large);
    memcpy(large, good, strlen(good));
    const struct {
        const char *text;
        size_t n;
        const char *word;
    } cases[] = {
        {large, sizeof large, "at most 65536"},
        {"", 0, "not JSON"},
        {"{\"pitch\":0}", 11, "/pitch: expected a number"},
        {"\x1b[2J", 4, "not JSON"},
        {"{\"\x1b[31m\":1}", 11, "not JSON"},
        {"{}", 2, "expected a number"},
        {"{\"pitch\":1e400}", 15, "not JSON"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char name[16];
        snprintf(name, sizeof name, "LKG-%zu", i);
        m->mounts[0] = 0;
        add_mount(m, make_volume(m, name, cases[i].text, cases[i].n), "/dev/nonexistent1");
        assert_problem(m, cases[i].word);
    }
    m->mounts[0] = 0;
    add_mount(m, make_volume(m, "sound", large, sizeof large - 1), "/dev/nonexistent1");
    lf_found found[2];
    assert_int_equal(lf_drive_list(&m->places, found, 2), 1);
    assert_string_equal(found[0].problem, "");
}

static void a_volume_of_another_user_is_told_only_when_it_is_a_panel(void **state)
{
    machine *m = *state;
    lf_found found[2];
    bool root = geteuid() == 0;
    const char *panel = make_volume(m, "LKG-P1", good, strlen(good)),
               *stick = make_volume(m, "stick", good, strlen(good));
    add_mount(m, panel, "/dev/nonexistent1");
    add_mount(m, stick, "/dev/nonexistent2");
    assert_int_equal(lf_drive_list(&m->places, found, 2), 2);
    assert_int_equal(chmod(m->folder, 0755), 0);
    assert_int_equal(chmod(m->by_label, 0755), 0);
    assert_int_equal(chmod(panel, 0), 0);
    assert_int_equal(chmod(stick, 0), 0);
    if (root)
        assert_int_equal(seteuid(65534), 0);
    int n = lf_drive_list(&m->places, found, 2);
    if (root)
        assert_int_equal(seteuid(0), 0);
    assert_int_equal(chmod(panel, 0700), 0);
    assert_int_equal(chmod(stick, 0700), 0);
    assert_int_equal(n, 1);
    assert_string_equal(found[0].label, "LKG-P1");
    assert_non_null(strstr(found[0].problem, "no permission"));
}

static void the_label_is_that_of_the_device(void **state)
{
    machine *m = *state;
    lf_found found[2];
    const char *device = add_label(m, "sda1", "LKG-P\\x20\\xc3\\xa4\\x1b\\x5c");
    add_label(m, "sdb1", "OTHER");
    const char *volume = make_volume(m, "usb", good, strlen(good));
    add_mount(m, volume, below_dev(m, device));
    assert_int_equal(lf_drive_list(&m->places, found, 2), 1);
    assert_string_equal(found[0].label, "LKG-P \xc3\xa4?\\");
    assert_string_equal(found[0].problem, "");
}

static void real_calibrations_come_from_a_drive_unchanged(void **state)
{
    machine *m = *state;
    for (int i = 0; i < LF_TEST_CALIBRATIONS; i++) {
        char name[16], *text = NULL;
        size_t n = 0;
        snprintf(name, sizeof name, "panel%d", i);
        const char *path = lf_test_calibration(i);
        if (!path)
            skip();
        lf_calibration expected;
        lf_found found[2];
        lf_assert_ok(lf_calibration_load(path, &expected, NULL), NULL);
        lf_assert_ok(lf_file_read(path, NULL, LF_CALIBRATION_MAX_BYTES, &text, &n, NULL), NULL);
        m->mounts[0] = 0;
        add_mount(m, make_volume(m, name, text, n), "/dev/nonexistent1");
        lf_free(text);
        assert_int_equal(lf_drive_list(&m->places, found, 2), 1);
        assert_memory_equal(&found[0].calibration, &expected, sizeof expected);
    }
}

/* ----------------------------------------------------------------------------------- udisks2 -- */

/* A bus of the test's own, and a udisks2 on it that does what the test wants. */
typedef struct fake {
    pid_t bus_pid;
    sd_bus *bus;
    pthread_t thread;
    int wake[2];         /* a byte, and the thread ends */
    const char *refusal; /* name of the error that Mount gives; NULL = it mounts … */
    const char *folder;  /* … here */
    /* it mounts what Mount is called for in this folder, just before; NULL = nobody does */
    machine *desktop;
    bool stranger;         /* ResolveDevice knows no device */
    bool late;             /* Mount is not answered */
    char device[PATH_MAX]; /* asked for */
    char options[64];      /* … with these options … */
    bool no_interaction;   /* … and without questions */
    bool touches;          /* it was said to be mounted by ourselves when Mount was called */
    int n_mounts, n_unmounts;
} fake;

static int read_options(sd_bus_message *message, fake *f)
{
    int r = sd_bus_message_enter_container(message, 'a', "{sv}");
    while (r >= 0 && (r = sd_bus_message_enter_container(message, 'e', "sv")) > 0) {
        const char *key, *text;
        int yes;
        r = sd_bus_message_read(message, "s", &key);
        if (r >= 0 && strcmp(key, "options") == 0) {
            r = sd_bus_message_read(message, "v", "s", &text);
            snprintf(f->options, sizeof f->options, "%s", text);
        } else if (r >= 0 && strcmp(key, "path") == 0) {
            r = sd_bus_message_read(message, "v", "s", &text);
            snprintf(f->device, sizeof f->device, "%s", text);
        } else if (r >= 0 && strcmp(key, "auth.no_user_interaction") == 0) {
            r = sd_bus_message_read(message, "v", "b", &yes);
            f->no_interaction = yes != 0;
        } else {
            r = sd_bus_message_skip(message, "v");
        }
        if (r >= 0)
            r = sd_bus_message_exit_container(message);
    }
    return r;
}

static int serve(sd_bus_message *message, void *data, sd_bus_error *error)
{
    fake *f = data;
    int r = read_options(message, f);
    if (r < 0)
        return r;
    if (sd_bus_message_is_method_call(message, "org.freedesktop.UDisks2.Manager", "ResolveDevice"))
        return f->stranger ? sd_bus_reply_method_return(message, "ao", 0)
                           : sd_bus_reply_method_return(
                                 message, "ao", 1, "/org/freedesktop/UDisks2/block_devices/sda1");
    if (sd_bus_message_is_method_call(message, "org.freedesktop.UDisks2.Filesystem", "Mount")) {
        f->n_mounts++;
        if (f->late)
            return 1;
        f->touches = lf_find_touches(NO_DEVICE);
        if (f->desktop)
            add_mount(f->desktop, f->folder, below_dev(f->desktop, f->device));
        return f->refusal ? sd_bus_error_set(error, f->refusal, "it said no\x1b[31m")
                          : sd_bus_reply_method_return(message, "s", f->folder);
    }
    if (sd_bus_message_is_method_call(message, "org.freedesktop.UDisks2.Filesystem", "Unmount")) {
        f->n_unmounts++;
        return sd_bus_reply_method_return(message, "");
    }
    return 0;
}

static void *serve_all(void *data)
{
    fake *f = data;
    for (;;) {
        int r = sd_bus_process(f->bus, NULL);
        if (r < 0)
            return NULL;
        if (r > 0)
            continue;
        struct pollfd p[2] = {
            {.fd = sd_bus_get_fd(f->bus), .events = (short)sd_bus_get_events(f->bus)},
            {.fd = f->wake[0], .events = POLLIN}};
        if (poll(p, 2, -1) < 0 || p[1].revents != 0)
            return NULL;
    }
}

/* Starts a bus; its address in $DBUS_SYSTEM_BUS_ADDRESS. False, with a word, where there is no
 * dbus-daemon. */
static bool start_bus(fake *f, const machine *m)
{
    char config[1024], path[PATH_MAX], address[512];
    int out[2];
    snprintf(config, sizeof config,
             "<busconfig><type>session</type><listen>unix:dir=%s</listen><auth>EXTERNAL</"
             "auth><policy context=\"default\">"
             "<allow send_destination=\"*\"/><allow receive_sender=\"*\"/><allow "
             "own=\"*\"/></policy></busconfig>",
             m->folder);
    snprintf(path, sizeof path, "--config-file=%s", lf_test_write(m->folder, "bus.conf", config));
    assert_int_equal(pipe2(out, O_CLOEXEC), 0);
    f->bus_pid = fork();
    assert_true(f->bus_pid >= 0);
    if (f->bus_pid == 0) {
        prctl(PR_SET_PDEATHSIG, SIGKILL);
        dup2(out[1], 1);
        execlp("dbus-daemon", "dbus-daemon", path, "--nofork", "--nopidfile", "--print-address=1",
               (char *)NULL);
        _exit(127);
    }
    close(out[1]);
    ssize_t n = read(out[0], address, sizeof address - 1);
    close(out[0]);
    if (n <= 0) {
        print_message("dbus-daemon cannot be started\n");
        waitpid(f->bus_pid, NULL, 0);
        return false;
    }
    address[n] = 0;
    address[strcspn(address, "\n")] = 0;
    setenv("DBUS_SYSTEM_BUS_ADDRESS", address, 1);
    return true;
}

static void stop_bus(fake *f)
{
    kill(f->bus_pid, SIGKILL);
    waitpid(f->bus_pid, NULL, 0);
    unsetenv("DBUS_SYSTEM_BUS_ADDRESS");
}

static void start_udisks(fake *f)
{
    assert_true(sd_bus_open_system(&f->bus) >= 0);
    assert_true(sd_bus_add_fallback(f->bus, NULL, "/org/freedesktop/UDisks2", serve, f) >= 0);
    assert_true(sd_bus_request_name(f->bus, "org.freedesktop.UDisks2", 0) >= 0);
    assert_int_equal(pipe2(f->wake, O_CLOEXEC), 0);
    assert_int_equal(pthread_create(&f->thread, NULL, serve_all, f), 0);
}

static void stop_udisks(fake *f)
{
    assert_int_equal(write(f->wake[1], "", 1), 1);
    assert_int_equal(pthread_join(f->thread, NULL), 0);
    close(f->wake[0]);
    close(f->wake[1]);
    sd_bus_flush_close_unref(f->bus);
}

/* What is found of the only panel, which nobody has mounted, by the udisks2 that f describes. */
static lf_found find_unmounted(const machine *m, fake *f)
{
    lf_found found[2];
    if (!start_bus(f, m))
        skip();
    start_udisks(f);
    int n = lf_drive_list(&m->places, found, 2);
    stop_udisks(f);
    stop_bus(f);
    assert_int_equal(n, 1);
    return found[0];
}

static void assert_says(const lf_found *found, const char *word)
{
    if (!strstr(found->problem, word))
        fail_msg("\"%s\" does not say \"%s\"", found->problem, word);
    for (const char *p = found->problem; *p != 0; p++)
        assert_true((unsigned char)*p >= 0x20 && *p != 0x7f);
}

static void an_unmounted_drive_is_mounted_for_reading_only_and_unmounted(void **state)
{
    machine *m = *state;
    fake f = {.folder = make_volume(m, "mounted", good, strlen(good))};
    const char *device = add_label(m, "sda1", "LKG-P00671");
    add_label(m, "sdb1", "STICK");
    lf_found found = find_unmounted(m, &f);
    assert_string_equal(found.problem, "");
    assert_string_equal(found.label, "LKG-P00671");
    assert_string_equal(found.path, device);
    assert_string_equal(found.calibration.serial, "LKG-PORT-TEST");
    assert_string_equal(f.device, device);
    assert_string_equal(f.options, "ro,nosuid,nodev,noexec");
    assert_true(f.no_interaction);
    assert_int_equal(f.n_mounts, 1);
    assert_int_equal(f.n_unmounts, 1);
    assert_true(f.touches);
    assert_true(lf_find_touches(NO_DEVICE)); /* for what is told of it late */
    assert_false(lf_find_touches(NO_DEVICE + 1));
}

static void a_mounted_panel_is_not_mounted_again(void **state)
{
    machine *m = *state;
    lf_found found[4];
    const char *source = below_dev(m, add_label(m, "sda1", "LKG-P00671"));
    add_mount(m, make_volume(m, "usb", good, strlen(good)), source);
    setenv("DBUS_SYSTEM_BUS_ADDRESS", "unix:path=/nonexistent", 1);
    assert_int_equal(lf_drive_list(&m->places, found, 4), 1);
    assert_string_equal(found[0].problem, "");
    unsetenv("DBUS_SYSTEM_BUS_ADDRESS");
}

static void what_a_desktop_mounts_meanwhile_is_read_there(void **state)
{
    machine *m = *state;
    fake f = {.refusal = "org.freedesktop.UDisks2.Error.AlreadyMounted",
              .folder = make_volume(m, "LKG-P1", good, strlen(good))};
    f.desktop = m;
    add_label(m, "sda1", "LKG-P1");
    lf_found found = find_unmounted(m, &f);
    assert_string_equal(found.problem, "");
    assert_string_equal(found.calibration.serial, "LKG-PORT-TEST");
    assert_string_equal(found.path, path_of(m, "LKG-P1/LKG_calibration/visual.json"));
    assert_int_equal(f.n_mounts, 1);
    assert_int_equal(f.n_unmounts, 0);
    assert_true(f.touches);
    assert_false(lf_find_touches(NO_DEVICE));
}

static void a_drive_is_unmounted_also_when_it_holds_nothing(void **state)
{
    machine *m = *state;
    fake f = {.folder = make_volume(m, "mounted", NULL, 0)};
    add_label(m, "sda1", "LKG-P00671");
    lf_found found = find_unmounted(m, &f);
    assert_says(&found, "LKG_calibration/visual.json does not exist");
    assert_int_equal(f.n_unmounts, 1);
}

static void a_refusal_says_what_to_do(void **state)
{
    machine *m = *state;
    const struct {
        const char *refusal, *word;
    } cases[] = {
        {"org.freedesktop.UDisks2.Error.NotAuthorized", "polkit"},
        {"org.freedesktop.UDisks2.Error.NotAuthorizedCanObtain", "polkit"},
        {"org.freedesktop.UDisks2.Error.Failed", "it said no"},
        {"org.freedesktop.DBus.Error.ServiceUnknown", "install udisks2"},
    };
    add_label(m, "sda1", "LKG-P00671");
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        fake f = {.refusal = cases[i].refusal};
        lf_found found = find_unmounted(m, &f);
        assert_says(&found, cases[i].word);
        assert_says(&found, "--calibration");
        assert_int_equal(f.n_mounts, 1);
        assert_int_equal(f.n_unmounts, 0);
    }
    fake f = {.stranger = true};
    lf_found found = find_unmounted(m, &f);
    assert_says(&found, "udisks2 does not list it");
    assert_int_equal(f.n_mounts, 0);
}

/* Takes calls and answers none. */
static int listen_silently(const machine *m)
{
    char path[PATH_MAX], address[PATH_MAX + 16];
    struct sockaddr_un at = {.sun_family = AF_UNIX};
    snprintf(path, sizeof path, "%s/silent", m->folder);
    assert_true(strlen(path) < sizeof at.sun_path);
    memcpy(at.sun_path, path, strlen(path));
    int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    assert_true(fd >= 0);
    assert_int_equal(bind(fd, (const struct sockaddr *)&at, sizeof at), 0);
    assert_int_equal(listen(fd, 8), 0);
    snprintf(address, sizeof address, "unix:path=%s", path);
    setenv("DBUS_SYSTEM_BUS_ADDRESS", address, 1);
    return fd;
}

static void a_bus_that_is_silent_is_not_waited_for_for_ever(void **state)
{
    const machine *m = *state;
    lf_udisks *mount = NULL;
    lf_error err = {0};
    int fd = listen_silently(m);
    lf_assert_status(lf_udisks_mount("/dev/sda1", 50, &mount, &err), LF_E_IO, &err);
    close(fd);
    unsetenv("DBUS_SYSTEM_BUS_ADDRESS");
    assert_non_null(strstr(err.what, "does not answer"));
    assert_null(mount);
}

/* 1 s is for asking which device that is, and for what comes before. */
static void a_mount_that_is_not_answered_is_undone(void **state)
{
    machine *m = *state;
    lf_udisks *mount = NULL;
    lf_error err = {0};
    fake f = {.late = true};
    if (!start_bus(&f, m))
        skip();
    start_udisks(&f);
    lf_status status = lf_udisks_mount("/dev/sda1", 1000, &mount, &err);
    stop_udisks(&f);
    stop_bus(&f);
    lf_assert_status(status, LF_E_IO, &err);
    assert_null(mount);
    assert_int_equal(f.n_mounts, 1);
    assert_int_equal(f.n_unmounts, 1);
}

static void without_udisks_it_is_said_how_to_mount_by_hand(void **state)
{
    machine *m = *state;
    lf_found found[2];
    fake f = {0};
    add_label(m, "sda1", "LKG-P00671");
    setenv("DBUS_SYSTEM_BUS_ADDRESS", "unix:path=/nonexistent", 1);
    assert_int_equal(lf_drive_list(&m->places, found, 2), 1);
    assert_says(&found[0], "there is no system bus");
    assert_says(&found[0], "mount -o ro");
    unsetenv("DBUS_SYSTEM_BUS_ADDRESS");
    if (!start_bus(&f, m))
        skip();
    assert_int_equal(lf_drive_list(&m->places, found, 2), 1);
    assert_says(&found[0], "install udisks2");
    assert_says(&found[0], "mount -o ro");
    stop_bus(&f);
}

#define test(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        test(a_mounted_volume_tells_its_calibration),
        test(blanks_and_backslashes_in_names_are_decoded),
        test(only_whole_volumes_of_block_devices_are_looked_at),
        test(no_link_leads_out_of_a_volume),
        test(what_is_no_file_is_not_waited_for),
        test(damaged_files_are_told_with_the_reason),
        test(a_volume_of_another_user_is_told_only_when_it_is_a_panel),
        test(the_label_is_that_of_the_device),
        test(real_calibrations_come_from_a_drive_unchanged),
        test(an_unmounted_drive_is_mounted_for_reading_only_and_unmounted),
        test(a_mounted_panel_is_not_mounted_again),
        test(what_a_desktop_mounts_meanwhile_is_read_there),
        test(a_drive_is_unmounted_also_when_it_holds_nothing),
        test(a_refusal_says_what_to_do),
        test(a_bus_that_is_silent_is_not_waited_for_for_ever),
        test(a_mount_that_is_not_answered_is_undone),
        test(without_udisks_it_is_said_how_to_mount_by_hand),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
