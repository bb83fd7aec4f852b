// What a reload keeps. Browsers may forbid storage; the page then forgets.

/** @param session true: for this tab of the browser alone */
export function remember(key, value, session = false) {
  try {
    (session ? sessionStorage : localStorage).setItem(`quiltd.${key}`, JSON.stringify(value));
  } catch {
    // full or forbidden
  }
}

export function recall(key, usual, session = false) {
  try {
    const text = (session ? sessionStorage : localStorage).getItem(`quiltd.${key}`);
    return text === null ? usual : JSON.parse(text);
  } catch {
    return usual;
  }
}
