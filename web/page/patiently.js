// Requests to a quiltweb that has no room for them now: it answers 503.

const WAITS_MS = [500, 1500, 4000, 9000];

/**
 * Asks again while the answer is 503, after longer and longer waits.
 * @param ask returns a promise of a Response
 * @param wait as setTimeout of a promise, for tests
 * @returns a Blob; undefined: refused
 */
export async function patiently(ask, wait = (ms) => new Promise((done) => setTimeout(done, ms))) {
  for (const ms of [...WAITS_MS, undefined]) {
    const answer = await ask();
    if (answer.ok) return answer.blob();
    if (answer.status !== 503 || ms === undefined) return undefined;
    await wait(ms);
  }
}
