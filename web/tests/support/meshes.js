/** Meshes made for the tests. */

import { readFile } from "node:fs/promises";
import path from "node:path";

import { EXAMPLES } from "./server.js";

/** One of the bundled example meshes. */
export async function example(name) {
  return { name, blob: new Blob([await readFile(path.join(EXAMPLES, name))]) };
}

/**
 * A sphere with bumps as binary STL, 2 * across * (down - 1) triangles, so that no place looks like another
 * and nothing of it is symmetric.
 */
export function bumpySphere(across, down) {
  const point = (i, j) => {
    const [u, v] = [(2 * Math.PI * (i % across)) / across, (Math.PI * j) / down];
    const radius = 50 * (1 + 0.12 * Math.sin(3 * u) * Math.sin(4 * v) + 0.05 * Math.cos(7 * v + u));
    const ring = j === 0 || j === down ? 0 : Math.sin(v);
    // The bump vanishes at the poles, where the longitude is undefined.
    const r = ring === 0 ? 50 : radius;
    return [r * ring * Math.cos(u), r * ring * Math.sin(u), 1.3 * r * Math.cos(v)];
  };
  const count = 2 * across * (down - 1);
  const stl = Buffer.alloc(84 + 50 * count);
  stl.writeUInt32LE(count, 80);
  let at = 84;
  const put = (...corners) => {
    corners.flat().forEach((part, index) => stl.writeFloatLE(part, at + 12 + 4 * index));
    at += 50;
  };
  for (let j = 0; j < down; j += 1) {
    for (let i = 0; i < across; i += 1) {
      const [a, b, c, d] = [point(i, j), point(i + 1, j), point(i, j + 1), point(i + 1, j + 1)];
      if (j > 0) {
        put(a, c, b);
      }
      if (j < down - 1) {
        put(b, c, d);
      }
    }
  }
  return stl;
}
