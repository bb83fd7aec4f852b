/* Scenes of the statistical tests: small, lit so that noise is low, each with one thing that could
 * go wrong. ' stands for ". */
#ifndef LF_TESTS_SCENES_H
#define LF_TESTS_SCENES_H

/* clang-format off */

#define LF_TEST_CAMERA(views, more)                                                                \
    "'quiltd': 1, 'camera': { 'position': [0, 0.6, 5], 'fov_y': 24, 'aspect': 1.3333333333, "      \
    "'cone': 40, 'views': " views more " }, "
#define LF_TEST_GROUND                                                                             \
    "'ground': { 'shape': 'quad', 'material': 'clay', 'transform': { 'scale': 4, 'translate': "    \
    "[0, -1, 0] } }"
#define LF_TEST_LIGHTS                                                                             \
    "'lights': { 'sky': { 'type': 'environment', 'radiance': [0.4, 0.5, 0.7] }, "                  \
    "'sun': { 'type': 'distant', 'direction': [0.5, -0.7, -0.5], 'irradiance': [3, 2.7, 2.2], "    \
    "'angle': 8 } }"

/* The same with a sun that is a direction: less noise where it is not seen itself. */
#define LF_TEST_SHARP_LIGHTS                                                                       \
    "'lights': { 'sky': { 'type': 'environment', 'radiance': [0.4, 0.5, 0.7] }, "                  \
    "'sun': { 'type': 'distant', 'direction': [0.5, -0.7, -0.5], 'irradiance': [2, 1.7, 1.5] } }"

/* Forward-scattering fog before and beside a rough coated ball on the ground: media, surfaces,
 * occlusion between views, lobes that depend on the view. Not symmetric from left to right. */
#define LF_TEST_MIXED(views, more)                                                                 \
    "{ " LF_TEST_CAMERA(views, more)                                                               \
    "'volumes': { 'fog': { 'shape': 'sphere', 'density': 2.5, 'albedo': [0.95, 0.9, 0.8], 'g': "   \
    "0.5, "                                                                                        \
    "'transform': { 'scale': [0.7, 0.6, 0.5], 'rotate': [0, 20, 0], 'translate': [0.4, 0, 0.8] "   \
    "} } }, "                                                                                      \
    "'meshes': { " LF_TEST_GROUND ", 'ball': { 'shape': 'sphere', 'material': 'glaze', "           \
    "'transform': { 'scale': 0.6, "                                                                \
    "'translate': [-0.7, -0.3, 0.6] } } }, "                                                       \
    "'materials': { 'clay': { 'albedo': [0.5, 0.45, 0.4] }, "                                      \
    "'glaze': { 'type': 'plastic', 'albedo': [0.6, 0.3, 0.2], 'roughness': 0.5 } }, "              \
    LF_TEST_LIGHTS " }"

/* Two overlapping fogs of different colour and phase, one of them black, over nothing. */
#define LF_TEST_FOGS(views, more)                                                                  \
    "{ " LF_TEST_CAMERA(views, more)                                                               \
    "'volumes': { 'near': { 'shape': 'box', 'density': 1.2, 'albedo': 0, 'g': 0.4, "               \
    "'transform': { 'scale': [0.6, 0.8, 0.4], 'rotate': [0, 35, 0], 'translate': [-0.5, 0, 0.5] "  \
    "} }, "                                                                                        \
    "'far': { 'shape': 'sphere', 'density': 1.2, 'albedo': [0.9, 0.8, 0.7], 'g': 0.3, "            \
    "'transform': { 'scale': 1.1 } } }, "                                                          \
    LF_TEST_SHARP_LIGHTS " }"

/* Forward-scattering fog that glows, in part within black smoke that does not, beside a ball that
 * glows in vacuum, over a ground that they light; no other light but a faint sky. */
#define LF_TEST_FIRES(views, more)                                                                \
    "{ " LF_TEST_CAMERA(views, more)                                                               \
    "'volumes': { 'fog': { 'shape': 'sphere', 'density': 1.5, 'albedo': [0.9, 0.8, 0.7], 'g': "    \
    "0.4, 'emission': [1, 0.8, 0.5], 'transform': { 'scale': [0.8, 0.6, 0.6], 'rotate': [0, 20, "  \
    "0], 'translate': [0.4, -0.1, 0.5] } }, "                                                      \
    "'smoke': { 'shape': 'box', 'density': 0.8, 'albedo': 0, 'transform': { 'scale': [0.5, 0.6, "  \
    "0.4], 'rotate': [0, 35, 0], 'translate': [0.7, 0, 0.7] } }, "                                 \
    "'flame': { 'shape': 'sphere', 'density': 0, 'emission': [2, 1.6, 1.2], 'transform': { "       \
    "'scale': [0.5, 0.7, 0.5], 'translate': [-0.8, -0.2, 0.2] } } }, "                             \
    "'meshes': { " LF_TEST_GROUND " }, 'materials': { 'clay': { 'albedo': [0.5, 0.45, 0.4] } }, "  \
    "'lights': { 'sky': { 'type': 'environment', 'radiance': [0.2, 0.25, 0.3] } } }"

