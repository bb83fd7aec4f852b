/* OpenEXR through the C library OpenEXRCore. The Core of OpenEXR 3.1 (Debian 12) has no DWA
 * decoder, decodes B44 wrongly if a side is not a multiple of 4, and does not rebuild
 * luminance-chroma pictures. Pixels of these kinds are read through the C interface of the C++
 * library (ImfCRgbaFile.h). Its half floats lose nothing there, because DWA, B44 and chroma coding
 * use halfs themselves. Headers are always read by the Core, so every check exists once. */
#include <errno.h>
#include <pthread.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include <ImfCRgbaFile.h>

#include "base/alloc.h"
#include "base/image_exr.h"
#include "base/thread.h"

static bool recognises_exr(const uint8_t *head, size_t n)
{
    return n >= 4 && head[0] == 0x76 && head[1] == 0x2f && head[2] == 0x31 && head[3] == 0x01;
}

static void on_error(exr_const_context_t exr, exr_result_t code, const char *message)
{
    void *data = NULL;
    if (exr_get_user_data(exr, &data) != EXR_ERR_SUCCESS || !data)
        return;
    lf_exr_session *s = data;
    /* threads may complain at once */
    static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
    pthread_mutex_lock(&lock);
    if (s->message[0] == 0)
        snprintf(s->message, sizeof s->message, "%s",
                 message ? message : exr_get_default_error_message(code));
    pthread_mutex_unlock(&lock);
}

lf_status lf_exr_fail(const lf_exr_session *s, exr_result_t code)
{
    const char *where = s->source ? s->source->where : lf_outfile_name(s->file);
    if (s->status != LF_OK)
        return s->status;
    lf_status status = code == EXR_ERR_OUT_OF_MEMORY ? LF_E_NOMEM : LF_E_FORMAT;
    return lf_error_set(s->err, status, where, "EXR: %s",
                        s->message[0] ? s->message : exr_get_default_error_message(code));
}

/* -------------------------------------------------------------------------------------- read -- */

static int64_t read_bytes(exr_const_context_t exr, void *data, void *to, uint64_t n,
                          uint64_t offset, exr_stream_error_func_ptr_t report)
{
    (void)exr;
    (void)report;
    lf_exr_session *s = data;
    uint64_t done = 0;
    while (done < n) {
        ssize_t got = pread(s->source->fd, (char *)to + done, n - done, (off_t)(offset + done));
        if (got < 0 && errno == EINTR)
            continue;
        if (got < 0) {
            s->status =
                lf_error_set(s->err, LF_E_IO, s->source->where, "cannot read: %s", strerror(errno));
            return -1;
        }
        if (got == 0)
            break;
        done += (uint64_t)got;
    }
    return (int64_t)done;
}

static int64_t file_size(exr_const_context_t exr, void *data)
{
    (void)exr;
    const lf_exr_session *s = data;
    return (int64_t)s->source->size_bytes;
}

/* Copies the part of a block inside the display window; (x, y) is its corner in the file's
 * coordinates. */
static void place_block(const lf_exr_input *in, const float *block, int x, int y, int width,
                        int height, lf_image32 *out)
{
    for (int row = 0; row < height; row++) {
        int to_y = y + row - in->display.min.y;
        if (to_y < 0 || to_y >= out->height)
            continue;
        int first = x < in->display.min.x ? in->display.min.x - x : 0;
        int64_t room = (int64_t)in->display.max.x + 1 - x;
        int last = room < width ? (int)room : width;
        if (first >= last)
            continue;
        size_t to_x = (size_t)(x + first - in->display.min.x);
        memcpy(out->data + ((size_t)to_y * (size_t)out->width + to_x) * 3,
               block + ((size_t)row * (size_t)width + (size_t)first) * 3,
               (size_t)(last - first) * 3 * sizeof(float));
    }
}

static void spread_grey(float *block, size_t n)
{
    for (size_t i = 0; i < n; i++)
        block[3 * i + 1] = block[3 * i + 2] = block[3 * i];
}

