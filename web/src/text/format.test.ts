import { expect, test } from "vitest";

import { ago, decimals, extent, number, place, seconds, steps } from "./format";

test("numbers keep four significant digits", () => {
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

test("positions are resolved to a ten-thousandth of the body, wherever it is", () => {
  const far: [number[], number[]] = [
    [500_000, 4_500_000, 1200],
    [500_060, 4_500_080, 1200],
  ];
  const size = extent(far);
  expect(size).toBe(100);
  expect(place([500_012.3456, 4_500_000.04, 1200], size)).toBe("500012.35, 4500000.04, 1200");
  expect(place([0.012_345_6, -1e-9, 0.1], 0.1)).toBe("0.01235, 0, 0.1");
  expect(place([12_345.6, 0, 0], 1e6)).toBe("12346, 0, 0");
  expect([decimals(0), decimals(1e-30), decimals(1e9)]).toEqual([6, 20, 0]);
});

test("times are readable", () => {
  expect([0.5, 12.4, 119.6, 125].map(seconds)).toEqual([
    "0.50 s",
    "12 s",
    "2 min 0 s",
    "2 min 5 s",
  ]);
  const now = Date.parse("2026-01-02T00:00:00Z");
  expect(ago("2026-01-01T23:59:30Z", now)).toBe("just now");
  expect(ago("2026-01-01T22:00:00Z", now)).toBe("2 hours ago");
  expect(ago("2025-12-31T23:00:00Z", now)).toBe("1 day ago");
});

test("labels of an axis have just enough digits to differ", () => {
  expect(steps([0.23, 0.2325, 0.235])).toEqual(["0.2300", "0.2325", "0.2350"]);
  expect(steps([0, 0.1, 0.2, 0.30000000000000004])).toEqual(["0", "0.1", "0.2", "0.3"]);
  expect(steps([1, 2])).toEqual(["1", "2"]);
  expect(steps([150, 175])).toEqual(["150", "175"]);
  expect(steps([0, 2e-6, 4e-6])).toEqual(["0", "2e-6", "4e-6"]);
  expect(steps([1.2e-5, 1.225e-5])).toEqual(["1.200e-5", "1.225e-5"]);
  expect(steps([2e7, 4e7])).toEqual(["2e7", "4e7"]);
  expect(steps([0.5])).toEqual(["0.5"]);
  expect(steps([])).toEqual([]);
});
