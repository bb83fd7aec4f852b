#include "daemon/web/secret.h"

#include <errno.h>
#include <stdio.h>
#include <sys/random.h>

#include "base/errno_text.h"

lf_status lf_secret_draw(lf_secret *out, lf_error *err)
{
    unsigned char bytes[LF_SECRET_DIGITS / 2];
    if (getrandom(bytes, sizeof bytes, 0) != (ssize_t)sizeof bytes)
        return lf_error_set(err, LF_E_IO, "getrandom", "cannot draw a token: %s",
                            lf_errno_text(errno));
    for (size_t i = 0; i < sizeof bytes; i++)
        snprintf(out->text + 2 * i, 3, "%02x", bytes[i]);
    return LF_OK;
}

bool lf_secret_equals(const lf_secret *secret, const char *text, size_t n)
{
    unsigned char differs = n != LF_SECRET_DIGITS;
    for (size_t i = 0; i < n; i++)
        differs |= (unsigned char)(text[i] ^ secret->text[i % LF_SECRET_DIGITS]);
    return !differs;
}