/* Directs the wanted channels to the block; the library converts half and uint to float. */
static void aim_channels(const lf_exr_input *in, exr_decode_pipeline_t *decode, float *block,
                         int width)
{
    const int n = in->grey ? 1 : 3;
    for (int c = 0; c < decode->channel_count; c++) {
        exr_coding_channel_info_t *channel = &decode->channels[c];
        int slot = 0;
        while (slot < n && strcmp(channel->channel_name, in->channel[slot]) != 0)
            slot++;
        channel->decode_to_ptr = NULL;
        if (slot == n)
            continue;
        channel->decode_to_ptr = (uint8_t *)(block + slot);
        channel->user_bytes_per_element = 4;
        channel->user_data_type = EXR_PIXEL_FLOAT;
        channel->user_pixel_stride = 12;
        channel->user_line_stride = width * 12;
    }
}

static exr_result_t decode_chunk(const lf_exr_input *in, const exr_chunk_info_t *chunk,
                                 exr_decode_pipeline_t *decode, bool first, float *block)
{
    exr_result_t rv = first ? exr_decoding_initialize(in->exr, in->part, chunk, decode)
                            : exr_decoding_update(in->exr, in->part, chunk, decode);
    if (rv != EXR_ERR_SUCCESS)
        return rv;
    aim_channels(in, decode, block, chunk->width);
    if (first)
        rv = exr_decoding_choose_default_routines(in->exr, in->part, decode);
    return rv == EXR_ERR_SUCCESS ? exr_decoding_run(in->exr, in->part, decode) : rv;
}

static exr_result_t read_scan_lines(const lf_exr_input *in, exr_decode_pipeline_t *decode,
                                    float *block, int lines, lf_image32 *out)
{
    for (int y = 0; y < in->data_height; y += lines) {
        exr_chunk_info_t chunk = {0};
        exr_result_t rv =
            exr_read_scanline_chunk_info(in->exr, in->part, in->data.min.y + y, &chunk);
        if (rv == EXR_ERR_SUCCESS &&
            (chunk.width != in->data_width || chunk.height > lines || chunk.height < 1))
            rv = EXR_ERR_BAD_CHUNK_LEADER;
        if (rv == EXR_ERR_SUCCESS)
            rv = decode_chunk(in, &chunk, decode, y == 0, block);
        if (rv != EXR_ERR_SUCCESS)
            return rv;
        if (in->grey)
            spread_grey(block, (size_t)chunk.width * (size_t)chunk.height);
        place_block(in, block, in->data.min.x, in->data.min.y + y, chunk.width, chunk.height, out);
    }
    return EXR_ERR_SUCCESS;
}

static exr_result_t read_tiles(const lf_exr_input *in, exr_decode_pipeline_t *decode, float *block,
                               int tile_w, int tile_h, lf_image32 *out)
{
    for (int y = 0; y < in->data_height; y += tile_h) {
        for (int x = 0; x < in->data_width; x += tile_w) {
            exr_chunk_info_t chunk = {0};
            exr_result_t rv =
                exr_read_tile_chunk_info(in->exr, in->part, x / tile_w, y / tile_h, 0, 0, &chunk);
            if (rv == EXR_ERR_SUCCESS && (chunk.width > tile_w || chunk.height > tile_h ||
                                          chunk.width < 1 || chunk.height < 1))
                rv = EXR_ERR_BAD_CHUNK_LEADER;
            if (rv == EXR_ERR_SUCCESS)
                rv = decode_chunk(in, &chunk, decode, x == 0 && y == 0, block);
            if (rv != EXR_ERR_SUCCESS)
                return rv;
            if (in->grey)
                spread_grey(block, (size_t)chunk.width * (size_t)chunk.height);
            place_block(in, block, in->data.min.x + x, in->data.min.y + y, chunk.width,
                        chunk.height, out);
        }
    }
    return EXR_ERR_SUCCESS;
}

