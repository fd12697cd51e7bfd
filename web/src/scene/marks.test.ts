import * as THREE from "three";
import { expect, test } from "vitest";

import type { Vec3 } from "../api/types";
import { arrow, forceMarks, frictionCone, turnTo } from "./marks";
import type { SceneContact } from "./types";

/** All corners of the meshes below an object, in its parent's frame. */
function corners(object: THREE.Object3D): THREE.Vector3[] {
  const found: THREE.Vector3[] = [];
  object.updateMatrixWorld(true);
  object.traverse((part) => {
    if (part instanceof THREE.Mesh) {
      const at = (part.geometry as THREE.BufferGeometry).getAttribute("position");
      for (let index = 0; index < at.count; index += 1) {
        found.push(
          new THREE.Vector3().fromBufferAttribute(at, index).applyMatrix4(part.matrixWorld),
        );
      }
    }
  });
  return found;
}

test("the side of a friction cone leans by the angle of friction", () => {
  for (const friction of [0.1, 0.5, 1, 10]) {
    const cone = frictionCone(friction, 2);
    const at = cone.getAttribute("position");
    let rim = 0;
    for (let index = 0; index < at.count; index += 1) {
      const point = new THREE.Vector3().fromBufferAttribute(at, index);
      if (point.length() > 1e-6) {
        expect(point.length()).toBeCloseTo(2, 5);
        expect(Math.hypot(point.x, point.z) / -point.y).toBeCloseTo(friction, 4);
        rim += 1;
      }
    }
    expect(rim).toBeGreaterThan(16);
  }
});

test("an arrow ends at its tip and starts on the other side", () => {
  for (const direction of [
    [1, 2, -2],
    [0, -1, 0],
    [0, 1, 0],
  ] as Vec3[]) {
    const along = new THREE.Vector3(...direction).normalize();
    const one = arrow(3, 0.05, "#000000");
    one.quaternion.copy(turnTo(along));
    const places = corners(one).map((corner) => corner.dot(along));
    expect(Math.max(...places)).toBeCloseTo(0, 5);
    expect(Math.min(...places)).toBeCloseTo(-3, 5);
  }
});

test("force arrows end at their contacts, with lengths in proportion; a zero force has none", () => {
  const contact = (x: number, forces?: Vec3): SceneContact => ({
    position: [x, 0, 0],
    normal: [0, 0, 1],
    ...(forces === undefined ? {} : { forces }),
  });
  const contacts = [
    contact(5, [0, 0, 4]),
    contact(7, [0, 0, -1]),
    contact(9, [0, 0, 0]),
    contact(11),
  ];
  const [strong, weak, ...others] = forceMarks(contacts, 1, new THREE.Vector3(5, 0, 0)).children;
  expect(others).toEqual([]);
  const extent = (object?: THREE.Object3D): [number, number] => {
    const heights = corners(object ?? new THREE.Group()).map((corner) => corner.z);
    return [Math.min(...heights), Math.max(...heights)];
  };
  expect(strong?.position.toArray()).toEqual([0, 0, 0]);
  expect(weak?.position.toArray()).toEqual([2, 0, 0]);
  expect(extent(strong)[0]).toBeCloseTo(-0.4, 5);
  expect(extent(strong)[1]).toBeCloseTo(0, 5);
  expect(extent(weak)[0]).toBeCloseTo(0, 5);
  expect(extent(weak)[1]).toBeCloseTo(0.1, 5);
});
