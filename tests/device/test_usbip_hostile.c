/* The USB/IP server, driven as nobody should drive it. */
#include "tests/device/usbip_host.h"

#include "base/alloc.h"

static void nonsense_ends_the_connection(void **state)
{
    (void)state;
    static const struct {
        bool imported;
        size_t at; /* in a good header */
        uint32_t value;
    } cases[] = {
        {false, 0, 0x01060000 | 0x8005},
        {false, 0, 0x01118009},
        {true, 0, 0},
        {true, 0, RET_SUBMIT},
        {true, 8, 0x00020001},
        {true, 12, 2},
        {true, 16, 16},
        {true, 32, 8},
        {true, 0, 0xffffffff},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        fixture *f = connect_to(NULL, NULL, cases[i].imported);
        uint8_t header[HEADER];
        make_header(header, SUBMIT, 1, true, 1);
        put32(header + cases[i].at, cases[i].value);
        send_all(f, header, sizeof header);
        lf_assert_status(run(f), LF_E_FORMAT, NULL);
        end(f);
    }
}

static void a_claim_of_4_gib_is_not_believed(void **state)
{
    (void)state;
    fixture *f = connect_to(NULL, NULL, true);
    uint8_t header[HEADER];
    uint64_t before = lf_alloc_count();
    make_header(header, SUBMIT, 1, false, 2);
    put32(header + 24, UINT32_MAX);
    send_all(f, header, sizeof header);
    expect(f, RET_SUBMIT, 1, -ENOMEM);
    assert_int_equal(lf_alloc_count(), before);
    end(f);
}

/* What was refused is read over: the message behind it is understood. */
static void refused_data_is_skipped(void **state)
{
    (void)state;
    fixture *f = connect_to(NULL, NULL, true);
    uint8_t *data = calloc(1, LF_USBIP_MAX_TRANSFER + 1);
    assert_non_null(data);
    submit(f, 1, false, 2, NULL, data, LF_USBIP_MAX_TRANSFER + 1);
    expect(f, RET_SUBMIT, 1, -ENOMEM);
    ask(f, 2, 0);
    expect(f, RET_SUBMIT, 2, 0);
    free(data);
    end(f);
}

static void waiting_transfers_are_bounded(void **state)
{
    (void)state;
    fixture *f = connect_to(NULL, NULL, true);
    for (uint32_t i = 0; i < LF_USBIP_MAX_URBS; i++) {
        submit(f, 1 + i, true, 1, NULL, NULL, LF_MODEL_INPUT);
        lf_assert_ok(run(f), NULL);
    }
    assert_true(silent(f));
    submit(f, 5000, true, 1, NULL, NULL, LF_MODEL_INPUT);
    expect(f, RET_SUBMIT, 5000, -ENOMEM);
    unlink_urb(f, 5001, 1);
    expect(f, RET_UNLINK, 5001, -ECONNRESET);
    submit(f, 5002, true, 1, NULL, NULL, LF_MODEL_INPUT);
    assert_true(silent(f));
    end(f);
}

static void waiting_bytes_are_bounded(void **state)
{
    (void)state;
    const lf_model_gud_faults slow = {.bytes_per_s = 1};
    fixture *f = connect_to(NULL, &slow, true);
    uint8_t *data = calloc(1, LF_USBIP_MAX_TRANSFER);
    assert_non_null(data);
    for (uint32_t i = 0; i < LF_USBIP_MAX_WAITING / LF_USBIP_MAX_TRANSFER; i++)
        submit(f, 1 + i, false, 2, NULL, data, LF_USBIP_MAX_TRANSFER);
    assert_true(silent(f));
    submit(f, 100, false, 2, NULL, data, 1);
    expect(f, RET_SUBMIT, 100, -ENOMEM);
    free(data);
    end(f);
}

/* A peer that never reads is not read from for ever, and gets all its answers once it does. */
static void a_peer_that_does_not_read_is_waited_for(void **state)
{
    (void)state;
    fixture *f = connect_to(NULL, NULL, true);
    const uint8_t setup[8] = {0x80, 6, 0, 1, 0, 0, 18, 0};
    uint8_t header[HEADER], d[18];
    uint32_t sent = 0, got = 0;
    make_header(header, SUBMIT, 0, true, 0);
    put32(header + 24, 18);
    memcpy(header + 40, setup, 8);
    for (int stuck = 0; stuck < 3; run(f)) {
        put32(header + 4, sent);
        ssize_t n = send(f->fd, header, sizeof header, 0);
        stuck = n < 0 ? stuck + 1 : 0;
        sent += n == (ssize_t)sizeof header;
        assert_true(n < 0 || n == (ssize_t)sizeof header);
        assert_true(sent < 1000000);
    }
    while (got < sent) {
        reply r = next_reply(f, true, d, sizeof d);
        assert_int_equal(r.seqnum, got);
        got++;
    }
    assert_true(silent(f));
    end(f);
}

static void noise_never_hurts(void **state)
{
    (void)state;
    uint64_t random = lf_test_seed();
    for (int round = 0; round < 300; round++) {
        fixture *f = connect_to(NULL, NULL, round % 4 != 0);
        for (int message = 0; message < 40 && f->last == LF_OK; message++) {
            uint8_t header[HEADER];
            make_header(header, SUBMIT + (uint32_t)message % 2, (uint32_t)message, message & 2,
                        (uint32_t)message % 3);
            put32(header + 24, message % 5 ? 200 : 0);
            for (int i = 0; i < 3; i++) {
                random = random * 6364136223846793005u + 1442695040888963407u;
                header[(random >> 33) % (message % 3 ? 8 : HEADER) + (message % 3 ? 40 : 0)] =
                    (uint8_t)(random >> 50);
            }
            if (send(f->fd, header, sizeof header, MSG_NOSIGNAL) < 0)
                break;
            run(f);
        }
        end(f);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nonsense_ends_the_connection),
        cmocka_unit_test(a_claim_of_4_gib_is_not_believed),
        cmocka_unit_test(refused_data_is_skipped),
        cmocka_unit_test(waiting_transfers_are_bounded),
        cmocka_unit_test(waiting_bytes_are_bounded),
        cmocka_unit_test(a_peer_that_does_not_read_is_waited_for),
        cmocka_unit_test(noise_never_hurts),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