/* The shape of the file's blocks, at most the data window. */
static exr_result_t block_shape(const lf_exr_input *in, int *out_width, int *out_height)
{
    int32_t width = in->data_width, height = 1;
    exr_result_t rv = in->tiled ? exr_get_tile_sizes(in->exr, in->part, 0, 0, &width, &height)
                                : exr_get_scanlines_per_chunk(in->exr, in->part, &height);
    if (rv == EXR_ERR_SUCCESS && (width < 1 || height < 1))
        rv = EXR_ERR_INVALID_ATTR;
    *out_width = width < in->data_width ? width : in->data_width;
    *out_height = height < in->data_height ? height : in->data_height;
    return rv;
}

static lf_status read_by_core(const lf_exr_input *in, lf_image32 *out)
{
    int width, height;
    exr_result_t rv = block_shape(in, &width, &height);
    if (rv != EXR_ERR_SUCCESS)
        return lf_exr_fail(in->session, rv);
    float *block = lf_calloc((size_t)width * (size_t)height * 3, sizeof *block);
    if (!block)
        return lf_error_set(in->session->err, LF_E_NOMEM, in->session->source->where,
                            "not enough memory for the image");
    exr_decode_pipeline_t decode = EXR_DECODE_PIPELINE_INITIALIZER;
    rv = in->tiled ? read_tiles(in, &decode, block, width, height, out)
                   : read_scan_lines(in, &decode, block, height, out);
    exr_decoding_destroy(in->exr, &decode);
    lf_free(block);
    return rv == EXR_ERR_SUCCESS ? LF_OK : lf_exr_fail(in->session, rv);
}

#define BAND_LINES 256 /* the block height of DWAB, so that each is unpacked once */

static lf_status read_bands(const lf_exr_input *in, ImfInputFile *file, ImfRgba *half, float *block,
                            lf_image32 *out)
{
    size_t width = (size_t)in->data_width;
    for (int y = 0; y < in->data_height; y += BAND_LINES) {
        int n = in->data_height - y < BAND_LINES ? in->data_height - y : BAND_LINES;
        int from = in->data.min.y + y;
        /* The library expects the address of pixel (0, 0), which need not be inside the buffer. */
        intptr_t origin =
            (intptr_t)half -
            ((intptr_t)in->data.min.x + (intptr_t)from * (intptr_t)width) * (intptr_t)sizeof *half;
        if (!ImfInputSetFrameBuffer(file, (ImfRgba *)origin, 1, width) ||
            !ImfInputReadPixels(file, from, from + n - 1))
            return LF_E_FORMAT;
        for (size_t i = 0; i < width * (size_t)n; i++) {
            block[3 * i] = ImfHalfToFloat(half[i].r);
            block[3 * i + 1] = ImfHalfToFloat(half[i].g);
            block[3 * i + 2] = ImfHalfToFloat(half[i].b);
        }
        place_block(in, block, in->data.min.x, from, in->data_width, n, out);
    }
    return LF_OK;
}

/* That library keeps its message in one global buffer. */
static pthread_mutex_t rgba_library = PTHREAD_MUTEX_INITIALIZER;

static lf_status read_by_rgba_library(const lf_exr_input *in, lf_image32 *out)
{
    const lf_image_source *source = in->session->source;
    size_t n = (size_t)in->data_width * BAND_LINES;
    ImfRgba *half = lf_calloc(n, sizeof *half);
    float *block = lf_calloc(n * 3, sizeof *block);
    if (!half || !block) {
        lf_free(half);
        lf_free(block);
        return lf_error_set(in->session->err, LF_E_NOMEM, source->where,
                            "not enough memory for the image");
    }
    char name[32];
    snprintf(name, sizeof name, "/proc/self/fd/%d", source->fd);
    pthread_mutex_lock(&rgba_library);
    ImfInputFile *file = ImfOpenInputFile(name);
    lf_status status = file ? read_bands(in, file, half, block, out) : LF_E_FORMAT;
    if (status != LF_OK)
        (void)lf_error_set(in->session->err, status, source->where, "EXR: %.300s",
                           ImfErrorMessage());
    if (file)
        ImfCloseInputFile(file);
    pthread_mutex_unlock(&rgba_library);
    lf_free(half);
    lf_free(block);
    return status;
}

