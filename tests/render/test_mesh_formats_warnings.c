/* The tables of docs/reference/formats/meshes.md but 3DS: each row's statement in a file that is
 * made here, and what the reader makes of it. */
#include "tests/render/mesh_warnings.h"

/* clang-format off */
#define BINARY(name, verdict, ...) {name, verdict, binary_row, &(const binary_said){__VA_ARGS__}}
/* clang-format on */

/* --------------------------------------------------------------------------------------- OBJ -- */

#define V "v 0 0 0\nv 2 0 0\nv 2 3 0\nv 0 3 0\n"
#define F "f 1 2 3 4\n"
#define LIB "mtllib pictured.mtl\nusemtl p\n"
#define VT "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
#define FT "f 1/1 2/2 3/3 4/4\n"
#define BOTH "v 0 0 0\nv 2 0 0\nv 2 3 0\nv 0 3 0\nv 4 0 1\n"
#define CURVES "cstype bezier\ndeg 3\n"

static const lf_format_row obj_rows[] = {
    USED("v x y z", V F, "v 0 0 0\nv 2 0 0\nv 2 3 0\nv 0 3 1\n" F),
    USED("v x y z w", "v 0 0 0 2\nv 2 0 0 2\nv 2 3 0 2\nv 0 3 0 2\n" F),
    USED("v x y z r g b", "v 0 0 0 1 0 0\nv 2 0 0 1 0 0\nv 2 3 0 0 1 0\nv 0 3 0 0 0 1\n" F),
    TOLD("v with more numbers", "v 0 0 0 1 0 0 1\nv 2 0 0 1 0 0 1\nv 2 3 0 1 0 0 1\nf 1 2 3\n",
         "lines of v, vn or vt with more numbers than are known (3)"),
    TOLD("v that is not finite", V "v nan 0 0\n" F "f 1 2 5\n",
         "1 of 3 triangles is left out: a vertex is not finite"),
    REFUSED("v that is no number", "v 0 3.1+e2 0\n" F, "found \"3.1+e2\""),
    USED("vt u v", LIB V VT FT, LIB V "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 0.5\n" FT),
    IGNORED("vt u v w", LIB V "vt 0 0 1\nvt 1 0 1\nvt 1 1 1\nvt 0 1 1\n" FT, LIB V VT FT),
    USED("vn", V "vn 0 0.6 0.8\nf 1//1 2//1 3//1 4//1\n"),
    IGNORED("vp", V "vp 0.5 0.5 1\n" F),
    USED("f v", V F, V "f 1 2 3\n"),
    USED("f v/vt", LIB V VT FT, LIB V VT F),
    USED("f v//vn", V "vn 0 0.6 0.8\nf 1//1 2//1 3//1 4//1\n", V "vn 0 0.6 0.8\n" F),
    USED("f v/vt/vn", LIB V VT "vn 0 0.6 0.8\nf 1/1/1 2/2/1 3/3/1 4/4/1\n",
         LIB V VT "vn 0 0.6 0.8\n" FT),
    USED("f of negative numbers", V "f -4 -3 -2 -1\n", V "f -4 -3 -2\n"),
    TOLD("f of a vertex that is not there", V F "f 1 2 9\n",
         "1 face that names vertices that there are not is left out"),
    TOLD("f of a normal that is not there", V "f 1//1 2//1 3//1\n",
         "corners that name normals that there are not (3) have none"),
    TOLD("f of a texture coordinate that is not there", V "f 1/7 2/7 3/7\n",
         "3 corners name texture coordinates that there are not"),
    USED("fo", V "fo 1 2 3 4\n", V "fo 1 2 3\n"),
    TOLD("p", V F "p 1 2\n", "2 points and lines are left out"),
    TOLD("l", V F "l 1 2 3\n", "2 points and lines are left out"),
    TOLD("curv", V F CURVES "curv 0 1 1 2 3 4\nparm u 0 1\nend\n",
         "statements that are left out: curv"),
    TOLD("curv2", V F "vp 0 0\nvp 1 1\n" CURVES "curv2 1 2\nend\n",
         "statements that are left out: curv2"),
    TOLD("surf", V F CURVES "surf 0 1 0 1 1 2 3 4\nparm u 0 1\nend\n",
         "statements that are left out: surf"),
    IGNORED("cstype", V "cstype rat bspline\n" F),
    IGNORED("deg", V "deg 3 3\n" F),
    IGNORED("bmat", V "bmat u 1 0 0 1\n" F),
    IGNORED("step", V "step 1 1\n" F),
    IGNORED("parm", V "parm u 0 1\n" F),
    IGNORED("trim", V "trim 0 1 1\n" F),
    IGNORED("hole", V "hole 0 1 1\n" F),
    IGNORED("scrv", V "scrv 0 1 1\n" F),
    IGNORED("sp", V "sp 1 2\n" F),
    IGNORED("end", V "end\n" F),
    IGNORED("con", V "con 1 0 1 1 2 0 1 2\n" F),
    USED("g", V "g a\nf 1 2 3\ng b\nf 1 3 4\n", V "f 1 2 3\nf 1 3 4\n"),
    USED("o", V "o a\nf 1 2 3\no b\nf 1 3 4\n", V "f 1 2 3\nf 1 3 4\n"),
    TOLD("s", BOTH "s 1\nf 1 2 3 4\nf 2 5 3\n",
         "faces of smoothing groups without normals (2) are flat"),
    IGNORED("s off", V "s off\n" F),
    IGNORED("mg", V "mg 1 0.5\n" F),
    USED("usemtl", "mtllib colours.mtl\n" V "usemtl red\n" F,
         "mtllib colours.mtl\n" V "usemtl green\n" F),
    USED("mtllib", "mtllib colours.mtl\n" V "usemtl red\n" F, V "usemtl red\n" F),
    TOLD("usemtl of a material that is not there", "mtllib colours.mtl\n" V "usemtl gone\n" F,
         "material \"gone\": not in the file's material libraries, so it is grey"),
    TOLD("usemtl without mtllib", V "usemtl gone\n" F,
         "material \"gone\": not in the file's material libraries, so it is grey"),
    TOLD("maplib", V "maplib a.map\n" F, "statements that are left out: maplib"),
    TOLD("usemap", V "usemap a\n" F, "statements that are left out: usemap"),
    TOLD("bevel", V "bevel on\n" F, "statements that are left out: bevel"),
    TOLD("c_interp", V "c_interp on\n" F, "statements that are left out: c_interp"),
    TOLD("d_interp", V "d_interp on\n" F, "statements that are left out: d_interp"),
    TOLD("lod", V "lod 20\n" F, "statements that are left out: lod"),
    IGNORED("bevel off", V "bevel off\nc_interp off\nd_interp off\nlod 0\n" F),
    TOLD("shadow_obj", V "shadow_obj a.obj\n" F, "statements that are left out: shadow_obj"),
    TOLD("trace_obj", V "trace_obj a.obj\n" F, "statements that are left out: trace_obj"),
    TOLD("ctech", V "ctech cparm 1\n" F, "statements that are left out: ctech"),
    TOLD("stech", V "stech cparma 1 1\n" F, "statements that are left out: stech"),
    TOLD("call", V "call more.obj\n" F, "statements that are left out: call"),
    TOLD("csh", V "csh echo\n" F, "statements that are left out: csh"),
    TOLD("bsp", V "bsp 1 2 3 4\n" F, "statements that are left out: bsp"),
    TOLD("bzp", V "bzp 1 2 3 4\n" F, "statements that are left out: bzp"),
    TOLD("cdc", V "cdc 1 2 3 4\n" F, "statements that are left out: cdc"),
    TOLD("cdp", V "cdp 1 2 3 4\n" F, "statements that are left out: cdp"),
    TOLD("res", V "res 4 4\n" F, "statements that are left out: res"),
    TOLD("any other statement", V "frobnicate 3\n" F, "statements that are left out: frobnicate"),
    IGNORED("#", "# made by a program\n" V F),
    USED("\\ at the end of a line", V "f 1 2 \\\n3 4\n", V "f 1 2 3\n"),
    REFUSED("UTF-16", "\xff\xfev", "is UTF-16 text; save it as UTF-8"),
};

