import { expect, test } from "vitest";

import { regionColors } from "./body";
import { readMesh } from "./glb";
import { inOldOrder } from "./grasp";

/** A triangle as the service writes it. */
function glb(): ArrayBuffer {
  const json = JSON.stringify({
    nodes: [
      { name: "mesh", mesh: 0, translation: [1e6, 0, 0] },
      { name: "graspd", extras: { coarse: true, triangles_of_the_mesh: 9 } },
    ],
    meshes: [
      { primitives: [{ attributes: { POSITION: 0 }, indices: 1, extras: { triangles: 2 } }] },
    ],
    accessors: [
      { bufferView: 0, count: 3, type: "VEC3" },
      { bufferView: 1, count: 3, type: "SCALAR" },
      { bufferView: 2, count: 1, type: "SCALAR" },
    ],
    bufferViews: [
      { byteOffset: 0, byteLength: 36 },
      { byteOffset: 36, byteLength: 12 },
      { byteOffset: 48, byteLength: 4 },
    ],
  });
  const text = new TextEncoder().encode(json.padEnd(Math.ceil(json.length / 4) * 4));
  const bytes = new Uint8Array(20 + text.length + 8 + 52);
  const view = new DataView(bytes.buffer);
  view.setUint32(0, 0x46546c67, true);
  view.setUint32(12, text.length, true);
  bytes.set(text, 20);
  const start = 28 + text.length;
  [0, 0, 0, 1, 0, 0, 0, 1, 0].forEach((x, i) => {
    view.setFloat32(start + 4 * i, x, true);
  });
  [0, 1, 2, 7].forEach((x, i) => {
    view.setUint32(start + 36 + 4 * i, x, true);
  });
  return bytes.buffer;
}

test("a mesh is read with the numbers of its triangles", () => {
  const mesh = readMesh(glb());
  expect([...mesh.positions]).toEqual([0, 0, 0, 1, 0, 0, 0, 1, 0]);
  expect([...mesh.indices]).toEqual([0, 1, 2]);
  expect([...mesh.triangles]).toEqual([7]);
  expect([mesh.origin, mesh.coarse, mesh.whole]).toEqual([[1e6, 0, 0], true, 9]);
  expect(() => readMesh(new ArrayBuffer(40))).toThrow("no GLB");
});

test("a triangle has the colour of its region, and the mean where regions meet", () => {
  const paint = regionColors(
    Uint32Array.of(5, 8, 9),
    [[5, 8], [8]],
    [
      [1, 0, 0],
      [0, 0, 1],
    ],
    [0.5, 0.5, 0.5],
  );
  expect([...paint.slice(0, 3)]).toEqual([1, 0, 0]);
  expect([...paint.slice(9, 12)]).toEqual([0.5, 0, 0.5]);
  expect([...paint.slice(24, 27)]).toEqual([0.5, 0.5, 0.5]);
});

test("contacts keep their numbers while they move", () => {
  const at = (x: number) => ({
    position: [x, 0, 0] as [number, number, number],
    normal: [0, 0, 1] as [number, number, number],
  });
  const moved = inOldOrder([at(0), at(10)], [at(9), at(1)]);
  expect(moved.map((contact) => contact.position[0])).toEqual([1, 9]);
  expect(inOldOrder([], [at(1)])).toEqual([at(1)]);
});