static bool is_beyond_core(const lf_exr_input *in)
{
    switch (in->compression) {
    case EXR_COMPRESSION_DWAA:
    case EXR_COMPRESSION_DWAB:
        return true;
    case EXR_COMPRESSION_B44:
    case EXR_COMPRESSION_B44A:
        return in->half || in->chroma; /* other types are stored unchanged */
    default:
        return in->chroma;
    }
}

static lf_status read_part(lf_exr_input *in, lf_image32 *out)
{
    lf_status status = lf_exr_read_header(in);
    if (status != LF_OK)
        return status;
    if (is_beyond_core(in) && !in->named)
        return lf_error_set(in->session->err, LF_E_FORMAT, in->session->source->where,
                            "layers and later parts cannot be read with DWA, B44 or "
                            "luminance-chroma coding; save the EXR with ZIP compression");
    int width = in->display.max.x - in->display.min.x + 1,
        height = in->display.max.y - in->display.min.y + 1;
    status = lf_image32_init(out, width, height, 3);
    if (status != LF_OK)
        return lf_error_set(in->session->err, status, in->session->source->where,
                            "not enough memory for the image");
    status = is_beyond_core(in) ? read_by_rgba_library(in, out) : read_by_core(in, out);
    if (status == LF_OK)
        lf_image_settle(in->session->source, &in->colours, out);
    return status;
}

static lf_status read_exr(const lf_image_source *source, lf_image32 *out, lf_error *err)
{
    lf_exr_session session = {.source = source, .err = err};
    exr_context_initializer_t setup = EXR_DEFAULT_CONTEXT_INITIALIZER;
    setup.error_handler_fn = on_error;
    setup.user_data = &session;
    setup.read_fn = read_bytes;
    setup.size_fn = file_size;
    setup.max_image_width = setup.max_image_height = setup.max_tile_width = setup.max_tile_height =
        65536;
    setup.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
    lf_exr_input in = {.session = &session};
    exr_result_t rv = exr_start_read(&in.exr, source->where, &setup);
    if (rv != EXR_ERR_SUCCESS)
        return lf_exr_fail(&session, rv);
    lf_image32 image = {0};
    lf_status status = read_part(&in, &image);
    exr_finish(&in.exr);
    if (status == LF_OK)
        *out = image;
    else
        lf_image32_finish(&image);
    return status;
}

static const char *const endings[] = {".exr", NULL};

const lf_image_format lf_format_exr = {.name = "EXR",
                                       .endings = endings,
                                       .kind = LF_IMAGE_FLOAT,
                                       .recognises = recognises_exr,
                                       .read32 = read_exr};

/* ------------------------------------------------------------------------------------- write -- */

static int64_t write_bytes(exr_const_context_t exr, void *data, const void *from, uint64_t n,
                           uint64_t offset, exr_stream_error_func_ptr_t report)
{
    (void)exr;
    (void)report;
    lf_exr_session *s = data;
    uint64_t done = 0;
    while (done < n && s->status == LF_OK) {
        ssize_t put =
            pwrite(s->file->fd, (const char *)from + done, n - done, (off_t)(offset + done));
        if (put > 0)
            done += (uint64_t)put;
        else if (put == 0 || errno != EINTR)
            s->status = lf_error_set(s->err, LF_E_IO, lf_outfile_name(s->file), "cannot write: %s",
                                     put == 0 ? "nothing was taken" : strerror(errno));
    }
    return s->status == LF_OK ? (int64_t)n : -1;
}