/* --------------------------------------------------------------------------------------- MTL -- */

#define M "newmtl m\nKd 0.2 0.3 0.4\n"
#define SHINY M "Ks 0.5 0.5 0.5\nNs 50\n"
#define MAPPED M "map_Kd "
#define LEFT "said.mtl: statements that are left out: "

static const lf_format_row mtl_rows[] = {
    USED("newmtl", "newmtl m\nKd 1 0 0\n", "newmtl other\nKd 1 0 0\n"),
    IGNORED("Ka", M "Ka 1 1 1\n"),
    USED("Kd", "newmtl m\nKd 0.9 0.3 0.4\n"),
    TOLD("Kd spectral", "newmtl m\nKd spectral a.rfl 1\n",
         "statements that do not say numbers (the first in line 2) are left out: Kd"),
    TOLD("Kd xyz", "newmtl m\nKd xyz 0.1 0.1 0.1\n",
         "statements that do not say numbers (the first in line 2) are left out: Kd"),
    USED("Ks", SHINY, M "Ns 50\n"),
    TOLD("Ks without Ns", M "Ks 0.5 0.5 0.5\n", LEFT "Ks without Ns"),
    USED("Ns", SHINY, M "Ks 0.5 0.5 0.5\nNs 10\n"),
    USED("Ke", M "Ke 1 2 3\n"),
    USED("Ni", SHINY "Ni 1.8\n", SHINY),
    USED("d", M "d 0.5\n"),
    TOLD("d 0", M "d 0\n", "transparency is left out: opaque"),
    TOLD("d -halo", M "d -halo 0.5\n", LEFT "d -halo"),
    USED("Tr", M "Tr 0.25\n"),
    TOLD("Tf", M "Tf 1 0.5 0.5\n", "transparency is left out: opaque"),
    IGNORED("Tf 1 1 1", M "Tf 1 1 1\n"),
    TOLD("illum 0", M "illum 0\n", "illum 0 (unlit) is not read"),
    IGNORED("illum 1", M "illum 1\n"),
    IGNORED("illum 2", M "illum 2\n"),
    IGNORED("illum 3", M "illum 3\n"),
    TOLD("illum 4", M "illum 4\n", LEFT "illum 4"),
    IGNORED("illum 5", M "illum 5\n"),
    TOLD("illum 6", M "illum 6\n", LEFT "illum 6"),
    TOLD("illum 7", M "illum 7\n", LEFT "illum 7"),
    IGNORED("illum 8", M "illum 8\n"),
    TOLD("illum 9", M "illum 9\n", LEFT "illum 9"),
    TOLD("illum 10", M "illum 10\n", LEFT "illum 10"),
    TOLD("sharpness", M "sharpness 60\n", LEFT "sharpness"),
    USED("map_Kd", MAPPED "picture.png\n"),
    TOLD("map_Kd of a file that is not there", MAPPED "gone.png\n", "gone.png"),
    IGNORED("map_Ka", M "map_Ka picture.png\n"),
    TOLD("map_Ks", M "map_Ks picture.png\n", "are not read"),
    TOLD("map_Ns", M "map_Ns picture.png\n", "are not read"),
    USED("map_Ke", M "Ke 1 1 1\nmap_Ke picture.png\n", M "Ke 1 1 1\n"),
    USED("map_d", M "map_d picture.png\n"),
    IGNORED("map_aat", M "map_aat on\n"),
    USED("bump", M "bump normals.png\n"),
    USED("map_bump", M "map_bump normals.png\n"),
    TOLD("bump of heights", M "bump picture.png\n", "are not read"),
    TOLD("disp", M "disp picture.png\n", "are not read"),
    TOLD("decal", M "decal picture.png\n", "are not read"),
    TOLD("refl", M "refl -type sphere picture.png\n", "are not read"),
    USED("-s", MAPPED "-s 2 2 1 picture.png\n", MAPPED "picture.png\n"),
    USED("-o", MAPPED "-o 0.5 0 0 picture.png\n", MAPPED "picture.png\n"),
    TOLD("-t", MAPPED "-t 0.1 0 0 picture.png\n", "options of its textures are left out"),
    USED("-clamp", MAPPED "-clamp on picture.png\n", MAPPED "picture.png\n"),
    USED("-bm", M "norm -bm 0.5 normals.png\n", M "norm normals.png\n"),
    IGNORED("-blendu", MAPPED "-blendu off picture.png\n", MAPPED "picture.png\n"),
    IGNORED("-blendv", MAPPED "-blendv off picture.png\n", MAPPED "picture.png\n"),
    IGNORED("-boost", MAPPED "-boost 2 picture.png\n", MAPPED "picture.png\n"),
    IGNORED("-texres", MAPPED "-texres 256 picture.png\n", MAPPED "picture.png\n"),
    IGNORED("-cc", MAPPED "-cc on picture.png\n", MAPPED "picture.png\n"),
    TOLD("-mm", MAPPED "-mm 0.1 2 picture.png\n", "options of its textures are left out"),
    TOLD("-imfchan", MAPPED "-imfchan r picture.png\n", "options of its textures are left out"),
    TOLD("any other option", MAPPED "-frob 3 picture.png\n",
         "options of its textures are left out"),
    USED("Pm", M "Pm 1\nPr 0.5\n"),
    USED("Pr", M "Pm 1\nPr 0.5\n", M "Pm 1\nPr 0.2\n"),
    TOLD("Pr without Pm", M "Pr 0.5\n", LEFT "Pr without Pm"),
    TOLD("Ps", M "Pm 0\nPs 0.5\n", "the sheen is left out"),
    TOLD("Pc", M "Pm 0\nPc 0.5\n", "the clear coat is left out"),
    IGNORED("Pcr", M "Pcr 0.03\n"),
    TOLD("aniso", M "Pm 1\nPr 0.5\naniso 0.5\n", "anisotropy is left out"),
    IGNORED("anisor", M "anisor 0.25\n"),
    USED("norm", M "norm normals.png\n"),
    TOLD("map_Pr", M "Pm 1\nPr 1\nmap_Pr picture.png\n", "are not read"),
    TOLD("map_Pm", M "Pm 1\nPr 1\nmap_Pm picture.png\n", "are not read"),
    TOLD("map_Ps", M "map_Ps picture.png\n", "are not read"),
    TOLD("any other map", M "map_RMA picture.png\n", "are not read"),
    TOLD("any other statement", M "Km 0.5\n", LEFT "Km"),
    TOLD("more numbers than belong there", "newmtl m\nKd 1 0 0 1\nd 0.5 0.5\n",
         "said.mtl: lines with more numbers than are known (2): what is behind is left out"),
    TOLD("a texture without a picture", M "map_Kd -s 2 2 2\n",
         "said.mtl: textures without the name of a picture are left out: map_Kd"),
    TOLD("a picture that begins like a number", M "map_Kd -s 2 2 Nancy.png\n", "Nancy.png"),
    TOLD("a number that is none", M "Ns shiny\n",
         "statements that do not say numbers (the first in line 3) are left out: Ns"),
    IGNORED("#", "# made by a program\n" M),
    REFUSED("UTF-16", "\xff\xfen", "said.mtl: is UTF-16 text; save it as UTF-8"),
};

