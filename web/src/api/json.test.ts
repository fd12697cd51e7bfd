import { expect, test } from "vitest";

import { parse, stringify } from "./json";

test("a seed beyond the exact integers of JavaScript survives unchanged", () => {
  const text =
    '{"seed":18446744073709551615,"robustness":{"sigma":0.1,"seed":9007199254740993},"label":"\\"seed\\":12345678901234567890,"}';
  const value = parse(text) as Record<string, unknown>;
  expect(value["seed"]).toBe("18446744073709551615");
  expect(value["label"]).toBe('"seed":12345678901234567890,');
  expect(stringify(value)).toBe(text);
  expect(stringify({ seed: value["seed"] }, 2)).toBe('{\n  "seed": 18446744073709551615\n}');
});

test("any other seed is a number", () => {
  expect(parse('{"seed":7,"contacts":4}')).toEqual({ seed: 7, contacts: 4 });
  expect(stringify({ seed: 7 })).toBe('{"seed":7}');
});
