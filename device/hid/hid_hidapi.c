#include <errno.h>
#include <fcntl.h>
#include <hidapi.h>
#include <linux/hidraw.h>
#include <pthread.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>
#include <wchar.h>

#include "base/errno_text.h"
#include "base/thread.h"
#include "device/device_table.h"
#include "device/hid/hid.h"

#define VENDOR 0x04d8
#define PRODUCT 0xef7e
#define PRODUCT_NAME L"HoloPlay"

/* hidapi keeps its last error of everything that is not about an open device in one place for all
 * threads. */
static pthread_mutex_t global_lock = PTHREAD_MUTEX_INITIALIZER;

static int hid_send(void *context, const uint8_t *report, size_t n)
{
    return hid_send_feature_report(context, report, n);
}

static int hid_receive(void *context, uint8_t *out, size_t max, int timeout_ms)
{
    int n = hid_read_timeout(context, out, max, timeout_ms);
    return n < 0 && errno == EINTR ? 0 : n;
}

static uint64_t hid_clock(void *context)
{
    (void)context;
    return lf_time_now_ns() / LF_NS_PER_MS;
}

static void close_device(void *context)
{
    hid_close(context);
}

/* Names of panels are ASCII; what is not becomes a question mark. */
static void narrow(const wchar_t *wide, char *out, size_t size)
{
    size_t n = 0;
    for (; wide[n] != 0 && n + 1 < size; n++)
        out[n] = wide[n] >= 0x20 && wide[n] < 0x7f ? (char)wide[n] : '?';
    out[n] = 0;
}

int lf_hid_list(lf_hid_place *out, int max)
{
    int n = 0;
    pthread_mutex_lock(&global_lock);
    struct hid_device_info *all = hid_enumerate(VENDOR, PRODUCT);
    for (const struct hid_device_info *d = all; d && n < max; d = d->next) {
        if (!d->product_string ||
            wcsncmp(d->product_string, PRODUCT_NAME, wcslen(PRODUCT_NAME)) != 0)
            continue;
        lf_device_text(out[n].path, sizeof out[n].path, d->path);
        narrow(d->product_string, out[n].product, sizeof out[n].product);
        n++;
    }
    hid_free_enumeration(all);
    pthread_mutex_unlock(&global_lock);
    return n;
}

static lf_status cannot_open(const char *path, int e, lf_error *err)
{
    if (e == ENOENT || e == ENODEV || e == ENXIO)
        return lf_error_set(err, LF_E_NODEV, path, "the device does not exist or was unplugged");
    if (e == EACCES || e == EPERM)
        return lf_error_set(err, LF_E_IO, path,
                            "no permission; install the udev rule 70-quiltd.rules (make install), "
                            "add the user to the group quiltd, and plug the panel in again");
    return lf_error_set(err, LF_E_IO, path, "cannot be opened as a HID device: %s",
                        lf_errno_text(e));
}

/* hidapi 0.13.1 writes into memory it has freed when what it opens turns out to be no hidraw
 * device: that is found out here. */
static lf_status check_hidraw(const char *path, lf_error *err)
{
    int size, fd = open(path, O_RDWR | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
    if (fd < 0)
        return cannot_open(path, errno, err);
    int e = ioctl(fd, HIDIOCGRDESCSIZE, &size) < 0 ? errno : 0;
    close(fd);
    return e == 0 ? LF_OK : cannot_open(path, e, err);
}

lf_status lf_hid_open(const char *path, lf_hid_link *out, lf_error *err)
{
    lf_status status = check_hidraw(path, err);
    if (status != LF_OK)
        return status;
    pthread_mutex_lock(&global_lock);
    hid_device *device = hid_open_path(path);
    pthread_mutex_unlock(&global_lock);
    if (!device)
        return lf_error_set(err, LF_E_IO, path, "hidapi cannot open the device");
    *out = (lf_hid_link){hid_send, hid_receive, hid_clock, close_device, device};
    return LF_OK;
}

void lf_hid_close(lf_hid_link *link)
{
    if (link->close)
        link->close(link->context);
    *link = (lf_hid_link){0};
}