/* --------------------------------------------------------------------------------------- PLY -- */

#define PLY "ply\nformat ascii 1.0\n"
#define XYZ "property float x\nproperty float y\nproperty float z\n"
#define VERTEX "element vertex 4\n" XYZ
#define FACE "element face 1\nproperty list uchar int vertex_indices\n"
#define DATA "0 0 0\n2 0 0\n2 3 0\n0 3 0\n"
#define QUAD "4 0 1 2 3\n"
#define END "end_header\n"
#define PLAIN PLY VERTEX FACE END DATA QUAD
#define WITH(properties, a, b, c, d)                                                               \
    PLY VERTEX properties FACE END "0 0 0 " a "\n2 0 0 " b "\n2 3 0 " c "\n0 3 0 " d "\n" QUAD
#define TEXTURED "ply\nformat ascii 1.0\ncomment TextureFile picture.png\n"
#define RGB(type) "property " type " red\nproperty " type " green\nproperty " type " blue\n"
#define PROPERTIES "properties that are left out: "
#define MATERIAL                                                                                   \
    "element material 1\nproperty uchar diffuse_red\nproperty uchar diffuse_green\n"               \
    "property uchar diffuse_blue\n"

/* Every name of a type, as that of a coordinate and as that of a list's numbers. */
static void every_type_is_used(const lf_format_row *row)
{
    static const char *const types[] = {"char",   "int8",    "uchar",  "uint8",  "short", "int16",
                                        "ushort", "uint16",  "int",    "int32",  "uint",  "uint32",
                                        "float",  "float32", "double", "float64"};
    result plain = read_said(PLAIN);
    for (size_t i = 0; i < sizeof types / sizeof *types; i++) {
        char text[512];
        const bool whole = i < 12;
        snprintf(text, sizeof text,
                 PLY "element vertex 4\nproperty %s x\nproperty %s y\nproperty %s z\nelement face "
                     "1\nproperty list %s %s vertex_indices\n" END DATA QUAD,
                 types[i], types[i], types[i], whole ? types[i] : "uchar", types[i]);
        result r = read_said(text);
        assert_read(row, &r);
        assert_quiet(row, &r);
        if (r.print != plain.print)
            fail_msg("%s: another mesh", types[i]);
        lf_mesh_data_finish(&r.data);
    }
    lf_mesh_data_finish(&plain.data);
}

