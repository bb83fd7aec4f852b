// Reads the JSON Schema of scenes: which fields a value has, and how a person changes them.

import { same } from "./patch.js";

const isObject = (value) => value !== null && typeof value === "object" && !Array.isArray(value);
const COLOURS = ["#/$defs/radiance", "#/$defs/unit_colour"];

/** The schema without a $ref. Keys next to the $ref win. A colour is marked as such. */
export function resolve(root, schema) {
  let result = schema;
  for (let i = 0; result.$ref && i < 16; i++) {
    const { $ref, ...own } = result;
    const from = $ref
      .slice(2)
      .split("/")
      .reduce((at, key) => at[key], root);
    result = { ...from, ...own };
    if (COLOURS.includes($ref)) result.colour = true;
  }
  return result;
}

/** All alternatives of a schema, without anyOf. They inherit what is said around them. */
export function variants(root, schema) {
  const { anyOf, ...own } = resolve(root, schema);
  if (!anyOf) return [own];
  const inherited = Object.fromEntries(
    ["description", "unit", "default", "colour"]
      .filter((key) => key in own)
      .map((key) => [key, own[key]]),
  );
  return anyOf.flatMap((one) => variants(root, one)).map((one) => ({ ...one, ...inherited }));
}

const typeOf = (value) => (value === null ? "null" : Array.isArray(value) ? "array" : typeof value);

function fitsType(type, value) {
  return type === "integer"
    ? Number.isInteger(value)
    : type === undefined || type === typeOf(value);
}

function fitsObject(root, schema, value) {
  return (
    (schema.required ?? []).every((key) => key in value) &&
    Object.entries(value).every(([key, inner]) => {
      const property = schema.properties?.[key] ?? schema.additionalProperties;
      if (property === undefined) return true;
      return property && (typeof property !== "object" || fits(root, property, inner));
    })
  );
}

/** Whether the value is of this schema, except for patterns and lengths of text. */
export function fits(root, schema, value) {
  return variants(root, schema).some((one) => {
    if ("const" in one) return same(one.const, value);
    if (one.enum) return one.enum.includes(value);
    if (!fitsType(one.type, value)) return false;
    if (typeof value === "number")
      return value >= (one.minimum ?? value) && value <= (one.maximum ?? value);
    if (Array.isArray(value))
      return (
        value.length >= (one.minItems ?? 0) &&
        value.length <= (one.maxItems ?? Infinity) &&
        value.every((item) => !one.items || fits(root, one.items, item))
      );
    return isObject(value) ? fitsObject(root, one, value) : true;
  });
}

// Of several that do not fit, the one that knows most of the value's keys.
function likeness(schema, value) {
  if (!isObject(value)) return 0;
  if (schema.type !== "object") return -1;
  return Object.keys(value).filter((key) => key in (schema.properties ?? {})).length;
}

/** The alternative that a value is of. */
export function pick(root, schema, value) {
  const all = variants(root, schema);
  const best = (a, b) => (likeness(b, value) > likeness(a, value) ? b : a);
  return all.find((one) => fits(root, one, value)) ?? all.reduce(best);
}

/** What a person reads about a key: meaning, range and usual value. */
export function describe(root, schema) {
  const { description = "", unit, default: usual } = resolve(root, schema);
  const number = variants(root, schema).find(
    (one) => one.type === "number" || one.type === "integer",
  );
  const words = [description];
  if (number?.minimum !== undefined && number.maximum !== undefined)
    words.push(`${number.minimum} to ${number.maximum}`);
  if (unit) words.push(unit);
  if (usual !== undefined) words.push(`usually ${JSON.stringify(usual)}`);
  return words.filter(Boolean).join("; ");
}

/** The allowed words of a key in all alternatives of an object, such as the types of lights. */
export function choicesOf(root, schema, key) {
  const words = [];
  for (const one of variants(root, schema))
    for (const inner of one.properties?.[key] ? variants(root, one.properties[key]) : [])
      words.push(...("const" in inner ? [inner.const] : (inner.enum ?? [])));
  return [...new Set(words)];
}

/** The keys of an object's alternative, with their schemas; former names are left out. */
export function propertiesOf(schema) {
  return Object.entries(schema.properties ?? {}).filter(([, one]) => one && !one.deprecated);
}

/** A small valid value, or undefined if only a person knows one, such as a file. */
export function sample(root, schema) {
  for (const one of variants(root, schema)) {
    const value = sampleOf(root, one);
    if (value !== undefined) return value;
  }
  return undefined;
}

function sampleOf(root, schema) {
  if ("default" in schema && fits(root, schema, schema.default)) return schema.default;
  if ("const" in schema) return schema.const;
  if (schema.enum) return schema.enum[0];
  if (schema.type === "boolean") return true;
  if (schema.type === "number" || schema.type === "integer")
    return Math.min(Math.max(schema.colour ? 1 : 0, schema.minimum ?? 0), schema.maximum ?? 1);
  if (schema.type === "array") return sampleArray(root, schema);
  if (schema.type === "object") return sampleObject(root, schema);
  return undefined;
}

function sampleArray(root, schema) {
  const item = schema.items && sample(root, schema.items);
  return item === undefined ? undefined : Array(schema.minItems ?? 0).fill(item);
}

function sampleObject(root, schema) {
  const result = {};
  for (const key of schema.required ?? []) {
    result[key] = sample(root, schema.properties[key]);
    if (result[key] === undefined) return undefined;
  }
  return result;
}

/** The object with another word at a key, such as `type`: keys that the new kind has are kept. */
export function retyped(root, schema, value, key, word) {
  const allows = (one) => one.properties?.[key] && fits(root, one.properties[key], word);
  for (const one of variants(root, schema).filter(allows)) {
    const kept = Object.entries(value).filter(
      ([name, inner]) =>
        name !== key && one.properties[name] && fits(root, one.properties[name], inner),
    );
    const needed = sampleObject(root, {
      ...one,
      required: (one.required ?? []).filter((name) => name !== key),
    });
    if (needed) return { [key]: word, ...needed, ...Object.fromEntries(kept) };
  }
  return undefined;
}

/** The kind of field for a value: number, vector, colour, choice, switch, text, object or json. */
export function fieldOf(root, schema, value) {
  const one = pick(root, schema, value);
  const words = variants(root, schema).flatMap((each) => each.enum ?? []);
  if (isObject(value)) return one.type === "object" ? "object" : "json";
  if (typeof value === "boolean") return "switch";
  if (words.includes(value)) return "choice";
  if (typeof value === "string") return "text";
  const colour = variants(root, schema).some((each) => each.colour);
  if (colour && (typeof value === "number" || value?.length === 3)) return "colour";
  if (typeof value === "number") return "number";
  const numbers =
    Array.isArray(value) && value.length <= 4 && value.every((x) => typeof x === "number");
  return numbers ? "vector" : "json";
}

/** Minimum, maximum, integer and unit of the numbers of a value. */
export function rangeOf(root, schema) {
  const { unit } = resolve(root, schema);
  for (const one of variants(root, schema)) {
    const number = one.type === "array" && one.items ? resolve(root, one.items) : one;
    if (number.type === "number" || number.type === "integer")
      return {
        minimum: number.minimum,
        maximum: number.maximum,
        integer: number.type === "integer",
        unit,
      };
  }
  return {};
}
