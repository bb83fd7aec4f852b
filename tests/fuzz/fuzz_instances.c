/* Places of instances as quiltimport reads them; the first byte chooses NPY or CSV: refused in
 * words, or maps that can be turned round, no more than the file has numbers. */
#include "tests/fuzz/fuzz.h"

#include "base/sandbox/reader.h"
#include "render/import/reader/instances_read.h"
#include "render/import/scene/instances_import.h"

lf_status lf_ask_for_file(const char *name, int *out_fd)
{
    (void)name;
    *out_fd = -1;
    return LF_E_IO;
}

lf_status lf_try_for_file(const char *name, int *out_fd)
{
    return lf_ask_for_file(name, out_fd);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    lf_instance_list places = {0};
    lf_error err = {0};
    if (size == 0)
        return 0;
    int fd = lf_fuzz_file(data + 1, size - 1);
    if (lf_instances_read(data[0] % 2 ? "a.npy" : "a.csv", fd, &places, &err) != LF_OK)
        lf_fuzz_require(err.what[0]);
    else
        lf_fuzz_require(places.n > 0 && 3 * places.n <= size);
    for (size_t i = 0; i < places.n && err.status == LF_OK; i++) {
        lf_affine inverse;
        lf_fuzz_require(lf_affine_invert(&places.map[i], &inverse));
        for (int j = 0; j < 12; j++)
            lf_fuzz_require(fabs(places.map[i].m[j / 4][j % 4]) <= LF_MAX_COORDINATE);
    }
    lf_instance_list_finish(&places);
    close(fd);
    return 0;
}
