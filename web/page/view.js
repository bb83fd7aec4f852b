// Draws the quilt of the preview with WebGL2: one view, two views for two eyes, all, or a panel.

import { lensOf, shareOf } from "./lens.js";
import { EYES, PANEL, VERTEX } from "./shaders.js";
import { pairAt, RED_OF_LEFT, viewAt, viewsApart } from "./stereo.js";

const HEADER = 16;
const SHADER_MODES = { view: 0, parallel: 1, crossed: 1, anaglyph: 2, quilt: 3 };

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

// A program, and its uniforms by name.
function link(gl, fragment) {
  const program = gl.createProgram();
  for (const [type, source] of [
    [gl.VERTEX_SHADER, VERTEX],
    [gl.FRAGMENT_SHADER, fragment],
  ]) {
    const shader = gl.createShader(type);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost())
    throw new Error("This browser cannot draw the preview: its WebGL2 refuses a program.");
  const places = {};
  return { program, at: (name) => (places[name] ??= gl.getUniformLocation(program, name)) };
}

export class QuiltView {
  #canvas;
  #gl;
  #programs = {}; // made when they are first used
  #image; // { header, bitmap }
  #position = 0.5;
  #drawing = 0;
  #options = {
    mode: "view",
    apart: "eyes",
    zoom: 1,
    cone: 40,
    aspect: undefined,
    calibration: undefined,
  };
  #pan = [0.5, 0.5]; // the middle of what is shown of the panel, 0 to 1

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

  get mode() {
    return this.#options.mode;
  }

  /**
   * @param options any of: mode (stereo.js), apart (see viewsApart), zoom of the panel's pixels, cone
   * in degrees, aspect of the window (undefined: of a tile), calibration (device.calibration)
   */
  set(options) {
    const before = this.#options;
    this.#options = { ...before, ...options };
    if (Object.keys(options).some((key) => before[key] !== options[key])) this.#resize();
  }

  /** Moves the part of the panel that is shown, by pixels of the page. */
  pan(right, down) {
    const { screenW, screenH } = this.#options.calibration ?? {};
    if (!screenW) return;
    const by = devicePixelRatio / this.#options.zoom;
    const moved = [this.#pan[0] - (right * by) / screenW, this.#pan[1] - (down * by) / screenH];
    this.#pan = moved.map((value) => Math.min(Math.max(value, 0), 1));
    this.#draw();
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
    this.#programs = {};
    gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
    for (const side of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T])
      gl.texParameteri(gl.TEXTURE_2D, side, gl.CLAMP_TO_EDGE);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
  }

  #upload() {
    if (!this.#image) return;
    const gl = this.#gl;
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB8, gl.RGB, gl.UNSIGNED_BYTE, this.#image.bitmap);
    this.#draw();
  }

  // Width / height of what is drawn.
  #shape() {
    const { header } = this.#image,
      { mode } = this.#options;
    const aspect = this.#options.aspect ?? header.width / header.height;
    if (mode === "quilt") return (aspect * header.columns) / header.rows;
    return SHADER_MODES[mode] === 1 ? aspect * 2 : aspect;
  }

  // The largest canvas of the image's shape in the stage; of a panel, as much as there is room for.
  #resize() {
    if (!this.#image) return;
    const { clientWidth, clientHeight } = this.#canvas.parentElement;
    const { mode, calibration, zoom } = this.#options;
    let wide = clientWidth,
      high = clientHeight;
    if (mode === "panel" && calibration) {
      wide = Math.min(wide, (calibration.screenW * zoom) / devicePixelRatio);
      high = Math.min(high, (calibration.screenH * zoom) / devicePixelRatio);
    } else {
      const aspect = this.#shape();
      wide = Math.min(wide, high * aspect);
      high = wide / aspect;
    }
    this.#canvas.width = Math.max(1, Math.round(wide * devicePixelRatio));
    this.#canvas.height = Math.max(1, Math.round(high * devicePixelRatio));
    this.#canvas.style.width = `${this.#canvas.width / devicePixelRatio}px`;
    this.#canvas.style.height = `${this.#canvas.height / devicePixelRatio}px`;
    this.#draw();
  }

  #draw() {
    this.#drawing ||= requestAnimationFrame(() => {
      this.#drawing = 0;
      if (!this.#image) return;
      const gl = this.#gl,
        { mode, calibration } = this.#options;
      const panel = mode === "panel" && calibration;
      const { program, at } = panel
        ? (this.#programs.panel ??= link(gl, PANEL))
        : (this.#programs.eyes ??= link(gl, EYES));
      gl.useProgram(program);
      gl.viewport(0, 0, this.#canvas.width, this.#canvas.height);
      const { columns, rows, views, width, height } = this.#image.header;
      gl.uniform3i(at("layout_"), columns, rows, views);
      gl.uniform2f(at("tile"), width, height);
      if (panel) this.#setPanel(at);
      else this.#setEyes(at);
      gl.drawArrays(gl.TRIANGLES, 0, 3);
    });
  }

  #setEyes(at) {
    const gl = this.#gl,
      { mode, apart, cone } = this.#options,
      { views } = this.#image.header;
    const [left, right] = pairAt(this.#position, views, viewsApart(apart, views, cone));
    const one = viewAt(this.#position, views);
    if (mode === "crossed") gl.uniform2f(at("views"), right, left);
    else if (mode === "parallel" || mode === "anaglyph") gl.uniform2f(at("views"), left, right);
    else gl.uniform2f(at("views"), one, one);
    gl.uniform3f(at("red"), ...RED_OF_LEFT);
    gl.uniform1i(at("mode"), SHADER_MODES[mode] ?? 0);
  }

  #setPanel(at) {
    const gl = this.#gl,
      { calibration, aspect, zoom } = this.#options,
      { header } = this.#image;
    const lens = lensOf(calibration),
      { width, height } = this.#canvas;
    const first = [lens.width, lens.height].map((size, i) => {
      const shown = [width, height][i] / zoom;
      return Math.round(
        Math.min(Math.max(this.#pan[i] * size - shown / 2, 0), Math.max(size - shown, 0)),
      );
    });
    gl.uniform2i(at("panel"), lens.width, lens.height);
    gl.uniform2i(at("first"), ...first);
    gl.uniform2i(at("canvas"), width, height);
    gl.uniform1i(at("zoom"), zoom);
    gl.uniform4f(at("lens"), lens.pitch, lens.tilt, lens.center, lens.subpixel);
    gl.uniform4i(at("ways"), lens.fromRight ? 1 : 0, lens.red, lens.pattern, lens.cells.length);
    if (lens.cells.length) gl.uniform2fv(at("cells"), lens.cells.flat(2));
    gl.uniform2f(at("share"), ...shareOf(lens, aspect ?? header.width / header.height));
  }
}
