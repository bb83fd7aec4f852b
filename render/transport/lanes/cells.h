/* Values of a regular grid of cells, stored for rays of any direction: tiles of 4x4x4 (two cache
 * lines) in the order [z][y][x], and [z][y][x] in each tile. A value is the upper half of a float,
 * rounded up, within 1/128. The time of a walk is dominated by memory latency. Private to render/.
 */
#ifndef LF_RENDER_CELLS_H
#define LF_RENDER_CELLS_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

enum { LF_CELL_TILE_BITS = 2, LF_CELL_TILE = 1 << LF_CELL_TILE_BITS };

/* Tiles along an axis of n cells. */
static inline int lf_cell_tiles(int n)
{
    return (n + LF_CELL_TILE - 1) / LF_CELL_TILE;
}

/* Number of values stored for a grid of n cells per axis. */
static inline size_t lf_cells_count(const int n[3])
{
    return (size_t)lf_cell_tiles(n[0]) * (size_t)lf_cell_tiles(n[1]) * (size_t)lf_cell_tiles(n[2]) *
           (LF_CELL_TILE * LF_CELL_TILE * LF_CELL_TILE);
}

/* Strides of a cell's index: the sum over the axes of place + tile * more. */
static inline void lf_cells_strides(const int n[3], int place[3], int more[3])
{
    const int whole = LF_CELL_TILE * LF_CELL_TILE * LF_CELL_TILE,
              tile[3] = {whole, whole * lf_cell_tiles(n[0]),
                         whole * lf_cell_tiles(n[0]) * lf_cell_tiles(n[1])};
    for (int i = 0, within = 1; i < 3; i++, within *= LF_CELL_TILE) {
        place[i] = within;
        more[i] = tile[i] - within * LF_CELL_TILE;
    }
}

/* Index of a cell's value. */
static inline size_t lf_cells_at(const int n[3], const int cell[3])
{
    int place[3], more[3], at = 0;
    lf_cells_strides(n, place, more);
    for (int i = 0; i < 3; i++)
        at += cell[i] * place[i] + cell[i] / LF_CELL_TILE * more[i];
    return (size_t)at;
}

static inline float lf_cell_value(uint16_t stored)
{
    const uint32_t bits = (uint32_t)stored << 16;
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* Rounds up, so that a value above 0 stays above 0. value: finite and >= 0. */
static inline uint16_t lf_cell_stored(float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return (uint16_t)((bits + 0xffff) >> 16);
}

#endif