/* The square in binary, the highest byte first or last. */
static void binary_is_used(const lf_format_row *row)
{
    static const float points[12] = {0, 0, 0, 2, 0, 0, 2, 3, 0, 0, 3, 0};
    const bool big = strstr(row->name, "big");
    char file[1024];
    int n = snprintf(file, sizeof file, "ply\nformat %s 1.0\n" VERTEX FACE END,
                     big ? "binary_big_endian" : "binary_little_endian");
    for (int i = 0; i < 12 + 1 + 4; i++) {
        uint32_t bits = (uint32_t)(i - 13);
        if (i < 12)
            memcpy(&bits, &points[i], sizeof bits);
        if (i == 12)
            file[n++] = 4;
        for (int k = 0; k < 4 && i != 12; k++)
            file[n++] = (char)(bits >> 8 * (big ? 3 - k : k));
    }
    result plain = read_said(PLAIN), r = read_bytes(file, (size_t)n);
    assert_read(row, &r);
    assert_true(r.print == plain.print);
    lf_mesh_data_finish(&r.data);
    lf_mesh_data_finish(&plain.data);
}

static const lf_format_row ply_rows[] = {
    USED("format ascii", PLAIN, PLY VERTEX FACE END DATA "3 0 1 2\n"),
    {"format binary_little_endian", "used", binary_is_used, NULL},
    {"format binary_big_endian", "used", binary_is_used, NULL},
    {"types", "used", every_type_is_used, NULL},
    IGNORED("comment",
            "ply\nformat ascii 1.0\ncomment made by a program\n" VERTEX FACE END DATA QUAD),
    IGNORED("obj_info", "ply\nformat ascii 1.0\nobj_info num_cols 512\n" VERTEX FACE END DATA QUAD),
    USED("comment TextureFile",
         TEXTURED VERTEX "property float s\nproperty float t\n" FACE END
                         "0 0 0 0 0\n2 0 0 1 0\n2 3 0 1 1\n0 3 0 0 1\n" QUAD),
    USED("x, y, z", PLAIN, PLY VERTEX FACE END "0 0 0\n2 0 0\n2 3 0\n0 3 1\n" QUAD),
    USED("nx, ny, nz", WITH("property float nx\nproperty float ny\nproperty float nz\n",
                            "0 0.6 0.8", "0 0.6 0.8", "0 0 1", "0 0 1")),
    USED("red, green, blue", WITH(RGB("uchar"), "255 0 0", "255 0 0", "0 255 0", "0 0 255")),
    USED("r, g, b", WITH("property uchar r\nproperty uchar g\nproperty uchar b\n", "255 0 0",
                         "255 0 0", "0 255 0", "0 0 255")),
    USED("diffuse_red, diffuse_green, diffuse_blue",
         WITH("property uchar diffuse_red\nproperty uchar diffuse_green\nproperty uchar "
              "diffuse_blue\n",
              "255 0 0", "255 0 0", "0 255 0", "0 0 255")),
    USED("alpha",
         WITH(RGB("uchar") "property uchar alpha\n", "255 0 0 128", "255 0 0 128", "0 255 0 128",
              "0 0 255 128"),
         WITH(RGB("uchar"), "255 0 0", "255 0 0", "0 255 0", "0 0 255")),
    USED("s, t",
         TEXTURED VERTEX "property float s\nproperty float t\n" FACE END
                         "0 0 0 0 0\n2 0 0 1 0\n2 3 0 1 1\n0 3 0 0 1\n" QUAD,
         TEXTURED VERTEX "property float s\nproperty float t\n" FACE END
                         "0 0 0 0 0\n2 0 0 1 0\n2 3 0 1 1\n0 3 0 0 0.5\n" QUAD),
    USED("u, v", TEXTURED VERTEX "property float u\nproperty float v\n" FACE END
                                 "0 0 0 0 0\n2 0 0 1 0\n2 3 0 1 1\n0 3 0 0 1\n" QUAD),
    USED("texture_u, texture_v",
         TEXTURED VERTEX "property float texture_u\nproperty float texture_v\n" FACE END
                         "0 0 0 0 0\n2 0 0 1 0\n2 3 0 1 1\n0 3 0 0 1\n" QUAD),
    IGNORED("s, t without a texture",
            WITH("property float s\nproperty float t\n", "0 0", "1 0", "1 1", "0 1")),
    IGNORED("confidence", WITH("property float confidence\n", "1", "1", "0.5", "1")),
    IGNORED("intensity", WITH("property float intensity\n", "1", "1", "0.5", "1")),
    IGNORED("quality", WITH("property float quality\n", "1", "1", "0.5", "1")),
    IGNORED("flags", WITH("property int flags\n", "1", "1", "0", "1")),
    IGNORED("curvature", WITH("property float curvature\n", "1", "1", "0", "1")),
    TOLD("any other property of a vertex", WITH("property float radius\n", "1", "1", "1", "1"),
         PROPERTIES "radius of vertex"),
    USED("vertex_indices", PLAIN, PLY VERTEX FACE END DATA "3 0 1 2\n"),
    USED("vertex_index",
         PLY VERTEX "element face 1\nproperty list uchar int vertex_index\n" END DATA QUAD,
         PLY VERTEX FACE END DATA "3 0 1 2\n"),
    TOLD("an index that is no vertex's",
         PLY VERTEX "element face 2\nproperty list uchar int vertex_indices\n" END DATA QUAD
                    "3 0 1 77\n",
         "1 face that names vertices that there are not is left out"),
    TOLD("a vertex that is not finite",
         PLY "element vertex 5\n" XYZ "element face 2\nproperty list uchar int "
             "vertex_indices\n" END DATA "nan 0 0\n" QUAD "3 0 1 4\n",
         "1 of 3 triangles is left out: a vertex is not finite"),
    USED("texcoord", TEXTURED VERTEX FACE "property list uchar float texcoord\n" END DATA
                                          "4 0 1 2 3 8 0 0 1 0 1 1 0 1\n"),
    USED("texnumber",
         "ply\nformat ascii 1.0\ncomment TextureFile picture.png\ncomment TextureFile "
         "normals.png\n" VERTEX FACE
         "property list uchar float texcoord\nproperty int texnumber\n" END DATA
         "4 0 1 2 3 8 0 0 1 0 1 1 0 1 1\n",
         "ply\nformat ascii 1.0\ncomment TextureFile picture.png\ncomment TextureFile "
         "normals.png\n" VERTEX FACE
         "property list uchar float texcoord\nproperty int texnumber\n" END DATA
         "4 0 1 2 3 8 0 0 1 0 1 1 0 1 0\n"),
    USED("material_index",
         PLY VERTEX FACE "property int material_index\nelement material 2\nproperty uchar "
                         "diffuse_red\nproperty uchar diffuse_green\nproperty uchar "
                         "diffuse_blue\n" END DATA "4 0 1 2 3 1\n255 0 0\n0 255 0\n",
         PLY VERTEX FACE "property int material_index\nelement material 2\nproperty uchar "
                         "diffuse_red\nproperty uchar diffuse_green\nproperty uchar "
                         "diffuse_blue\n" END DATA "4 0 1 2 3 0\n255 0 0\n0 255 0\n"),
    TOLD("red, green, blue of a face", PLY VERTEX FACE RGB("uchar") END DATA "4 0 1 2 3 255 0 0\n",
         PROPERTIES "red of face, green of face, blue of face"),
    TOLD("any other property of a face",
         PLY VERTEX FACE "property float nx\n" END DATA "4 0 1 2 3 1\n", PROPERTIES "nx of face"),
    USED("tristrips", PLY VERTEX
         "element tristrips 1\nproperty list int int vertex_indices\n" END DATA "4 0 1 3 2\n"),
    USED("material", PLY VERTEX FACE MATERIAL END DATA QUAD "255 0 0\n"),
    USED("specular_red, specular_green, specular_blue, specular_power",
         PLY VERTEX FACE MATERIAL
         "property uchar specular_red\nproperty uchar specular_green\nproperty uchar "
         "specular_blue\nproperty float specular_power\n" END DATA QUAD "255 0 0 200 200 200 50\n",
         PLY VERTEX FACE MATERIAL END DATA QUAD "255 0 0\n"),
    IGNORED("ambient_red, ambient_green, ambient_blue",
            PLY VERTEX FACE MATERIAL
            "property uchar ambient_red\nproperty uchar ambient_green\nproperty uchar "
            "ambient_blue\n" END DATA QUAD "255 0 0 9 9 9\n",
            PLY VERTEX FACE MATERIAL END DATA QUAD "255 0 0\n"),
    TOLD("any other property of a material",
         PLY VERTEX FACE MATERIAL "property float opacity\n" END DATA QUAD "255 0 0 0.5\n",
         PROPERTIES "opacity of material"),
    TOLD("edge",
         PLY VERTEX FACE
         "element edge 1\nproperty int vertex1\nproperty int vertex2\n" END DATA QUAD "0 1\n",
         "elements that are left out: edge"),
    TOLD("any other element",
         PLY VERTEX FACE "element camera 1\nproperty float view_px\n" END DATA QUAD "1\n",
         "elements that are left out: camera"),
    REFUSED("a number that is none", PLY VERTEX FACE END "0 0 0\n2 0 0\n2 3 0\n0 three 0\n" QUAD,
            "not a number"),
    REFUSED("UTF-16", "\xff\xfep", "is UTF-16 text; save it as UTF-8"),
};

