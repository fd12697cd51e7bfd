/** Asking again where a connection broke or a server was not ready. */

import { Problem } from "./client";

/** Time between two tries of a connection that broke, in milliseconds. */
const PAUSE = 1000;
/** Answers of someone in between, while the service itself is away. */
const AWAY = [0, 502, 503, 504];
/** Answers below 500 that another try may better: too slow, too early, too often. */
const PASSING = [408, 425, 429];
/** How often in a row the service may fail. */
const FAULTS = 5;

/**
 * What an answer brings, as soon as there is one; nothing when nobody looks any more. What no other try will
 * better is thrown. `reachable` is told whether the server answers at all.
 */
export async function patiently<T>(
  ask: () => Promise<T>,
  signal: AbortSignal,
  reachable: (is: boolean) => void,
): Promise<T | null> {
  const isOver = (): boolean => signal.aborted;
  for (let faults = 0; ;) {
    await seen(signal);
    if (isOver()) {
      return null;
    }
    let problem;
    try {
      const answer = await ask();
      if (!isOver()) {
        reachable(true);
        return answer;
      }
    } catch (error) {
      problem = error;
    }
    if (isOver()) {
      return null;
    }
    if (!(problem instanceof Problem)) {
      throw problem;
    }
    const { status } = problem;
    const isAway = AWAY.includes(status);
    reachable(!isAway);
    if (isAway) {
      await pause();
      continue;
    }
    faults += 1;
    if ((status < 500 && !PASSING.includes(status)) || faults >= FAULTS) {
      throw problem;
    }
    await pause(PAUSE * 2 ** faults);
  }
}

export const pause = (time = PAUSE): Promise<void> =>
  new Promise((resolve) => setTimeout(resolve, time));

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
