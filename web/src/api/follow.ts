/** Follows a job to its end, whatever happens to the connection on the way. */

import { call, job } from "./client";
import { patiently, pause } from "./patience";
import { EventParser, type ServerEvent } from "./sse";
import type { JobRecord, JobState, Progress } from "./types";

export interface Follower {
  /** The job as it is, at the beginning and whenever its state has changed. */
  record(record: JobRecord): void;
  progress(state: JobState, progress: Progress): void;
  /** Whether the server answers. */
  reachable: (is: boolean) => void;
}

const isFinal = (state: JobState): boolean => state !== "queued" && state !== "running";

/**
 * Resolves once the job has ended and the follower has its whole record, or nobody looks any more. Only what
 * becomes of a connection is tried again: what the follower throws is thrown.
 */
export async function follow(id: string, follower: Follower, signal: AbortSignal): Promise<void> {
  let last = "";
  for (;;) {
    const record = await patiently(() => job(id, signal), signal, follower.reachable);
    if (record === null) {
      return;
    }
    follower.record(record);
    if (isFinal(record.state)) {
      return;
    }
    let ended = false;
    for await (const event of events(id, last, signal)) {
      last = event.id;
      ended = event.event === "end";
      if (event.event === "progress") {
        const told = JSON.parse(event.data) as { state: JobState; progress?: Progress };
        if (told.progress !== undefined) {
          follower.progress(told.state, told.progress);
        }
      }
    }
    if (!ended) {
      await pause();
    }
  }
}

/** What a stream tells, up to the end of the job or of the connection. */
async function* events(id: string, last: string, signal: AbortSignal): AsyncGenerator<ServerEvent> {
  const headers: Record<string, string> = { Accept: "text/event-stream" };
  if (last !== "") {
    headers["Last-Event-ID"] = last;
  }
  // A browser has few connections to a server: a page that nobody looks at keeps none.
  const closed = new AbortController();
  const look = (): void => {
    if (document.hidden) {
      closed.abort();
    }
  };
  document.addEventListener("visibilitychange", look, { signal: closed.signal });
  const parser = new EventParser();
  try {
    const reader = await opened(id, headers, AbortSignal.any([signal, closed.signal]));
    for (let text = await piece(reader); text !== null; text = await piece(reader)) {
      for (const event of parser.push(text)) {
        yield event;
        if (event.event === "end") {
          return;
        }
      }
    }
  } finally {
    closed.abort();
  }
}

type TextReader = ReadableStreamDefaultReader<string>;

/** A stream of events; nothing where it cannot be had: the job itself then tells why. */
async function opened(
  id: string,
  headers: Record<string, string>,
  signal: AbortSignal,
): Promise<TextReader | null> {
  try {
    const response = await call(`/jobs/${encodeURIComponent(id)}/events`, { headers, signal });
    return response.body?.pipeThrough(new TextDecoderStream()).getReader() ?? null;
  } catch {
    return null;
  }
}

/** The next of a stream; nothing after its end, however it ended. */
async function piece(reader: TextReader | null): Promise<string | null> {
  try {
    const next = await reader?.read();
    return next?.value ?? null;
  } catch {
    return null;
  }
}
