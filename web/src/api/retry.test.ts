import { afterEach, beforeEach, expect, test, vi } from "vitest";

import { Problem } from "./client";
import { retry } from "./retry";

const refusal = (status: number): Problem => new Problem({ status, title: "No", detail: "no" });

beforeEach(() => {
  vi.useFakeTimers();
  vi.stubGlobal("document", Object.assign(new EventTarget(), { hidden: false }));
});

afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

/** The result for a sequence of answers, the number of calls, and whether the server was last reported as reachable. */
async function outcome(answers: (number | string)[]): Promise<unknown[]> {
  const reported: boolean[] = [];
  let calls = 0;
  const ask = (): Promise<string> => {
    const answer = answers[Math.min(calls, answers.length - 1)] ?? "";
    calls += 1;
    return typeof answer === "string" ? Promise.resolve(answer) : Promise.reject(refusal(answer));
  };
  const { signal } = new AbortController();
  const answer = retry(ask, signal, (is) => reported.push(is)).catch(
    (error: unknown) => (error as Problem).status,
  );
  await vi.advanceTimersByTimeAsync(600_000);
  return [await answer, calls, reported.at(-1)];
}

test("a server that cannot be reached is waited for, however long it takes", async () => {
  expect(await outcome([...Array.from({ length: 60 }, () => 0), 502, 503, "here"])).toEqual([
    "here",
    63,
    true,
  ]);
});

test("a lasting failure and a refusal are thrown", async () => {
  expect(await outcome([404])).toEqual([404, 1, true]);
  expect(await outcome([0, 401])).toEqual([401, 2, true]);
  expect(await outcome([500])).toEqual([500, 5, true]);
  expect(await outcome([500, 429, "here"])).toEqual(["here", 3, true]);
});

test("an aborted call is not repeated", async () => {
  const controller = new AbortController();
  const ask = vi.fn(() => Promise.reject(refusal(0)));
  const answer = retry(ask, controller.signal, () => undefined);
  await vi.advanceTimersByTimeAsync(500);
  controller.abort();
  await vi.advanceTimersByTimeAsync(10_000);
  expect(await answer).toBe(null);
  expect(ask).toHaveBeenCalledTimes(1);
});