/* Chunks that are compressed at once. */
#define HANDS_A_THREAD 2
#define MOST_HANDS 64

struct exr_job;

/* A chunk of lines in the making. */
typedef struct exr_hand {
    const struct exr_job *job;
    exr_encode_pipeline_t encode;
    float *block; /* [lines of a chunk][width][n_channels] */
    exr_result_t result;
    bool ready; /* encode is initialised */
} exr_hand;

typedef struct exr_job {
    int width, height;
    lf_rows32_fn rows;
    void *context;
    const char *const *channels; /* [n_channels] */
    int n_channels, n_hands;
    exr_hand *hands;
    exr_context_t exr;
    double pixel_aspect;
    exr_pixel_type_t type; /* in the file */
    const lf_attribute *attributes;
    int n_attributes;
    /* the library's choice */
    exr_result_t (*compress)(exr_encode_pipeline_t *encode);
    exr_result_t (*write)(exr_encode_pipeline_t *encode);
} exr_job;

/* The next channel name after `before` (NULL: the first), in file order. */
static const char *channel_behind(const exr_job *job, const char *before)
{
    const char *next = NULL;
    for (int c = 0; c < job->n_channels; c++)
        if ((!before || strcmp(job->channels[c], before) > 0) &&
            (!next || strcmp(job->channels[c], next) < 0))
            next = job->channels[c];
    return next;
}

static exr_result_t define_part(exr_context_t exr, const exr_job *job)
{
    int part = 0;
    exr_result_t rv = exr_add_part(exr, NULL, EXR_STORAGE_SCANLINE, &part);
    if (rv == EXR_ERR_SUCCESS)
        rv = exr_initialize_required_attr_simple(exr, part, job->width, job->height,
                                                 EXR_COMPRESSION_ZIP);
    if (rv == EXR_ERR_SUCCESS && job->pixel_aspect > 0)
        rv = exr_set_pixel_aspect_ratio(exr, part, (float)job->pixel_aspect);
    for (const char *name = channel_behind(job, NULL); name && rv == EXR_ERR_SUCCESS;
         name = channel_behind(job, name))
        rv = exr_add_channel(exr, part, name, job->type, EXR_PERCEPTUALLY_LINEAR, 1, 1);
    for (int i = 0; i < job->n_attributes && rv == EXR_ERR_SUCCESS; i++) {
        if (strlen(job->attributes[i].name) > 31)
            rv = exr_set_longname_support(exr, 1);
        if (rv == EXR_ERR_SUCCESS)
            rv = exr_attr_set_string(exr, part, job->attributes[i].name, job->attributes[i].value);
    }
    if (rv == EXR_ERR_SUCCESS)
        rv = exr_set_zip_compression_level(exr, part, 2);
    return rv == EXR_ERR_SUCCESS ? exr_write_header(exr) : rv;
}

static void aim_encoder(exr_hand *hand)
{
    const exr_job *job = hand->job;
    exr_encode_pipeline_t *encode = &hand->encode;
    for (int c = 0; c < encode->channel_count; c++) {
        exr_coding_channel_info_t *channel = &encode->channels[c];
        int slot = 0;
        while (strcmp(channel->channel_name, job->channels[slot]) != 0)
            slot++;
        channel->encode_from_ptr = (const uint8_t *)(hand->block + slot);
        channel->user_bytes_per_element = 4;
        channel->user_data_type = EXR_PIXEL_FLOAT;
        channel->user_pixel_stride = 4 * job->n_channels;
        channel->user_line_stride = job->width * 4 * job->n_channels;
    }
}

/* The Core's compression. OpenEXR 3.1 keeps compressed data of exactly the plain size, which
 * readers then take for uncompressed; here it is stored plain. */
static exr_result_t compress_or_copy(exr_encode_pipeline_t *encode)
{
    const exr_job *job = encode->encoding_user_data;
    exr_result_t rv = job->compress(encode);
    if (rv == EXR_ERR_SUCCESS && encode->compressed_bytes == encode->packed_bytes)
        memcpy(encode->compressed_buffer, encode->packed_buffer, encode->packed_bytes);
    return rv;
}

