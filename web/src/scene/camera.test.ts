import * as THREE from "three";
import { expect, test } from "vitest";

import { fittingDistance } from "./camera";

const FIELD = Math.PI / 6;
const CORNERS = [-1, 1].flatMap((x) => [-2, 2].flatMap((y) => [-3, 3].map((z) => [x, y, z])));
const POSITIONS = Float32Array.from(CORNERS.flat());
const CENTER = new THREE.Vector3();

/** Greatest coordinate of a corner in the picture, which reaches from -1 to 1, as three projects it. */
function reach(direction: THREE.Vector3, aspect: number, room: number): number {
  const away = fittingDistance(POSITIONS, CENTER, direction, FIELD, aspect, room);
  const camera = new THREE.PerspectiveCamera(THREE.MathUtils.radToDeg(FIELD), aspect, 0.1, 1000);
  camera.up.set(0, 0, 1);
  camera.position.copy(direction).setLength(away);
  camera.lookAt(CENTER);
  camera.updateMatrixWorld();
  const all = CORNERS.flatMap(([x, y, z]) => {
    const at = new THREE.Vector3(x, y, z).project(camera);
    return [Math.abs(at.x), Math.abs(at.y)];
  });
  return Math.max(...all);
}

test("a body just fills the picture from any side, however wide it is", () => {
  const sides: [number, number, number][] = [
    [0.62, -1, 0.62],
    [0, -1, 0],
    [1, 0, 0],
    [0, -1e-3, 1],
    [-0.3, 0.4, -0.9],
  ];
  for (const side of sides) {
    for (const aspect of [0.5, 1, 2.5]) {
      expect(reach(new THREE.Vector3(...side), aspect, 0)).toBeCloseTo(1, 6);
      expect(reach(new THREE.Vector3(...side), aspect, 1)).toBeLessThan(0.85);
    }
  }
});
