import { expect, test } from "vitest";

import { creases } from "./creases";

/** A unit cube of twelve triangles, the last `missing` of them left out. */
function cube(missing = 0): [Float32Array, Uint32Array] {
  const positions: number[] = [];
  for (let corner = 0; corner < 8; corner += 1) {
    positions.push(corner & 1, (corner >> 1) & 1, corner >> 2);
  }
  const quads = [
    [0, 2, 3, 1],
    [4, 5, 7, 6],
    [0, 1, 5, 4],
    [2, 6, 7, 3],
    [0, 4, 6, 2],
    [1, 3, 7, 5],
  ];
  const indices = quads.flatMap(([a = 0, b = 0, c = 0, d = 0]) => [a, b, c, a, c, d]);
  return [
    Float32Array.from(positions),
    Uint32Array.from(indices.slice(0, indices.length - 3 * missing)),
  ];
}

/** Lengths of the edges. */
function lengths(ends: Float32Array): number[] {
  const all: number[] = [];
  for (let start = 0; start < ends.length; start += 6) {
    const [a = 0, b = 0, c = 0, d = 0, e = 0, f = 0] = ends.subarray(start, start + 6);
    all.push(Math.hypot(a - d, b - e, c - f));
  }
  return all;
}

test("a cube has its twelve edges and no diagonal", () => {
  const { ends, closed } = creases(...cube());
  expect(lengths(ends)).toEqual(Array<number>(12).fill(1));
  expect(closed).toBe(true);
});

test("the edges of a hole are drawn, also a diagonal", () => {
  const { ends, closed } = creases(...cube(1));
  const found = lengths(ends);
  expect(closed).toBe(false);
  expect(found).toHaveLength(13);
  expect(Math.max(...found)).toBeCloseTo(Math.SQRT2);
});

test("a degenerate triangle and an empty mesh are accepted", () => {
  const line = creases(Float32Array.of(0, 0, 0, 1, 0, 0, 2, 0, 0), Uint32Array.of(0, 1, 2));
  expect(lengths(line.ends).sort()).toEqual([1, 1, 2]);
  expect(creases(new Float32Array(), new Uint32Array()).ends).toHaveLength(0);
});

test("a surface with a triangle wound the other way is not closed", () => {
  const [positions, indices] = cube();
  [indices[0], indices[1]] = [indices[1] ?? 0, indices[0] ?? 0];
  expect(creases(positions, indices).closed).toBe(false);
});
