import { afterEach, beforeEach, expect, test, vi } from "vitest";

import { Problem } from "./client";
import { patiently } from "./patience";

const refusal = (status: number): Problem => new Problem({ status, title: "No", detail: "no" });

beforeEach(() => {
  vi.useFakeTimers();
  vi.stubGlobal("document", Object.assign(new EventTarget(), { hidden: false }));
});

afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

/** What comes of answers that follow each other, with how often it was asked and what was told of the server. */
async function outcome(answers: (number | string)[]): Promise<unknown[]> {
  const told: boolean[] = [];
  let asked = 0;
  const ask = (): Promise<string> => {
    const answer = answers[Math.min(asked, answers.length - 1)] ?? "";
    asked += 1;
    return typeof answer === "string" ? Promise.resolve(answer) : Promise.reject(refusal(answer));
  };
  const { signal } = new AbortController();
  const answer = patiently(ask, signal, (is) => told.push(is)).catch(
    (error: unknown) => (error as Problem).status,
  );
  await vi.advanceTimersByTimeAsync(600_000);
  return [await answer, asked, told.at(-1)];
}

test("who is away is waited for, however long", async () => {
  expect(await outcome([...Array.from({ length: 60 }, () => 0), 502, 503, "here"])).toEqual([
    "here",
    63,
    true,
  ]);
});

test("a fault that stays and an answer that says no are told", async () => {
  expect(await outcome([404])).toEqual([404, 1, true]);
  expect(await outcome([0, 401])).toEqual([401, 2, true]);
  expect(await outcome([500])).toEqual([500, 5, true]);
  expect(await outcome([500, 429, "here"])).toEqual(["here", 3, true]);
});

test("nothing is asked any more once nobody looks", async () => {
  const controller = new AbortController();
  const ask = vi.fn(() => Promise.reject(refusal(0)));
  const answer = patiently(ask, controller.signal, () => undefined);
  await vi.advanceTimersByTimeAsync(500);
  controller.abort();
  await vi.advanceTimersByTimeAsync(10_000);
  expect(await answer).toBe(null);
  expect(ask).toHaveBeenCalledTimes(1);
});
