// The pictures of the preview. The texture is a quilt with view 0 at the bottom left.

export const VERTEX = `#version 300 es
out vec2 at;
void main() {
  at = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2);
  gl_Position = vec4(at * 2.0 - 1.0, 0.0, 1.0);
}`;

/** Views for one or two eyes, or the whole quilt. */
export const EYES = `#version 300 es
precision highp float;
uniform sampler2D quilt;
uniform ivec3 layout_; // columns, rows, views
uniform vec2 tile;     // pixels of a view
uniform vec2 views;    // of the left half or eye, and of the right one: 0 to views - 1
uniform vec3 red;      // what the left eye gives to red
uniform int mode;      // 0: one view, 1: side by side, 2: red and cyan, 3: the quilt
in vec2 at;
out vec4 colour;
vec3 look(int i, vec2 where) {
  vec2 origin = vec2(i % layout_.x, i / layout_.x) * tile;
  // half a pixel inside: nothing of the next view is mixed in
  vec2 inside = clamp(where * tile, vec2(0.5), tile - 0.5);
  return texture(quilt, (origin + inside) / (vec2(layout_.xy) * tile)).rgb;
}
vec3 between(float view, vec2 where) {
  int i = int(floor(view)), next = min(i + 1, layout_.z - 1);
  return mix(look(i, where), look(next, where), fract(view));
}
void main() {
  vec3 c;
  if (mode == 1) {
    bool right = at.x >= 0.5;
    c = between(right ? views.y : views.x, vec2(fract(at.x * 2.0), at.y));
  } else if (mode == 2) {
    vec3 left = between(views.x, at), other = between(views.y, at);
    c = vec3(dot(left, red), other.gb);
  } else if (mode == 3) {
    c = texture(quilt, at).rgb;
  } else {
    c = between(views.x, at);
  }
  colour = vec4(c, 1.0);
}`;

/** The pixels of a panel: the formulas of lens.js. */
export const PANEL = `#version 300 es
precision highp float;
uniform sampler2D quilt;
uniform ivec3 layout_;
uniform vec2 tile;
uniform ivec2 panel;   // pixels of the panel
uniform ivec2 first;   // the panel pixel at the top left
uniform ivec2 canvas;  // pixels of the canvas
uniform int zoom;      // canvas pixels per panel pixel
uniform vec4 lens;     // pitch, tilt, center, width of a subpixel
uniform ivec4 ways;    // 1: views from the right; place of red; pattern of cells; number of cells
uniform vec2 cells[48];
uniform vec2 share;    // of the panel that the views cover
out vec4 colour;
int cellOf(ivec2 p) {
  int n = ways.z == 1 ? (p.x + p.y) % 2 : ways.z == 2 ? p.x % 2
        : ways.z == 3 ? (p.y + 2 * (p.x % 2)) % 4 : ways.z == 4 ? p.y % 2 : 0;
  return ways.w > 0 ? n % ways.w : 0;
}
int viewOf(ivec2 p, int c) {
  vec2 uv = (vec2(p) + 0.5) / vec2(panel);
  if (ways.w > 0) uv += cells[cellOf(p) * 3 + c] / vec2(panel);
  else uv.x += float(c == 1 ? 1 : c == 0 ? ways.y : 2 - ways.y) * lens.w;
  float f = fract((uv.x + uv.y * lens.y) * lens.x - lens.z);
  float z = clamp(ways.x == 1 ? 1.0 - f : f, 1e-5, 0.999999);
  return min(int(z * float(layout_.z)), layout_.z - 1);
}
void main() {
  ivec2 here = ivec2(gl_FragCoord.xy);
  ivec2 p = first + ivec2(here.x, canvas.y - 1 - here.y) / zoom; // rows from the top
  vec2 of = ((vec2(p) + 0.5) / vec2(panel) - 0.5) / share + 0.5;
  if (p.x >= panel.x || p.y >= panel.y || any(lessThan(of, vec2(0.0))) || any(greaterThanEqual(of, vec2(1.0)))) {
    colour = vec4(0.0, 0.0, 0.0, 1.0);
    return;
  }
  ivec2 size = ivec2(tile), inside = ivec2(of * tile);
  inside.y = size.y - 1 - inside.y;
  ivec2 below = ivec2(p.x, panel.y - 1 - p.y); // rows from the bottom
  vec3 channels;
  for (int c = 0; c < 3; c++) {
    int i = viewOf(below, c);
    channels[c] = texelFetch(quilt, ivec2(i % layout_.x, i / layout_.x) * size + inside, 0)[c];
  }
  colour = vec4(channels, 1.0);
}`;
