import { afterEach, beforeEach, expect, test, vi } from "vitest";

import { follow } from "./follow";

/** The answers for each path, in order; anything but a response stands for a connection that breaks. */
let answers: Record<string, (() => unknown)[]>;
let requested: string[];
let page: EventTarget & { hidden: boolean };

const json =
  (body: unknown, status = 200) =>
  () =>
    new Response(JSON.stringify(body), { status });
const stream =
  (...pieces: (string | Error)[]) =>
  () =>
    new Response(
      new ReadableStream({
        pull: (controller) => {
          const piece = pieces.shift();
          if (piece === undefined) {
            controller.close();
          } else if (piece instanceof Error) {
            controller.error(piece);
          } else {
            controller.enqueue(new TextEncoder().encode(piece));
          }
        },
      }),
    );
const progress = (id: number): string =>
  `id: ${id}\nevent: progress\ndata: {"state":"running","progress":{"generation":${id}}}\n\n`;
const END = "id: 99\nevent: end\ndata: {}\n\n";
const RUNNING = { id: "j", state: "running" };
const DONE = { id: "j", state: "succeeded" };

/** A follower that records its calls in order. */
function recorder() {
  const calls: string[] = [];
  return {
    calls,
    record: (record: { state: string }) => void calls.push(record.state),
    progress: (_: string, progress: { generation: number }) =>
      void calls.push(`generation ${progress.generation}`),
    reachable: (is: boolean) => void calls.push(is ? "reachable" : "unreachable"),
  };
}

beforeEach(() => {
  vi.useFakeTimers({ toFake: ["setTimeout"] });
  requested = [];
  page = Object.assign(new EventTarget(), { hidden: false });
  vi.stubGlobal("document", page);
  vi.stubGlobal("fetch", (path: string, init: RequestInit = {}) => {
    requested.push(path);
    init.signal?.throwIfAborted();
    const answer = answers[path]?.shift()?.();
    return answer instanceof Response
      ? Promise.resolve(answer)
      : Promise.reject(new TypeError("no connection"));
  });
});
afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

/** Follows to the end with fake timers, so that pauses take no time. */
async function run(follower: ReturnType<typeof recorder>, signal = new AbortController().signal) {
  const end = follow("j", follower, signal);
  const seen = { over: false };
  const mark = (): void => {
    seen.over = true;
  };
  end.then(mark, mark);
  while (!seen.over) {
    await vi.advanceTimersByTimeAsync(1000);
    await new Promise((later) => setImmediate(later));
  }
  return end;
}

test("a job is followed across breaks of the connection and of the stream", async () => {
  answers = {
    "/jobs/j": [() => null, json(RUNNING), json(RUNNING), json(DONE)],
    "/jobs/j/events": [stream(progress(1), new Error("broken")), stream(progress(2), END)],
  };
  const follower = recorder();
  await run(follower);
  expect(follower.calls).toEqual([
    "unreachable",
    "reachable",
    "running",
    "generation 1",
    "reachable",
    "running",
    "generation 2",
    "reachable",
    "succeeded",
  ]);
});

test("a stream that cannot be opened is requested once per pause", async () => {
  answers = {
    "/jobs/j": [json(RUNNING), json(RUNNING), json(DONE)],
    "/jobs/j/events": [json({ title: "Busy", detail: "later" }, 503), () => null],
  };
  await run(recorder());
  expect(requested).toEqual(["/jobs/j", "/jobs/j/events", "/jobs/j", "/jobs/j/events", "/jobs/j"]);
});

test("an error that the follower throws is not retried", async () => {
  answers = { "/jobs/j": [json(DONE), json(DONE)] };
  const broken = { ...recorder(), record: () => expect.fail("an error of the view") };
  await expect(run(broken)).rejects.toThrow("an error of the view");
  answers = { "/jobs/j": [json(RUNNING)], "/jobs/j/events": [stream(progress(1))] };
  const later = { ...recorder(), progress: () => expect.fail("another") };
  await expect(run(later)).rejects.toThrow("another");
  expect(requested).toEqual(["/jobs/j", "/jobs/j", "/jobs/j/events"]);
});

test("following a deleted job ends with the message of the service", async () => {
  answers = { "/jobs/j": [json({ title: "Gone", detail: "it has expired", status: 410 }, 410)] };
  await expect(run(recorder())).rejects.toThrow("it has expired");
});

test("a follower is not called after its signal was aborted", async () => {
  const gone = new AbortController();
  answers = {
    "/jobs/j": [
      () => {
        gone.abort();
        return json(RUNNING)();
      },
    ],
  };
  const follower = recorder();
  await run(follower, gone.signal);
  expect(follower.calls).toEqual([]);
});

test("a hidden page sends no request until it is visible", async () => {
  page.hidden = true;
  answers = { "/jobs/j": [json(DONE)] };
  const follower = recorder();
  const end = run(follower);
  await vi.advanceTimersByTimeAsync(10_000);
  expect(requested).toEqual([]);
  page.hidden = false;
  page.dispatchEvent(new Event("visibilitychange"));
  await end;
  expect(follower.calls).toEqual(["reachable", "succeeded"]);
});