/* Surfaces alone, lit by a lamp of triangles, a mirror among them. */
#define LF_TEST_LAMP(views, more)                                                                  \
    "{ " LF_TEST_CAMERA(views, more)                                                               \
    "'meshes': { " LF_TEST_GROUND ", 'ball': { 'shape': 'sphere', 'material': 'metal', "           \
    "'transform': { 'scale': 0.6, "                                                                \
    "'translate': [0.6, -0.3, 0.3] } }, "                                                          \
    "'mirror': { 'shape': 'sphere', 'material': 'mirror', 'transform': { 'scale': 0.4, "           \
    "'translate': [-0.7, -0.5, 0.5] } }, "                                                         \
    "'lamp': { 'shape': 'quad', 'material': 'lamp', 'transform': { 'scale': 1.5, 'rotate': [0, "   \
    "0, 180], 'translate': [0, 3, 0] } } }, "                                                      \
    "'materials': { 'clay': { 'albedo': [0.5, 0.45, 0.4] }, 'mirror': { 'type': 'conductor', "     \
    "'albedo': 0.9, 'roughness': 0 }, "                                                            \
    "'metal': { 'type': 'conductor', 'albedo': [0.9, 0.7, 0.4], 'roughness': 0.6 }, "              \
    "'lamp': { 'albedo': 0, 'emission': [2, 2, 2] } }, 'lights': { 'sky': { 'type': "              \
    "'environment', 'radiance': 0.3 } } }"

/* Lobes that depend on the view, cut by the horizon: metal whose shading normals lean far away from
 * its coarse triangles, a coat over colour, ground that is looked at flatly. A sharp sun besides,
 * whose light samples no direction finds. */
#define LF_TEST_GLOSSY(views, more)                                                                \
    "{ " LF_TEST_CAMERA(views, more)                                                               \
    "'meshes': { 'ground': { 'shape': 'quad', 'material': 'ground', 'transform': { 'scale': 4, "   \
    "'translate': [0, -0.9, 0] } }, "                                                              \
    "'block': { 'shape': 'cube', 'material': 'metal', 'normals': 'smooth', "                       \
    "'transform': { 'scale': 0.6, 'rotate': [20, 30, 10], 'translate': [-0.5, 0, 0] } }, "         \
    "'coated': { 'shape': 'cube', 'material': 'glaze', 'normals': 'smooth', "                      \
    "'transform': { 'scale': 0.5, 'rotate': [-10, 40, 5], 'translate': [0.9, -0.2, 0.4] } } }, "   \
    "'materials': { 'ground': { 'type': 'conductor', 'albedo': 0.8, 'roughness': 0.3 }, "          \
    "'metal': { 'type': 'conductor', 'albedo': [0.9, 0.7, 0.4], 'roughness': 0.6 }, "              \
    "'glaze': { 'type': 'plastic', 'albedo': [0.6, 0.3, 0.2], 'roughness': 0.4, 'ior': 2 } }, "    \
    LF_TEST_SHARP_LIGHTS " }"

/* A mirror and a black card behind thin fog. */
#define LF_TEST_MIST(views, more)                                                                 \
    "{ " LF_TEST_CAMERA(views, more)                                                               \
    "'volumes': { 'veil': { 'shape': 'box', 'density': 1, 'albedo': 0.8, "                         \
    "'transform': { 'scale': [2, 2, 0.3], 'translate': [0, 0, 1.2] } } }, "                        \
    "'meshes': { 'mirror': { 'shape': 'sphere', 'material': 'mirror', 'transform': { 'scale': "    \
    "0.7, 'translate': [-0.7, 0, 0] } }, "                                                         \
    "'card': { 'shape': 'quad', 'material': 'black', 'transform': { 'scale': 0.6, 'rotate': "      \
    "[90, 0, 0], 'translate': [0.9, 0, 0] } } }, "                                                 \
    "'materials': { 'mirror': { 'type': 'conductor', 'albedo': 0.9, 'roughness': 0 }, 'black': "   \
    "{ 'albedo': 0 } }, "                                                                          \
    LF_TEST_SHARP_LIGHTS " }"

/* clang-format on */

/* Coarse triangles whose shading normals lean far away from the surface: views that look from
 * behind them, too. */
#define LF_TEST_BENT(views, more)                                                                  \
    "{ " LF_TEST_CAMERA(                                                                           \
        views, more) "'meshes': { " LF_TEST_GROUND                                                 \
                     ", 'block': { 'shape': 'cube', 'material': 'clay', 'normals': 'smooth', "     \
                     "'transform': { 'scale': 0.7, 'rotate': [20, 30, 10] } } }, 'materials': { "  \
                     "'clay': { "                                                                  \
                     "'albedo': [0.5, 0.45, 0.4] } }, " LF_TEST_SHARP_LIGHTS " }"

#endif
