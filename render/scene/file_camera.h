/* Cameras in the file of a mesh (glTF), in world coordinates; private to render/. */
#ifndef LF_RENDER_FILE_CAMERA_H
#define LF_RENDER_FILE_CAMERA_H

#include <stdbool.h>

#define LF_MAX_FILE_CAMERAS 256 /* per file */
#define LF_FILE_CAMERA_NAME 128 /* bytes of a name, including its end; longer names are cut */

/* Limits of the rig's field of view, in radians: 0.1 and 160 degrees. */
#define LF_FILE_CAMERA_LEAST_FOV 1.7453292519943296e-3
#define LF_FILE_CAMERA_MOST_FOV 2.7925268031909272

/* An instance of a camera: one for each node that has it. */
typedef struct lf_file_camera {
    int number;                          /* among the file's cameras */
    char name[LF_FILE_CAMERA_NAME];      /* the camera's name, or "" */
    char node_name[LF_FILE_CAMERA_NAME]; /* of its node, or "" */
    bool parallel;                       /* orthographic; has no fov_y */
    double position[3], look[3], up[3];  /* look and up: unit, perpendicular */
    double fov_y;                        /* radians */
} lf_file_camera;

/* The cameras of one mesh, when the shutter opens and when it closes. */
typedef struct lf_file_cameras {
    int n;
    lf_file_camera *open, *close; /* [n]; close NULL: static */
} lf_file_cameras;

#endif
