/** Repeats calls after broken connections and passing failures of the server. */

import { Problem } from "./client";

/** Pause before the next try after a broken connection, in milliseconds. */
const PAUSE = 1000;
/** No connection (0), or what a proxy answers while the service itself cannot be reached. */
const UNREACHABLE = [0, 502, 503, 504];
/** Statuses below 500 after which another try may succeed: too slow, too early, too often. */
const TEMPORARY = [408, 425, 429];
/** After how many failures of the service the call is given up. */
const MAX_FAILURES = 5;

/**
 * Calls `ask` until it succeeds and returns its answer, or `null` once `signal` is aborted. Problems that another try
 * cannot solve are thrown. Nothing is sent while the page is hidden. `reachable` is called after every try with whether
 * the server could be reached.
 */
export async function retry<T>(
  ask: () => Promise<T>,
  signal: AbortSignal,
  reachable: (is: boolean) => void,
): Promise<T | null> {
  const isAborted = (): boolean => signal.aborted;
  for (let failures = 0; ;) {
    await visible(signal);
    if (isAborted()) {
      return null;
    }
    let problem;
    try {
      const answer = await ask();
      if (!isAborted()) {
        reachable(true);
        return answer;
      }
    } catch (error) {
      problem = error;
    }
    if (isAborted()) {
      return null;
    }
    if (!(problem instanceof Problem)) {
      throw problem;
    }
    const { status } = problem;
    const isUnreachable = UNREACHABLE.includes(status);
    reachable(!isUnreachable);
    if (isUnreachable) {
      await pause();
      continue;
    }
    failures += 1;
    if ((status < 500 && !TEMPORARY.includes(status)) || failures >= MAX_FAILURES) {
      throw problem;
    }
    await pause(PAUSE * 2 ** failures);
  }
}

export const pause = (time = PAUSE): Promise<void> =>
  new Promise((resolve) => setTimeout(resolve, time));

/** Resolves once the page is visible, or `signal` is aborted. */
function visible(signal: AbortSignal): Promise<void> {
  return new Promise((resolve) => {
    const done = new AbortController();
    const check = (): void => {
      if (!document.hidden || signal.aborted) {
        done.abort();
        resolve();
      }
    };
    document.addEventListener("visibilitychange", check, { signal: done.signal });
    signal.addEventListener("abort", check, { signal: done.signal });
    check();
  });
}
