/* Bytes of a glTF file for tests: a triangle of unit legs (accessor 0), and of what moves two
 * moments, 0 and 2 s (1), 8 along x (2), 4 along y (3). */
#ifndef LF_TESTS_WALKER_H
#define LF_TESTS_WALKER_H

#define WALKER_BYTES                                                                               \
    "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],\"buffers\":["              \
    "{\"byteLength\":92,\"uri\":\"data:;base64,"                                                   \
    "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAEAAAAAAAAAAAAAAAAAAAABBAAAAAAAAAAAA" \
    "AAAAAAAAAAAAAAAAAAAAAACAQAAAAAA=\"}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":92}],"     \
    "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"},"      \
    "{\"bufferView\":0,\"byteOffset\":36,\"componentType\":5126,\"count\":2,\"type\":\"SCALAR\"}," \
    "{\"bufferView\":0,\"byteOffset\":44,\"componentType\":5126,\"count\":2,\"type\":\"VEC3\"},"   \
    "{\"bufferView\":0,\"byteOffset\":68,\"componentType\":5126,\"count\":2,\"type\":\"VEC3\"}]"

/* A channel that moves a node, and its sampler. */
#define WALKER_MOVES(node, output)                                                                 \
    "\"channels\":[{\"sampler\":0,\"target\":{\"node\":" node ",\"path\":\"translation\"}}],"      \
    "\"samplers\":[{\"input\":1,\"output\":" output "}]"

#endif
