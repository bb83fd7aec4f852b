/* Cameras that the file of a mesh holds (those of glTF), in world coordinates; private to render/.
 */
#ifndef LF_RENDER_FILE_CAMERA_H
#define LF_RENDER_FILE_CAMERA_H

#include <stdbool.h>

#define LF_MAX_FILE_CAMERAS 256 /* of a file */
#define LF_FILE_CAMERA_NAME 128 /* bytes of a name that counts, with its end */

/* What the rig can have, radians: 0.1 and 160 degrees. */
#define LF_FILE_CAMERA_LEAST_FOV 1.7453292519943296e-3
#define LF_FILE_CAMERA_MOST_FOV 2.7925268031909272

/* A camera in a place: as often as nodes have it. */
typedef struct lf_file_camera {
    int number;                          /* of the file's cameras */
    char name[LF_FILE_CAMERA_NAME];      /* its own, or "" */
    char node_name[LF_FILE_CAMERA_NAME]; /* of the node that it stands at, or "" */
    bool parallel;                       /* it looks along parallel rays; has no fov_y */
    double position[3], look[3], up[3];  /* the last two unit, across each other */
    double fov_y;                        /* radians */
} lf_file_camera;

/* Of one mesh, when the shutter opens and when it closes. */
typedef struct lf_file_cameras {
    int n;
    lf_file_camera *open, *close; /* [n]; close NULL: they stand still */
} lf_file_cameras;

#endif
