/* The room of tests/scenes/shaded-lamp.json for radiosity.h: five walls that are open towards the
 * cameras, a lamp in the ceiling, and a plate below the lamp that hides it from the floor and from
 * the lower part of the walls. */
#ifndef LF_TESTS_SHADED_ROOM_H
#define LF_TESTS_SHADED_ROOM_H

#include "tests/stat/radiosity.h"

/* the albedo of the wall at the back, z = -1, and the depth of the scene's paths */
#define LF_SHADED_ROOM_BACK 0.7
enum { LF_SHADED_ROOM_DEPTH = 5 };

static inline void lf_shaded_room_add(lf_room *room, const double centre[3], const double u[3],
                                      const double v[3], double albedo, int across, int down)
{
    lf_room_quad *to = &room->quads[room->n_quads++];
    for (int k = 0; k < 3; k++) {
        to->centre[k] = centre[k];
        to->u[k] = u[k];
        to->v[k] = v[k];
    }
    to->albedo = albedo;
    to->across = across;
    to->down = down;
}

static inline lf_room lf_shaded_room(void)
{
    static const double x[3] = {1, 0, 0}, y[3] = {0, 1, 0}, z[3] = {0, 0, 1},
                        quarter_x[3] = {0.25, 0, 0}, quarter_z[3] = {0, 0, 0.25},
                        side_x[3] = {0.375, 0, 0}, side_z[3] = {0, 0, 0.375},
                        plate_x[3] = {0.5, 0, 0}, plate_z[3] = {0, 0, 0.5};
    lf_room room = {.n_quads = 0};
    lf_shaded_room_add(&room, (double[]){0, -1, 0}, z, x, 0.6, 4, 4);                 /* floor */
    lf_shaded_room_add(&room, (double[]){0, 0, -1}, x, y, LF_SHADED_ROOM_BACK, 4, 4); /* back */
    lf_shaded_room_add(&room, (double[]){-1, 0, 0}, y, z, 0.8, 4, 4);                 /* left */
    lf_shaded_room_add(&room, (double[]){1, 0, 0}, z, y, 0.5, 4, 4);                  /* right */
    lf_shaded_room_add(&room, (double[]){-0.625, 1, 0}, side_x, z, 0.75, 3, 8);       /* ceiling */
    lf_shaded_room_add(&room, (double[]){0.625, 1, 0}, side_x, z, 0.75, 3, 8);
    lf_shaded_room_add(&room, (double[]){0, 1, -0.625}, quarter_x, side_z, 0.75, 2, 3);
    lf_shaded_room_add(&room, (double[]){0, 1, 0.625}, quarter_x, side_z, 0.75, 2, 3);
    lf_shaded_room_add(&room, (double[]){0, 1, 0}, quarter_x, quarter_z, 0, 1, 1); /* lamp */
    room.quads[room.n_quads - 1].emission = 10;
    lf_shaded_room_add(&room, (double[]){0, 0.6, 0}, plate_z, plate_x, 0.8, 4, 4); /* plate */
    room.shade = room.n_quads - 1;
    lf_shaded_room_add(&room, (double[]){0, 0.6, 0}, plate_x, plate_z, 0.8, 4, 4);
    return room;
}

#endif
