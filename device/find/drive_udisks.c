#include <errno.h>
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <systemd/sd-bus.h>

#include "base/alloc.h"
#include "base/errno_text.h"
#include "base/thread.h"
#include "device/find/drive.h"

#define SERVICE "org.freedesktop.UDisks2"
#define MANAGER "/org/freedesktop/UDisks2/Manager"
#define OPTIONS "ro,nosuid,nodev,noexec"
#define BY_HAND                                                                                    \
    "mount it manually (mount -o " OPTIONS                                                         \
    "), or pass a copy of its LKG_calibration/visual.json with --calibration"

#define US_PER_S 1e6
/* From unmounting until the kernel, udev and the event loop have told of it. */
#define ECHO_S 5
/* For unmounting, which nobody waits for. */
#define UNMOUNT_S 2

const int lf_udisks_patient_ms = 15000;

/* Block devices that were mounted here, each until it is forgotten: lf_time_now, INFINITY while it
 * is mounted. */
static struct {
    pthread_mutex_t lock;
    struct {
        dev_t device;
        double until;
    } of[8]; /* the one that is forgotten first is given up for another */
} touched = {.lock = PTHREAD_MUTEX_INITIALIZER};

struct lf_udisks {
    sd_bus *bus;
    dev_t number;     /* of the block device */
    double until;     /* lf_time_now: the end of all asking */
    bool unanswered;  /* a mount was asked for, and may come yet */
    char object[256]; /* of the block device */
    char folder[4096];
};

const char *lf_udisks_folder(const lf_udisks *mount)
{
    return mount->folder;
}

static void touch(dev_t device, double until)
{
    enum { N = sizeof touched.of / sizeof touched.of[0] };
    int at = 0;
    pthread_mutex_lock(&touched.lock);
    for (int i = 0; i < N; i++)
        if (touched.of[i].until < touched.of[at].until)
            at = i;
    for (int i = 0; i < N; i++)
        if (touched.of[i].device == device)
            at = i;
    touched.of[at].device = device;
    touched.of[at].until = until;
    pthread_mutex_unlock(&touched.lock);
}

bool lf_find_touches(dev_t device)
{
    bool touches = false;
    double now = lf_time_now();
    pthread_mutex_lock(&touched.lock);
    for (size_t i = 0; i < sizeof touched.of / sizeof touched.of[0]; i++)
        touches = touches || (touched.of[i].device == device && touched.of[i].until > now);
    pthread_mutex_unlock(&touched.lock);
    return touches;
}

static void destroy(lf_udisks *mount)
{
    if (!mount)
        return;
    /* without flushing, which a bus that does not read could hold up */
    sd_bus_close_unref(mount->bus);
    lf_free(mount);
}

/* What is left of the time in microseconds, at least 1: to sd-bus 0 means "as long as it likes". */
static uint64_t left_us(const lf_udisks *mount)
{
    double left = mount->until - lf_time_now();
    return left > 0 ? (uint64_t)(left * US_PER_S) + 1 : 1;
}

/* Until the bus has let us in, for which sd-bus by itself would give it 90 s. A negative errno on
 * failure. */
static int connect_bus(lf_udisks *mount)
{
    int r = sd_bus_open_system(&mount->bus);
    while (r >= 0 && (r = sd_bus_is_ready(mount->bus)) == 0) {
        r = sd_bus_process(mount->bus, NULL);
        if (r == 0)
            r = lf_time_now() < mount->until ? sd_bus_wait(mount->bus, left_us(mount)) : -ETIMEDOUT;
    }
    return r;
}

static lf_status refused(const char *device, const sd_bus_error *why, int negative_errno,
                         lf_error *err)
{
    static const char *const absent[] = {"org.freedesktop.DBus.Error.ServiceUnknown",
                                         "org.freedesktop.DBus.Error.NameHasNoOwner",
                                         "org.freedesktop.DBus.Error.Spawn.ServiceNotFound"};
    if (sd_bus_error_has_name(why, SERVICE ".Error.AlreadyMounted"))
        return lf_error_set(err, LF_E_BUSY, device, "another user has mounted it in the meantime");
    for (size_t i = 0; i < sizeof absent / sizeof absent[0]; i++)
        if (sd_bus_error_has_name(why, absent[i]))
            return lf_error_set(
                err, LF_E_IO, device,
                "is not mounted, and udisks2 is not installed; install udisks2, " BY_HAND);
    if (why->name && strstr(why->name, ".NotAuthorized"))
        return lf_error_set(err, LF_E_IO, device,
                            "is not mounted, and polkit does not let udisks2 mount it for this "
                            "user (org.freedesktop.udisks2.filesystem-mount); " BY_HAND);
    return lf_error_set(err, LF_E_IO, device,
                        "is not mounted, and udisks2 cannot mount it: %.80s; " BY_HAND,
                        why->message ? why->message : lf_errno_text(-negative_errno));
}

