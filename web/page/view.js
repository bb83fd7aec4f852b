// Draws one view of a quilt, or a mix of two neighbouring views, with WebGL2.

const HEADER = 16;

// The header of an image message; docs/reference/protocol.md, Gateway.
export function readHeader(buffer) {
  const data = new DataView(buffer);
  return {
    generation: data.getUint32(0, true),
    level: data.getUint8(4),
    columns: data.getUint16(6, true),
    rows: data.getUint16(8, true),
    views: data.getUint16(10, true),
    width: data.getUint16(12, true),
    height: data.getUint16(14, true),
  };
}

const VERTEX = `#version 300 es
out vec2 at;
void main() {
  at = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2);
  gl_Position = vec4(at * 2.0 - 1.0, 0.0, 1.0);
}`;

const FRAGMENT = `#version 300 es
precision highp float;
uniform sampler2D quilt;
uniform ivec3 layout_; // columns, rows, views
uniform vec2 tile;     // pixels of a view
uniform float view;    // 0 to views - 1
in vec2 at;
out vec4 colour;
vec3 look(int i) {
  vec2 origin = vec2(i % layout_.x, i / layout_.x) * tile;
  // half a pixel inside: nothing of the next view is mixed in
  vec2 inside = clamp(at * tile, vec2(0.5), tile - 0.5);
  return texture(quilt, (origin + inside) / (vec2(layout_.xy) * tile)).rgb;
}
void main() {
  int i = int(floor(view)), next = min(i + 1, layout_.z - 1);
  colour = vec4(mix(look(i), look(next), fract(view)), 1.0);
}`;

function compile(gl, type, source) {
  const shader = gl.createShader(type);
  gl.shaderSource(shader, source);
  gl.compileShader(shader);
  return shader;
}

export class QuiltView {
  #canvas;
  #gl;
  #uniforms;
  #image; // { header, bitmap }
  #position = 0.5;
  #aspect;
  #drawing = 0;

  constructor(canvas) {
    this.#canvas = canvas;
    this.#gl = canvas.getContext("webgl2", { alpha: false, antialias: false });
    if (!this.#gl) throw new Error("This browser has no WebGL2, which the preview needs.");
    this.#setUp();
    canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
    canvas.addEventListener("webglcontextrestored", () => {
      this.#setUp();
      this.#upload();
    });
    new ResizeObserver(() => this.#resize()).observe(canvas.parentElement);
  }

  get views() {
    return this.#image?.header.views ?? 0;
  }

  get position() {
    return this.#position;
  }

  // 0: the first view, 1: the last.
  set position(value) {
    this.#position = Math.min(Math.max(value, 0), 1);
    this.#draw();
  }

  // Width / height of the window; undefined: that of a tile.
  set aspect(value) {
    if (this.#aspect === value) return;
    this.#aspect = value;
    this.#resize();
  }

  // Shows an image message.
  async show(buffer) {
    const header = readHeader(buffer);
    const blob = new Blob([new Uint8Array(buffer, HEADER)], { type: "image/jpeg" });
    const bitmap = await createImageBitmap(blob, {
      imageOrientation: "flipY",
      colorSpaceConversion: "none",
      premultiplyAlpha: "none",
    });
    this.#image?.bitmap.close();
    this.#image = { header, bitmap };
    this.#upload();
    this.#resize();
    return header;
  }

  #setUp() {
    const gl = this.#gl;
    const program = gl.createProgram();
    gl.attachShader(program, compile(gl, gl.VERTEX_SHADER, VERTEX));
    gl.attachShader(program, compile(gl, gl.FRAGMENT_SHADER, FRAGMENT));
    gl.linkProgram(program);
    gl.useProgram(program);
    const at = (name) => gl.getUniformLocation(program, name);
    this.#uniforms = { layout: at("layout_"), tile: at("tile"), view: at("view") };
    gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
    for (const side of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T])
      gl.texParameteri(gl.TEXTURE_2D, side, gl.CLAMP_TO_EDGE);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
  }

  #upload() {
    if (!this.#image) return;
    const gl = this.#gl;
    const { header, bitmap } = this.#image;
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB8, gl.RGB, gl.UNSIGNED_BYTE, bitmap);
    gl.uniform3i(this.#uniforms.layout, header.columns, header.rows, header.views);
    gl.uniform2f(this.#uniforms.tile, header.width, header.height);
    this.#draw();
  }

  // The largest canvas of the image's shape in the stage.
  #resize() {
    if (!this.#image) return;
    const { width, height } = this.#image.header;
    const { clientWidth, clientHeight } = this.#canvas.parentElement;
    const aspect = this.#aspect ?? width / height;
    const wide = Math.min(clientWidth, clientHeight * aspect);
    this.#canvas.style.width = `${wide}px`;
    this.#canvas.style.height = `${wide / aspect}px`;
    this.#canvas.width = Math.max(1, Math.round(wide * devicePixelRatio));
    this.#canvas.height = Math.max(1, Math.round((wide / aspect) * devicePixelRatio));
    this.#draw();
  }

  #draw() {
    this.#drawing ||= requestAnimationFrame(() => {
      this.#drawing = 0;
      if (!this.#image) return;
      const gl = this.#gl;
      const { views } = this.#image.header;
      const view = Math.min(Math.max(this.#position * views - 0.5, 0), views - 1);
      gl.viewport(0, 0, this.#canvas.width, this.#canvas.height);
      gl.uniform1f(this.#uniforms.view, view);
      gl.drawArrays(gl.TRIANGLES, 0, 3);
    });
  }
}
