import { expect, test } from "vitest";

import { ago, number, seconds } from "./format";

test("numbers keep four digits that count", () => {
  expect([0.18351582, 12345.678, 1e-7, 0, null, -0.5, 1e9].map(number)).toEqual([
    "0.1835",
    "12350",
    "1.000e-7",
    "0",
    "–",
    "-0.5",
    "1.000e+9",
  ]);
});

test("times are said as people say them", () => {
  expect([0.5, 12.4, 125].map(seconds)).toEqual(["0.50 s", "12 s", "2 min 5 s"]);
  const now = Date.parse("2026-01-02T00:00:00Z");
  expect(ago("2026-01-01T23:59:30Z", now)).toBe("just now");
  expect(ago("2026-01-01T22:00:00Z", now)).toBe("2 hours ago");
  expect(ago("2025-12-31T23:00:00Z", now)).toBe("1 day ago");
});
