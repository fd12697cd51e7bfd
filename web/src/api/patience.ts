/** Asking again where a connection broke or a server was not ready. */

import { Problem } from "./client";

/** Time between two tries, in milliseconds. */
const PAUSE = 1000;
/** Answers below 500 that another try may better: too slow, too early, too often. */
const PASSING = [408, 425, 429];

/**
 * What an answer brings, as soon as there is one; nothing when nobody looks any more. What no other try will
 * better is thrown. `reachable` is told whether the server answers at all.
 */
export async function patiently<T>(
  ask: () => Promise<T>,
  signal: AbortSignal,
  reachable: (is: boolean) => void = () => undefined,
): Promise<T | null> {
  for (;;) {
    let problem;
    await seen(signal);
    try {
      const answer = await ask();
      if (signal.aborted) {
        return null;
      }
      reachable(true);
      return answer;
    } catch (error) {
      if (signal.aborted) {
        return null;
      }
      problem = error;
    }
    if (!(problem instanceof Problem)) {
      throw problem;
    }
    const { status } = problem;
    reachable(status !== 0);
    if (status !== 0 && status < 500 && !PASSING.includes(status)) {
      throw problem;
    }
    await pause();
  }
}

export const pause = (): Promise<void> => new Promise((resolve) => setTimeout(resolve, PAUSE));

/** Until somebody looks at the page, or nobody ever will. */
function seen(signal: AbortSignal): Promise<void> {
  return new Promise((resolve) => {
    const over = new AbortController();
    const look = (): void => {
      if (!document.hidden || signal.aborted) {
        over.abort();
        resolve();
      }
    };
    document.addEventListener("visibilitychange", look, { signal: over.signal });
    signal.addEventListener("abort", look, { signal: over.signal });
    look();
  });
}
