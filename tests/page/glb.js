// A model as a GLB file: a square pyramid of one colour.

const CORNERS = [-1, 0, -1, 1, 0, -1, 1, 0, 1, -1, 0, 1, 0, 1.5, 0];
const TRIANGLES = [0, 1, 2, 0, 2, 3, 1, 0, 4, 2, 1, 4, 3, 2, 4, 0, 3, 4];

function chunk(type, data, filler) {
  const padded = Buffer.concat([data, Buffer.alloc(-data.length & 3, filler)]);
  const head = Buffer.alloc(8);
  head.writeUInt32LE(padded.length, 0);
  head.write(type, 4, "latin1");
  return Buffer.concat([head, padded]);
}

// colour: red, green, blue from 0 to 1.
export function makePyramid(colour) {
  const corners = Buffer.from(new Float32Array(CORNERS).buffer);
  const triangles = Buffer.from(new Uint16Array(TRIANGLES).buffer);
  const document = {
    asset: { version: "2.0" },
    scene: 0,
    scenes: [{ nodes: [0] }],
    nodes: [{ mesh: 0, name: "pyramid" }],
    materials: [{ pbrMetallicRoughness: { baseColorFactor: [...colour, 1], metallicFactor: 0 } }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 }, indices: 1, material: 0 }] }],
    accessors: [
      { bufferView: 0, componentType: 5126, count: 5, type: "VEC3", min: [-1, 0, -1], max: [1, 1.5, 1] },
      { bufferView: 1, componentType: 5123, count: TRIANGLES.length, type: "SCALAR" },
    ],
    bufferViews: [
      { buffer: 0, byteLength: corners.length },
      { buffer: 0, byteOffset: corners.length, byteLength: triangles.length },
    ],
    buffers: [{ byteLength: corners.length + triangles.length }],
  };
  const chunks = Buffer.concat([
    chunk("JSON", Buffer.from(JSON.stringify(document)), " "),
    chunk("BIN\0", Buffer.concat([corners, triangles]), 0),
  ]);
  const head = Buffer.alloc(12);
  head.write("glTF", 0, "latin1");
  head.writeUInt32LE(2, 4);
  head.writeUInt32LE(12 + chunks.length, 8);
  return Buffer.concat([head, chunks]);
}
