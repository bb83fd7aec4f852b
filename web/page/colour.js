// Linear Rec. 709 colours and the codes of sRGB.

const encode = (x) => (x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055);
const decode = (x) => (x <= 0.04045 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4);
const clamp = (x) => Math.min(Math.max(x, 0), 1);

/** "#rrggbb" of a linear colour; what is above 1 is cut off. */
export function hexOf(colour) {
  const byte = (x) =>
    Math.round(encode(clamp(x)) * 255)
      .toString(16)
      .padStart(2, "0");
  return "#" + colour.map(byte).join("");
}

/** [r, g, b], linear, of "#rrggbb". */
export function linearOf(hex) {
  return [1, 3, 5].map((i) => decode(parseInt(hex.slice(i, i + 2), 16) / 255));
}

/**
 * A colour as a hue for a colour field and a strength, which may be above 1.
 * @param value a number (grey) or [r, g, b]
 */
export function splitColour(value) {
  const colour = Array.isArray(value) ? value : [value, value, value];
  const strength = Math.max(...colour);
  return { strength, hex: hexOf(colour.map((x) => (strength > 0 ? x / strength : 1))) };
}

/** The same hue with another strength. */
export function withStrength(value, strength) {
  if (!Array.isArray(value)) return strength;
  const old = Math.max(...value);
  return value.map((x) => (old > 0 ? (x / old) * strength : strength));
}