/* --------------------------------------------------------------------------------------- STL -- */

#define FACET(v) "facet normal 0 0 1\nouter loop\n" v "endloop\nendfacet\n"
#define A "vertex 0 0 0\nvertex 2 0 0\nvertex 2 3 0\n"
#define B "vertex 0 0 0\nvertex 2 3 0\nvertex 0 3 0\n"
#define STL "solid a\n" FACET(A) FACET(B) "endsolid a\n"

/* A binary file of the triangles A and B: its title, the two bytes behind each, bytes behind all.
 */
static result read_binary(const char *title, size_t n_title, unsigned a, unsigned b, size_t behind)
{
    static const float corners[2][9] = {{0, 0, 0, 2, 0, 0, 2, 3, 0}, {0, 0, 0, 2, 3, 0, 0, 3, 0}};
    unsigned char file[84 + 2 * 50 + 16] = {0};
    memcpy(file, title, n_title);
    file[80] = 2;
    for (int t = 0; t < 2; t++) {
        unsigned char *facet = file + 84 + 50 * t;
        const unsigned bits = t ? b : a;
        memcpy(facet + 12, corners[t], sizeof corners[t]);
        facet[48] = (unsigned char)bits;
        facet[49] = (unsigned char)(bits >> 8);
    }
    return read_bytes(file, 84 + 2 * 50 + behind);
}

