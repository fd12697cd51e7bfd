import { afterEach, beforeEach, expect, test, vi } from "vitest";

import { follow } from "./follow";

/** Answers by path, one after the other; what is not a response is thrown, as a connection that breaks. */
let answers: Record<string, (() => unknown)[]>;
let asked: string[];
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

/** What a follower was told, in order. */
function follower() {
  const told: string[] = [];
  return {
    told,
    record: (record: { state: string }) => void told.push(record.state),
    progress: (_: string, progress: { generation: number }) =>
      void told.push(`generation ${progress.generation}`),
    reachable: (is: boolean) => void told.push(is ? "there" : "away"),
  };
}

beforeEach(() => {
  vi.useFakeTimers({ toFake: ["setTimeout"] });
  asked = [];
  page = Object.assign(new EventTarget(), { hidden: false });
  vi.stubGlobal("document", page);
  vi.stubGlobal("fetch", (path: string, init: RequestInit = {}) => {
    asked.push(path);
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

/** Follows to the end, with no time lost in pauses. */
async function run(told: ReturnType<typeof follower>, signal = new AbortController().signal) {
  const end = follow("j", told, signal);
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

test("a job is followed over breaks of the connection and of the stream", async () => {
  answers = {
    "/jobs/j": [() => null, json(RUNNING), json(RUNNING), json(DONE)],
    "/jobs/j/events": [stream(progress(1), new Error("broken")), stream(progress(2), END)],
  };
  const told = follower();
  await run(told);
  expect(told.told).toEqual([
    "away",
    "there",
    "running",
    "generation 1",
    "there",
    "running",
    "generation 2",
    "there",
    "succeeded",
  ]);
});

test("a stream that cannot be had is asked for once in a pause", async () => {
  answers = {
    "/jobs/j": [json(RUNNING), json(RUNNING), json(DONE)],
    "/jobs/j/events": [json({ title: "Busy", detail: "later" }, 503), () => null],
  };
  await run(follower());
  expect(asked).toEqual(["/jobs/j", "/jobs/j/events", "/jobs/j", "/jobs/j/events", "/jobs/j"]);
});

test("what the follower throws is not tried again", async () => {
  answers = { "/jobs/j": [json(DONE), json(DONE)] };
  const broken = { ...follower(), record: () => expect.fail("a fault of the view") };
  await expect(run(broken)).rejects.toThrow("a fault of the view");
  answers = { "/jobs/j": [json(RUNNING)], "/jobs/j/events": [stream(progress(1))] };
  const later = { ...follower(), progress: () => expect.fail("another") };
  await expect(run(later)).rejects.toThrow("another");
  expect(asked).toEqual(["/jobs/j", "/jobs/j", "/jobs/j/events"]);
});

test("a job that is gone ends it with the words of the service", async () => {
  answers = { "/jobs/j": [json({ title: "Gone", detail: "it has expired", status: 410 }, 410)] };
  await expect(run(follower())).rejects.toThrow("it has expired");
});

test("nothing is told to those who have gone elsewhere", async () => {
  const gone = new AbortController();
  answers = {
    "/jobs/j": [
      () => {
        gone.abort();
        return json(RUNNING)();
      },
    ],
  };
  const told = follower();
  await run(told, gone.signal);
  expect(told.told).toEqual([]);
});

test("a page that nobody looks at asks for nothing until somebody does", async () => {
  page.hidden = true;
  answers = { "/jobs/j": [json(DONE)] };
  const told = follower();
  const end = run(told);
  await vi.advanceTimersByTimeAsync(10_000);
  expect(asked).toEqual([]);
  page.hidden = false;
  page.dispatchEvent(new Event("visibilitychange"));
  await end;
  expect(told.told).toEqual(["there", "succeeded"]);
});
