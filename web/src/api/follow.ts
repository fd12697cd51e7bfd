/** Follows a job to its end, across broken connections and restarts of the server. */

import { call, job } from "./client";
import { retry, pause } from "./retry";
import { EventParser, type ServerEvent } from "./sse";
import type { JobRecord, JobState, Progress } from "./types";

export interface Follower {
  /** Called with the job first, and again whenever the stream has ended. */
  record(record: JobRecord): void;
  progress(state: JobState, progress: Progress): void;
  /** Called with whether the server answers. */
  reachable: (is: boolean) => void;
}

const isFinal = (state: JobState): boolean => state !== "queued" && state !== "running";

/**
 * Resolves once the job has ended and the follower has its final record, or once `signal` is aborted. Only failures of
 * the connection are retried: what the follower throws is thrown.
 */
export async function follow(id: string, follower: Follower, signal: AbortSignal): Promise<void> {
  let last = "";
  for (;;) {
    const record = await retry(() => job(id, signal), signal, follower.reachable);
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
        const update = JSON.parse(event.data) as { state: JobState; progress?: Progress };
        if (update.progress !== undefined) {
          follower.progress(update.state, update.progress);
        }
      }
    }
    if (!ended) {
      await pause();
    }
  }
}

/** The events of one stream, up to the end of the job or of the connection. */
async function* events(id: string, last: string, signal: AbortSignal): AsyncGenerator<ServerEvent> {
  const headers: Record<string, string> = { Accept: "text/event-stream" };
  if (last !== "") {
    headers["Last-Event-ID"] = last;
  }
  // A browser opens few connections to one server, so a hidden page must not hold one.
  const closed = new AbortController();
  const closeIfHidden = (): void => {
    if (document.hidden) {
      closed.abort();
    }
  };
  document.addEventListener("visibilitychange", closeIfHidden, { signal: closed.signal });
  const parser = new EventParser();
  try {
    const reader = await openStream(id, headers, AbortSignal.any([signal, closed.signal]));
    for (let text = await nextChunk(reader); text !== null; text = await nextChunk(reader)) {
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

/** Opens the stream of events, or returns `null` if that fails: the next request for the job then shows the reason. */
async function openStream(
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

/** The next chunk of the stream, or `null` after its end, however it ended. */
async function nextChunk(reader: TextReader | null): Promise<string | null> {
  try {
    const next = await reader?.read();
    return next?.value ?? null;
  } catch {
    return null;
  }
}
