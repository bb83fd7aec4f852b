/* What a mesh file says of a material, and what of it a picture has. */
#ifndef LF_RENDER_SOURCE_MATERIAL_H
#define LF_RENDER_SOURCE_MATERIAL_H

#include "render/import/scene/mesh_import.h"

/* What a material may hold that no surface of ours has, in the order in which it is told. */
typedef enum lf_lost {
    LF_LOST_TEXTURES, /* all of them */
    LF_LOST_TEXTURE,  /* one that the file names and does not have */
    LF_LOST_UV_SET,   /* one that lies by coordinates that are not read */
    LF_LOST_MAPS,     /* those of other things than the ones that are read */
    LF_LOST_MAP_OPTIONS,
    LF_LOST_EMISSION, /* a texture of what glows */
    LF_LOST_TRANSPARENCY,
    LF_LOST_COAT,
    LF_LOST_SHEEN,
    LF_LOST_ANISOTROPY,
    LF_LOST_UNLIT,
    LF_LOST_UNLIT_TEXTURE, /* that of its colour, so that it is lit */
    LF_LOST_KTX2,
    LF_LOST_MORE_TEXTURES, /* which have no slot */
    LF_LOST_OCCLUSION,
    LF_LOST_IRIDESCENCE,
    LF_LOST_DISPERSION,
    LF_LOST_TRANSLUCENCE,
    LF_LOST_GLOSSINESS, /* glTF's older model */
    LF_LOST_ALPHA_MODE, /* one that nobody knows */
    LF_LOST_KINDS
} lf_lost;

/* Numbers are as the file has them, in no range and perhaps none. */
typedef struct lf_source_material {
    char *name; /* owned, lf_free; "": it has none */
    /* says nothing, or was made up for what has no material: grey, whatever is below */
    bool is_none;
    bool is_metallic; /* glTF's model, and that of newer MTL files; else Phong's */
    bool has_diffuse; /* its colour was said */
    bool is_missing;  /* named by an OBJ file, and in none of its libraries */
    unsigned lost;    /* 1 << lf_lost each */
    /* Roughness is glTF's, ior 0 where it was not said, and a cutoff above 1 hides all. */
    LF_PRINCIPLED_MEMBERS;
    lf_vec3 highlight;     /* Phong's … */
    float exponent;        /* … 0: not said */
    bool lacks_base;       /* the texture of its colour was not to be had */
    bool emits_by_colours; /* those of vertices multiply emission as well */
    bool is_solid;         /* as a material's, and so is … */
    lf_cover cover;
    lf_texture_set textures; /* pictures of the mesh */
} lf_source_material;

/* One that says nothing but its name, of which it takes a copy: opaque, without a coat, and where
 * it is metallic, of index 1.5. NULL in name: no memory. */
lf_source_material lf_source_material_begin(const char *name);

/* Makes out->materials and, where any has a picture, out->textures of n of them, in their order,
 * and adds warnings of what those that triangles use (used[i]) lose. LF_E_FORMAT: too many, or
 * none; LF_E_NOMEM. */
LF_NODISCARD lf_status lf_source_materials_convert(const lf_source_material *source, size_t n,
                                                   const bool *used, lf_mesh_data *out,
                                                   lf_error *err);
/* A warning of those in use that are missing. */
void lf_source_materials_warn_of_missing(const lf_source_material *source, size_t n,
                                         const bool *used, lf_warnings *warnings);

#endif
