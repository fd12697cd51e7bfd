/** Follows a job to its end, whatever happens to the connection on the way. */

import { call, job, Problem } from "./client";
import { EventParser } from "./sse";
import type { JobRecord, JobState, Progress } from "./types";

/** Pause before a connection that broke is made again, in milliseconds. */
const PAUSE = 1000;

export interface Follower {
  /** The job as it is, at the beginning and whenever its state has changed. */
  record(record: JobRecord): void;
  progress(state: JobState, progress: Progress): void;
  /** Whether the server answers. */
  reachable(is: boolean): void;
}

const isFinal = (state: JobState): boolean => state !== "queued" && state !== "running";

/** Resolves once the job has ended and the follower has its whole record. */
export async function follow(id: string, follower: Follower, signal: AbortSignal): Promise<void> {
  let last = "";
  for (;;) {
    try {
      await seen(signal);
      const record = await job(id, signal);
      follower.reachable(true);
      follower.record(record);
      if (isFinal(record.state) || signal.aborted) {
        return;
      }
      last = await listen(id, last, follower, signal);
    } catch (error) {
      if (signal.aborted) {
        return;
      }
      // Gone, or not for this reader: no other try will do better.
      if (error instanceof Problem && [401, 403, 404, 410].includes(error.status)) {
        throw error;
      }
      follower.reachable(!(error instanceof Problem) || error.status !== 0);
      await new Promise((resolve) => setTimeout(resolve, PAUSE));
    }
  }
}

/** Until the stream ends; gives the id of the last event. */
async function listen(
  id: string,
  last: string,
  follower: Follower,
  signal: AbortSignal,
): Promise<string> {
  const headers: Record<string, string> = { Accept: "text/event-stream" };
  if (last !== "") {
    headers["Last-Event-ID"] = last;
  }
  // A browser has few connections to a server: a page that nobody looks at keeps none.
  const hidden = new AbortController();
  const look = (): void => {
    if (document.hidden) {
      hidden.abort();
    }
  };
  document.addEventListener("visibilitychange", look, { signal: hidden.signal });
  try {
    return await read(id, last, headers, follower, AbortSignal.any([signal, hidden.signal]));
  } finally {
    hidden.abort();
  }
}

/** Until somebody looks at the page. */
function seen(signal: AbortSignal): Promise<void> {
  return new Promise((resolve) => {
    const look = (): void => {
      if (!document.hidden || signal.aborted) {
        document.removeEventListener("visibilitychange", look);
        resolve();
      }
    };
    document.addEventListener("visibilitychange", look);
    signal.addEventListener("abort", look, { once: true });
    look();
  });
}

async function read(
  id: string,
  last: string,
  headers: Record<string, string>,
  follower: Follower,
  signal: AbortSignal,
): Promise<string> {
  const response = await call(`/jobs/${encodeURIComponent(id)}/events`, { headers, signal });
  const reader = response.body?.pipeThrough(new TextDecoderStream()).getReader();
  if (reader === undefined) {
    return last;
  }
  const parser = new EventParser();
  for (;;) {
    const { done, value } = await reader.read();
    if (done) {
      return last;
    }
    for (const event of parser.push(value)) {
      last = event.id;
      if (event.event === "progress") {
        const told = JSON.parse(event.data) as { state: JobState; progress?: Progress };
        if (told.progress !== undefined) {
          follower.progress(told.state, told.progress);
        }
      } else if (event.event === "end") {
        return last;
      }
    }
  }
}
