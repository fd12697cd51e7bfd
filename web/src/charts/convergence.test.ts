import { expect, test } from "vitest";

import { lastOfEach, padded, summary } from "./convergence";

test("the newest point of each generation is shown", () => {
  const at = (generation: number, best: number | null) => ({ generation, best });
  expect(lastOfEach([at(0, null), at(0, 0.1), at(1, 0.2), at(1, 0.3)])).toEqual([
    at(0, 0.1),
    at(1, 0.3),
  ]);
  expect(lastOfEach([])).toEqual([]);
});

test("a sentence describes the chart", () => {
  expect(summary([{ generation: 0, best: null }])).toContain("no grasp that holds so far");
  expect(
    summary([
      { generation: 0, best: null },
      { generation: 1, best: 0.05 },
      { generation: 1200, best: 0.125 },
    ]),
  ).toBe("Quality over generations: from 0.05 in generation 1 to 0.125 in generation 1,200");
});

test("the range contains all values, also a single one, and never goes below zero", () => {
  expect(padded(null, null)).toEqual([0, 1]);
  for (const [low, high] of [
    [0.1, 0.3],
    [0.2, 0.2],
    [0, 0],
    [0, 0.001],
  ] as const) {
    const [bottom, top] = padded(low, high);
    expect(bottom).toBeGreaterThanOrEqual(0);
    expect(bottom).toBeLessThanOrEqual(low);
    expect(top).toBeGreaterThan(high);
  }
});
