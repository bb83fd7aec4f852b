// Files of this computer, sent to the gateway, which hands them to quiltd.

import { safePath } from "./files.js";

export class Cancelled extends Error {}

/** The name of a file with its folders. */
export const nameOf = (file) => safePath(file.path ?? (file.webkitRelativePath || file.name));

// Why the gateway refused a request.
function reason(request) {
  const { response, status } = request;
  const said = response?.error?.message;
  if (said) return said;
  const words = {
    401: "this page has no token",
    404: "this quiltweb takes no files",
    413: "the file is too large for quiltweb",
    503: "quiltd does not answer",
    507: "quiltweb has no memory for it",
  };
  return words[status] ?? `quiltweb answered with ${status}`;
}

/**
 * Sends a body by PUT.
 * @param progress called with the bytes that were sent
 * @param signal an AbortSignal
 * @returns the answer, from JSON
 */
function put(path, body, progress, signal) {
  const request = new XMLHttpRequest();
  request.open("PUT", path);
  request.responseType = "json";
  request.upload.onprogress = ({ loaded }) => progress(loaded);
  const abort = () => request.abort();
  signal.addEventListener("abort", abort);
  return new Promise((resolve, reject) => {
    request.onload = () =>
      request.status < 300 ? resolve(request.response) : reject(new Error(reason(request)));
    request.onerror = () => reject(new Error("the connection to quiltweb ended"));
    request.onabort = () => reject(new Cancelled("cancelled"));
    request.send(body);
  }).finally(() => signal.removeEventListener("abort", abort));
}

/**
 * Sends files into one folder of the gateway.
 * @param progress called with 0 to 1
 * @returns their paths, in order
 */
export async function upload(files, progress, signal) {
  const all = files.reduce((sum, file) => sum + file.size, 0) || 1;
  const paths = [];
  let before = 0,
    folder;
  for (const file of files) {
    const query = new URLSearchParams({ name: nameOf(file) });
    if (folder) query.set("folder", folder);
    const answer = await put(
      `/api/upload?${query}`,
      file,
      (sent) => progress((before + sent) / all),
      signal,
    );
    folder = answer.folder;
    paths.push(answer.path);
    before += file.size;
  }
  return paths;
}

// The files below an entry of a drop, with their paths.
async function filesBelow(entry) {
  if (entry.isFile) {
    const file = await new Promise((resolve, reject) => entry.file(resolve, reject));
    return [Object.defineProperty(file, "path", { value: entry.fullPath })];
  }
  const reader = entry.createReader(),
    files = [];
  for (;;) {
    const some = await new Promise((resolve, reject) => reader.readEntries(resolve, reject));
    if (!some.length) return files;
    for (const one of some) files.push(...(await filesBelow(one)));
  }
}

/** The files of a drop, also those in its folders. */
export async function filesOf(transfer) {
  const entries = [...transfer.items].map((item) => item.webkitGetAsEntry?.()).filter(Boolean);
  if (!entries.length) return [...transfer.files];
  const files = [];
  for (const entry of entries) files.push(...(await filesBelow(entry)));
  return files;
}
