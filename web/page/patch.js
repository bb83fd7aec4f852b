// JSON Merge Patches (RFC 7396). Values are not changed; results may share parts of them.

const isObject = (value) => value !== null && typeof value === "object" && !Array.isArray(value);
const has = (object, key) => Object.hasOwn(object, key);
// also for the key __proto__, which an assignment would not set
const put = (object, key, value) =>
  Object.defineProperty(object, key, {
    value,
    writable: true,
    enumerable: true,
    configurable: true,
  });

export function same(a, b) {
  if (Array.isArray(a))
    return Array.isArray(b) && a.length === b.length && a.every((value, i) => same(value, b[i]));
  if (!isObject(a) || !isObject(b)) return a === b;
  const keys = Object.keys(a);
  return (
    keys.length === Object.keys(b).length &&
    keys.every((key) => has(b, key) && same(a[key], b[key]))
  );
}

/** The document after the patch. */
export function merge(document, patch) {
  if (!isObject(patch)) return patch;
  const result = isObject(document) ? { ...document } : {};
  for (const [key, value] of Object.entries(patch)) {
    if (value === null) delete result[key];
    else put(result, key, merge(has(result, key) ? result[key] : undefined, value));
  }
  return result;
}

/** The patch that makes `document` of merge(document, patch). */
export function inverse(document, patch) {
  const result = {};
  for (const [key, value] of Object.entries(patch)) {
    const old = isObject(document) && has(document, key) ? document[key] : undefined;
    if (old === undefined) put(result, key, null);
    else put(result, key, inverseOfValue(old, value));
  }
  return result;
}

function inverseOfValue(old, value) {
  if (isObject(old) && isObject(value)) return inverse(old, value);
  return old;
}

/** The patch that makes `to` of `from`; {} if they are the same. Both are objects. */
export function difference(from, to) {
  const result = {};
  for (const key of Object.keys(from)) if (!has(to, key)) put(result, key, null);
  for (const [key, value] of Object.entries(to)) {
    const old = has(from, key) ? from[key] : undefined;
    if (isObject(old) && isObject(value)) {
      const inner = difference(old, value);
      if (Object.keys(inner).length) put(result, key, inner);
    } else if (!same(old, value)) put(result, key, value);
  }
  return result;
}

/** The patch that sets the value at a path of keys. */
export function patchAt(path, value) {
  return path.reduceRight((inner, key) => put({}, key, inner), value);
}

export function valueAt(document, path) {
  let value = document;
  for (const key of path) value = value != null && has(Object(value), key) ? value[key] : undefined;
  return value;
}
