/* Anything that a program may send to the Unix socket of the older protocol, behind which there is
 * no quiltd. The first byte says in which parts it comes. Answers are whole frames, nobody stays
 * after the end, and images have their limit. */
#include "tests/fuzz/fuzz.h"

#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <systemd/sd-event.h>
#include <unistd.h>

#include "base/log.h"
#include "daemon/web/nng.h"

enum { MAX_STEPS = 100000, LIMIT = 4096 };

static sd_event *event;
static lf_driver *driver;
static lf_nng *nng;
static struct sockaddr_un address;
static socklen_t address_size;

static void begin(void)
{
    lf_error err = {0};
    if (nng)
        return;
    lf_log_init("fuzz", (lf_log_level)0);
    lf_fuzz_require(sd_event_new(&event) >= 0);
    const lf_driver_config config = {
        .event = event, .socket = "/nowhere", .version = "2.6.3", .image_limit = LIMIT};
    lf_fuzz_require(lf_driver_create(&config, &driver, &err) == LF_OK);
    const int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    address.sun_family = AF_UNIX;
    /* an abstract name, which the kernel chooses */
    lf_fuzz_require(bind(fd, (struct sockaddr *)&address, sizeof(sa_family_t)) == 0 &&
                    listen(fd, 4) == 0);
    address_size = sizeof address;
    lf_fuzz_require(getsockname(fd, (struct sockaddr *)&address, &address_size) == 0);
    lf_fuzz_require(lf_nng_create(event, fd, driver, &nng, &err) == LF_OK);
}

static void run(void)
{
    int steps = 0;
    while (sd_event_run(event, 0) > 0)
        lf_fuzz_require(++steps < MAX_STEPS);
}

/* What is answered, after what was answered before. */
static void receive(int fd, uint8_t *answers, size_t size, size_t *used)
{
    for (ssize_t n; (n = recv(fd, answers + *used, size - *used, MSG_DONTWAIT)) > 0;)
        *used += (size_t)n;
}

static void check_answers(const uint8_t *answers, size_t n)
{
    lf_fuzz_require(n == 0 || (n >= 8 && memcmp(answers, "\0SP\0\0\x31\0\0", 8) == 0));
    for (size_t at = 8; at < n;) {
        uint64_t length = 0;
        lf_fuzz_require(n - at >= 9 && answers[at] == 1);
        for (int i = 1; i < 9; i++)
            length = length << 8 | answers[at + (size_t)i];
        lf_fuzz_require(length >= 4 && length <= n - at - 9);
        at += 9 + (size_t)length;
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static uint8_t answers[1 << 20];
    size_t used = 0;
    if (size < 1)
        return 0;
    begin();
    const size_t step = (size_t)data[0] * 8 + 1;
    const int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    lf_fuzz_require(fd >= 0 && connect(fd, (struct sockaddr *)&address, address_size) == 0);
    run();
    for (size_t at = 1; at < size && used < sizeof answers / 2; at += step) {
        const size_t n = size - at < step ? size - at : step;
        if (send(fd, data + at, n, MSG_NOSIGNAL) < 0)
            break;
        run();
        receive(fd, answers, sizeof answers, &used);
    }
    shutdown(fd, SHUT_WR);
    run();
    receive(fd, answers, sizeof answers, &used);
    check_answers(answers, used);
    close(fd);
    run();
    lf_fuzz_require(lf_nng_clients(nng) == 0);
    lf_fuzz_require(lf_driver_bytes(driver) <= 2 * LIMIT); /* images with names stay */
    return 0;
}
