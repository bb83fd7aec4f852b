#!/usr/bin/env node
// Prints quiltd/methods.d.ts, the types of methods and notifications, from the answer of `hello`: make_types.js SOCKET
// `make docs` writes the file, and tests/types.test.js compares it.

import { fileURLToPath } from "node:url";

import { connect } from "./quiltd/node.js";

const PLAIN = { string: "string", integer: "number", number: "number", boolean: "boolean", null: "null" };

// A comment of one line.
function comment({ description, unit }) {
  const words = [description, unit && `[${unit}]`].filter(Boolean).join(" ");
  return words ? `/** ${words.replaceAll("*/", "* /")} */\n` : "";
}

const indent = (text) => text.replaceAll(/^(?=.)/gm, "  ");

// properties: all optional, except those that the schema requires.
function members({ properties = {}, required = [] }) {
  const shown = Object.entries(properties).filter(([, about]) => !about.deprecated);
  const line = ([name, about]) =>
    `${comment(about)}${JSON.stringify(name)}${required.includes(name) ? "" : "?"}: ${type(about)};\n`;
  return shown.map(line).join("");
}

function type(schema) {
  const one = (kind) => {
    if (kind === "array") return `${union(type(schema.items ?? {}))}[]`;
    if (kind !== "object") return PLAIN[kind] ?? "unknown";
    return schema.properties ? `{\n${indent(members(schema))}}` : "{ [key: string]: unknown }";
  };
  const words = schema.enum ?? schema.words;
  const kinds = [schema.type ?? []].flat().filter((kind) => kind !== "string" || !words);
  const all = [...(words ?? []).map((word) => JSON.stringify(word)), ...kinds.map(one)];
  return all.length > 0 ? all.join(" | ") : "unknown";
}

const union = (text) => (text.includes(" | ") ? `(${text})` : text);
const object = (schema) => (Object.keys(schema?.properties ?? {}).length > 0 ? `{\n${indent(members(schema))}}` : "{}");

// The text of methods.d.ts. info: the answer of `hello`.
export function types({ methods, events }) {
  const method = ([name, about]) =>
    `/** ${about.summary} */\n${JSON.stringify(name)}: {\n` +
    indent(`params: ${object(about.params)};\nresult: ${object(about.result)};\n`) + "};\n";
  const event = ([name, about]) => `/** ${about.summary} */\n${JSON.stringify(name)}: ${object(about.params)};\n`;
  const words = [...new Set(Object.values(events).map((about) => about.event))];
  return (
    "// Written by `make docs` from the answer of `hello`.\n\n" +
    `export interface Calls {\n${indent(Object.entries(methods).map(method).join(""))}}\n\n` +
    `export interface Notifications {\n${indent(Object.entries(events).map(event).join(""))}}\n\n` +
    `/** A word of subscribe. */\nexport type EventWord = ${words.map((word) => JSON.stringify(word)).join(" | ")};\n`
  );
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const q = await connect(process.argv[2]);
  process.stdout.write(types(q.info));
  q.close();
}