/* Chunks are written in order, by one thread. */
static exr_result_t write_later(exr_encode_pipeline_t *encode)
{
    (void)encode;
    return EXR_ERR_SUCCESS;
}

/* Reads the lines from y on. */
static exr_result_t fill_hand(exr_job *job, exr_hand *hand, int y)
{
    exr_chunk_info_t chunk = {0};
    exr_result_t rv = exr_write_scanline_chunk_info(job->exr, 0, y, &chunk);
    for (int row = 0; rv == EXR_ERR_SUCCESS && row < chunk.height; row++)
        job->rows(job->context, y + row,
                  hand->block + (size_t)row * (size_t)job->width * (size_t)job->n_channels);
    if (rv == EXR_ERR_SUCCESS)
        rv = hand->ready ? exr_encoding_update(job->exr, 0, &chunk, &hand->encode)
                         : exr_encoding_initialize(job->exr, 0, &chunk, &hand->encode);
    if (rv != EXR_ERR_SUCCESS)
        return rv;
    aim_encoder(hand);
    if (!hand->ready) {
        rv = exr_encoding_choose_default_routines(job->exr, 0, &hand->encode);
        job->compress = hand->encode.compress_fn;
        job->write = hand->encode.write_fn;
        hand->encode.compress_fn = compress_or_copy;
        hand->encode.yield_until_ready_fn = NULL; /* would accept only the next to be written */
        hand->encode.write_fn = write_later;
        hand->encode.encoding_user_data = job;
        hand->ready = true;
    }
    return rv;
}

static void encode_item(void *context, int item, int worker)
{
    const exr_job *job = context;
    exr_hand *hand = &job->hands[item];
    (void)worker;
    hand->result = exr_encoding_run(job->exr, 0, &hand->encode);
}

static exr_result_t write_chunks(exr_job *job, lf_pool *pool, int lines)
{
    exr_result_t rv = EXR_ERR_SUCCESS;
    for (int y = 0; y < job->height && rv == EXR_ERR_SUCCESS;) {
        int n = 0;
        for (; n < job->n_hands && y < job->height && rv == EXR_ERR_SUCCESS; n++, y += lines)
            rv = fill_hand(job, &job->hands[n], y);
        if (rv == EXR_ERR_SUCCESS &&
            (!pool || lf_pool_run(pool, n, encode_item, job, NULL) != LF_OK))
            for (int i = 0; i < n; i++)
                encode_item(job, i, 0);
        for (int i = 0; i < n && rv == EXR_ERR_SUCCESS; i++) {
            rv = job->hands[i].result;
            if (rv == EXR_ERR_SUCCESS)
                rv = job->write(&job->hands[i].encode);
        }
    }
    return rv;
}

static exr_result_t make_hands(exr_job *job, const lf_pool *pool, int lines)
{
    const int n = pool && lf_pool_threads(pool) > 1 ? HANDS_A_THREAD * lf_pool_threads(pool) : 1;
    const int chunks = (job->height + lines - 1) / lines;
    job->n_hands = n < MOST_HANDS ? n : MOST_HANDS;
    job->n_hands = job->n_hands < chunks ? job->n_hands : chunks;
    job->hands = lf_calloc((size_t)job->n_hands, sizeof *job->hands);
    for (int i = 0; job->hands && i < job->n_hands; i++) {
        exr_hand *hand = &job->hands[i];
        hand->job = job;
        hand->encode = (exr_encode_pipeline_t)EXR_ENCODE_PIPELINE_INITIALIZER;
        hand->block = lf_calloc((size_t)lines * (size_t)job->width,
                                (size_t)job->n_channels * sizeof *hand->block);
        if (!hand->block)
            return EXR_ERR_OUT_OF_MEMORY;
    }
    return job->hands ? EXR_ERR_SUCCESS : EXR_ERR_OUT_OF_MEMORY;
}

