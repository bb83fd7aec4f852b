/* A material as described in a mesh file, and its conversion. */
#ifndef LF_RENDER_SOURCE_MATERIAL_H
#define LF_RENDER_SOURCE_MATERIAL_H

#include "render/import/scene/mesh_import.h"

/* Features of a material that our surfaces do not have, in the order of the warnings. */
typedef enum lf_lost {
    LF_LOST_TEXTURES, /* all of them */
    LF_LOST_TEXTURE,  /* a missing texture */
    LF_LOST_UV_SET,   /* a texture with unsupported coordinates */
    LF_LOST_MAPS,     /* textures for unsupported uses */
    LF_LOST_MAP_OPTIONS,
    LF_LOST_EMISSION, /* an emission texture */
    LF_LOST_TRANSPARENCY,
    LF_LOST_COAT,
    LF_LOST_SHEEN,
    LF_LOST_ANISOTROPY,
    LF_LOST_UNLIT,
    LF_LOST_UNLIT_TEXTURE, /* the texture of its colour, so that the material is lit */
    LF_LOST_KTX2,
    LF_LOST_MORE_TEXTURES, /* without a slot */
    LF_LOST_OCCLUSION,
    LF_LOST_IRIDESCENCE,
    LF_LOST_DISPERSION,
    LF_LOST_TRANSLUCENCE,
    LF_LOST_GLOSSINESS, /* glTF's older specular-glossiness model */
    LF_LOST_ALPHA_MODE, /* an unknown one */
    LF_LOST_KINDS
} lf_lost;

/* Numbers are as in the file: not clamped, possibly NaN. */
typedef struct lf_source_material {
    char *name; /* owned, lf_free; "": unnamed */
    /* no values, or invented for a mesh without a material: grey, other fields are ignored */
    bool is_none;
    bool is_metallic; /* the model of glTF and of newer MTL files; false: Phong's */
    bool has_diffuse; /* its colour was given */
    bool is_missing;  /* named by an OBJ file, but in none of its libraries */
    unsigned lost;    /* bits 1 << lf_lost */
    /* Roughness as in glTF; ior is 0 if not given; a cutoff above 1 hides all. */
    LF_PRINCIPLED_MEMBERS;
    lf_vec3 highlight;     /* Phong's … */
    float exponent;        /* … 0: not given */
    bool lacks_base;       /* the texture of its colour is not accessible */
    bool emits_by_colours; /* vertex colours multiply the emission, too */
    bool is_solid;         /* as in lf_material, like cover */
    lf_cover cover;
    lf_texture_set textures; /* images of the mesh */
} lf_source_material;

/* A source material with only a name, which is copied: opaque, without a coat, and of index 1.5 if
 * it is metallic. name NULL: no memory. */
lf_source_material lf_source_material_begin(const char *name);

/* Makes out->materials from n source materials, in their order, and out->textures if any has an
 * image. Adds warnings of lost features of used ones (used[i]). LF_E_FORMAT: too many, or none;
 * LF_E_NOMEM. */
LF_NODISCARD lf_status lf_source_materials_convert(const lf_source_material *source, size_t n,
                                                   const bool *used, lf_mesh_data *out,
                                                   lf_error *err);
/* Warns of used materials that are missing. */
void lf_source_materials_warn_of_missing(const lf_source_material *source, size_t n,
                                         const bool *used, lf_warnings *warnings);

#endif
