/**
 * Calls one at a time. What is asked for meanwhile is merged, so that the last value of each key wins.
 * @param call takes an object and returns a promise that does not fail
 */
export function latest(call) {
  let busy = false,
    next;
  return async (params) => {
    next = { ...next, ...params };
    if (busy) return;
    busy = true;
    while (next) {
      const now = next;
      next = undefined;
      await call(now);
    }
    busy = false;
  };
}