typedef struct binary_said {
    const char *title;
    size_t n;
    unsigned a, b;
    size_t behind;
    const char *words;
} binary_said;

static void binary_row(const lf_format_row *row)
{
    const binary_said *s = row->with;
    result with = read_binary(s->title, s->n, s->a, s->b, s->behind),
           without = read_binary("", 0, 0, 0, 0);
    assert_read(row, &with);
    assert_read(row, &without);
    if (strcmp(row->verdict, "warned") == 0) {
        if (!warns(&with, s->words))
            fail_msg("%s is not told", row->name);
    } else {
        assert_quiet(row, &with);
        if ((with.print == without.print) != (strcmp(row->verdict, "ignored") == 0))
            fail_msg("%s: %s", row->name,
                     with.print == without.print ? "changes nothing" : "changes the mesh");
    }
    lf_mesh_data_finish(&with.data);
    lf_mesh_data_finish(&without.data);
}

/* Binary and text make the same mesh. */
static void binary_is_as_text(const lf_format_row *row)
{
    result binary = read_binary("title", 5, 0, 0, 0), text = read_said(STL);
    assert_read(row, &binary);
    assert_true(binary.print == text.print);
    lf_mesh_data_finish(&binary.data);
    lf_mesh_data_finish(&text.data);
}