/* The object that stands for a block device. */
static lf_status resolve(lf_udisks *mount, const char *device, lf_error *err)
{
    sd_bus_error why = SD_BUS_ERROR_NULL;
    sd_bus_message *reply = NULL;
    const char *object = NULL;
    lf_status status = LF_OK;
    sd_bus_set_method_call_timeout(mount->bus, left_us(mount));
    int r = sd_bus_call_method(mount->bus, SERVICE, MANAGER, SERVICE ".Manager", "ResolveDevice",
                               &why, &reply, "a{sv}a{sv}", 1, "path", "s", device, 0);
    if (r >= 0)
        r = sd_bus_message_enter_container(reply, 'a', "o");
    if (r >= 0)
        r = sd_bus_message_read(reply, "o", &object);
    if (r < 0)
        status = refused(device, &why, r, err);
    else if (r == 0 || strlen(object) >= sizeof mount->object)
        status = lf_error_set(err, LF_E_IO, device,
                              "is not mounted, and udisks2 does not list it; " BY_HAND);
    else
        snprintf(mount->object, sizeof mount->object, "%s", object);
    sd_bus_message_unref(reply);
    sd_bus_error_free(&why);
    return status;
}

static lf_status ask_to_mount(lf_udisks *mount, const char *device, lf_error *err)
{
    sd_bus_error why = SD_BUS_ERROR_NULL;
    sd_bus_message *reply = NULL;
    const char *folder = NULL;
    lf_status status = LF_OK;
    touch(mount->number, INFINITY);
    sd_bus_set_method_call_timeout(mount->bus, left_us(mount));
    int r = sd_bus_call_method(mount->bus, SERVICE, mount->object, SERVICE ".Filesystem", "Mount",
                               &why, &reply, "a{sv}", 2, "options", "s", OPTIONS,
                               "auth.no_user_interaction", "b", 1);
    mount->unanswered = r == -ETIMEDOUT;
    if (r < 0 && !mount->unanswered)
        touch(mount->number, 0); /* what happens to it now is others' doing */
    if (r >= 0)
        r = sd_bus_message_read(reply, "s", &folder);
    if (r < 0)
        status = refused(device, &why, r, err);
    else
        snprintf(mount->folder, sizeof mount->folder, "%s", folder);
    sd_bus_message_unref(reply);
    sd_bus_error_free(&why);
    return status;
}

lf_status lf_udisks_mount(const char *device, int total_ms, lf_udisks **out, lf_error *err)
{
    lf_status status;
    struct stat st;
    lf_udisks *mount = lf_calloc(1, sizeof *mount);
    if (!mount)
        return lf_error_set(err, LF_E_NOMEM, device, "out of memory");
    mount->until = lf_time_now() + total_ms * 1e-3;
    mount->number = stat(device, &st) == 0 ? st.st_rdev : 0;
    int r = connect_bus(mount);
    if (r < 0) {
        status = lf_error_set(err, LF_E_IO, device,
                              "is not mounted, and udisks2 cannot be asked, because %s; " BY_HAND,
                              r == -ETIMEDOUT ? "the system bus does not answer"
                                              : "there is no system bus");
        goto fail;
    }
    status = resolve(mount, device, err);
    if (status != LF_OK)
        goto fail;
    status = ask_to_mount(mount, device, err);
    if (status != LF_OK)
        goto fail;
    *out = mount;
    return LF_OK;
fail:
    if (mount->unanswered)
        /* udisks2 does one after the other: what is mounted too late does not stay mounted */
        lf_udisks_unmount(mount);
    else
        destroy(mount);
    return status;
}

void lf_udisks_unmount(lf_udisks *mount)
{
    if (!mount)
        return;
    mount->until = lf_time_now() + UNMOUNT_S;
    sd_bus_set_method_call_timeout(mount->bus, left_us(mount));
    /* What cannot be unmounted stays as it is, read-only: nothing to be told. */
    sd_bus_call_method(mount->bus, SERVICE, mount->object, SERVICE ".Filesystem", "Unmount", NULL,
                       NULL, "a{sv}", 1, "auth.no_user_interaction", "b", 1);
    touch(mount->number, lf_time_now() + ECHO_S);
    destroy(mount);
}