static void free_hands(exr_job *job)
{
    for (int i = 0; job->hands && i < job->n_hands; i++) {
        if (job->hands[i].ready)
            exr_encoding_destroy(job->exr, &job->hands[i].encode);
        lf_free(job->hands[i].block);
    }
    lf_free(job->hands);
}

static exr_result_t write_picture(exr_job *job, lf_pool *pool)
{
    int32_t lines = 0;
    exr_result_t rv = define_part(job->exr, job);
    if (rv == EXR_ERR_SUCCESS)
        rv = exr_get_scanlines_per_chunk(job->exr, 0, &lines);
    if (rv == EXR_ERR_SUCCESS)
        rv = make_hands(job, pool, lines);
    if (rv == EXR_ERR_SUCCESS)
        rv = write_chunks(job, pool, lines);
    free_hands(job);
    return rv;
}

lf_status lf_exr_write_channels(lf_outfile *file, int width, int height,
                                const lf_channels32 *channels, const lf_attribute *attributes,
                                int n, lf_error *err)
{
    if (width < 1 || width > 65536 || height < 1 || height > 65536 || channels->n < 1 ||
        channels->n > LF_EXR_MAX_CHANNELS)
        return lf_error_set(err, LF_E_ARG, lf_outfile_name(file),
                            "cannot write an EXR of %dx%d pixels; expected 1 to 65536 per side",
                            width, height);
    lf_exr_session session = {.file = file, .err = err};
    exr_job job = {.width = width,
                   .height = height,
                   .rows = channels->rows,
                   .context = channels->context,
                   .channels = channels->names,
                   .n_channels = channels->n,
                   .pixel_aspect = channels->pixel_aspect,
                   .type = channels->is_half ? EXR_PIXEL_HALF : EXR_PIXEL_FLOAT,
                   .attributes = attributes,
                   .n_attributes = n};
    exr_context_initializer_t setup = EXR_DEFAULT_CONTEXT_INITIALIZER;
    setup.error_handler_fn = on_error;
    setup.user_data = &session;
    setup.write_fn = write_bytes;
    exr_result_t rv =
        exr_start_write(&job.exr, lf_outfile_name(file), EXR_WRITE_FILE_DIRECTLY, &setup);
    if (rv == EXR_ERR_SUCCESS)
        rv = write_picture(&job, file->pool);
    /* finishing writes the chunk table, and may also fail */
    exr_result_t end = job.exr ? exr_finish(&job.exr) : EXR_ERR_SUCCESS;
    if (rv == EXR_ERR_SUCCESS)
        rv = end;
    return rv == EXR_ERR_SUCCESS && session.status == LF_OK ? LF_OK : lf_exr_fail(&session, rv);
}

lf_status lf_exr_write_rows(lf_outfile *file, int width, int height, lf_rows32_fn rows,
                            void *context, const lf_attribute *attributes, int n, lf_error *err)
{
    static const char *const rgb[] = {"R", "G", "B"};
    const lf_channels32 channels = {.names = rgb, .n = 3, .rows = rows, .context = context};
    return lf_exr_write_channels(file, width, height, &channels, attributes, n, err);
}

static void copy_row(void *context, int y, float *row)
{
    const lf_image32 *image = context;
    size_t n = (size_t)image->width * 3;
    memcpy(row, image->data + (size_t)y * n, n * sizeof *row);
}

lf_status lf_exr_write(lf_outfile *file, const lf_image32 *image, const lf_attribute *attributes,
                       int n, lf_error *err)
{
    if (image->channels != 3)
        return lf_error_set(err, LF_E_ARG, lf_outfile_name(file), "%d channels; expected 3",
                            image->channels);
    lf_image32 borrowed = *image;
    return lf_exr_write_rows(file, image->width, image->height, copy_row, &borrowed, attributes, n,
                             err);
}