#define COLOUR "COLOR=\xff\x40\x20\xff"

static const lf_format_row stl_rows[] = {
    USED("facet", STL, "solid a\n" FACET(A) "endsolid a\n"),
    USED("vertex", STL, "solid a\n" FACET(A) FACET(A) "endsolid a\n"),
    IGNORED("normal", "solid a\nfacet normal 1 0 0\nouter loop\n" A
                      "endloop\nendfacet\n" FACET(B) "endsolid a\n"),
    IGNORED("the name of a solid", "solid another one\n" FACET(A) FACET(B) "endsolid\n"),
    USED("a second solid", "solid a\n" FACET(A) "endsolid a\nsolid b\n" FACET(B) "endsolid b\n"),
    TOLD("no endsolid", "solid a\n" FACET(A) FACET(B),
         "does not end in \"endsolid\": it may be cut off"),
    TOLD("a vertex that is not finite",
         "solid a\n" FACET(A) FACET("vertex nan 0 0\nvertex 1 0 0\nvertex 0 1 0\n") "endsolid a\n",
         "1 of 2 triangles is left out: a vertex is not finite"),
    REFUSED("any other statement", "solid a\ncolour 1 0 0\n" FACET(A) "endsolid a\n",
            "line 2: expected solid, facet, vertex, or an end of these"),
    REFUSED("a number that is none",
            "solid a\n" FACET("vertex 0 0 0x1\nvertex 1 0 0\nvertex 0 1 0\n") "endsolid a\n",
            "line 4: expected three numbers"),
    REFUSED("UTF-16", "\xff\xfes", "is UTF-16 text; save it as UTF-8"),
    {"binary", "used", binary_is_as_text, NULL},
    BINARY("the title of a binary file", "ignored", "made by a program", 17, 0, 0, 0, NULL),
    BINARY("a title of a binary file in UTF-16", "ignored", "m\0o\0d\0e\0l\0", 10, 0, 0, 0, NULL),
    BINARY("COLOR=", "used", COLOUR, 10, 0x8000, 0x8000, 0, NULL),
    BINARY("alpha of COLOR=", "warned", "COLOR=\xff\x40\x20\x80", 10, 0x8000, 0x8000, 0,
           "of the title's COLOR= and MATERIAL= the colour alone is used"),
    BINARY("MATERIAL=", "warned", COLOUR "MATERIAL=\1\2\3\4", 23, 0x8000, 0x8000, 0,
           "of the title's COLOR= and MATERIAL= the colour alone is used"),
    BINARY("attribute bytes with a colour, of VisCAM", "used", "", 0, 0x801f, 0x83e0, 0, NULL),
    BINARY("attribute bytes with a colour, of Magics", "used", COLOUR, 10, 0x001f, 0x03e0, 0, NULL),
    BINARY("attribute bytes without a colour", "ignored", "", 0, 0x1234, 7, 0, NULL),
    BINARY("bytes behind the last triangle", "ignored", "x\0y", 3, 0, 0, 9, NULL),
};

static void every_statement_of_obj_is_what_the_table_says(void **state)
{
    (void)state;
    WALK("OBJ", "said.obj", "said.obj", V F, obj_rows);
}

static void every_statement_of_mtl_is_what_the_table_says(void **state)
{
    (void)state;
    WALK("MTL", "user.obj", "said.mtl", M, mtl_rows);
}

static void every_statement_of_ply_is_what_the_table_says(void **state)
{
    (void)state;
    WALK("PLY", "said.ply", "said.ply", PLAIN, ply_rows);
}

static void every_statement_of_stl_is_what_the_table_says(void **state)
{
    (void)state;
    WALK("STL", "said.stl", "said.stl", STL, stl_rows);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_statement_of_obj_is_what_the_table_says),
        cmocka_unit_test(every_statement_of_mtl_is_what_the_table_says),
        cmocka_unit_test(every_statement_of_ply_is_what_the_table_says),
        cmocka_unit_test(every_statement_of_stl_is_what_the_table_says),
    };
    return cmocka_run_group_tests(tests, begin_said, finish_said);
}
