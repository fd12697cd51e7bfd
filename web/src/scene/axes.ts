/** The axes of the mesh's frame in the lower left corner: they turn with the body. */

import * as THREE from "three";

import { arrow, label, turnTo } from "./marks";

const AXES: [name: string, color: string, direction: [number, number, number]][] = [
  ["x", "#b8434e", [1, 0, 0]],
  ["y", "#3d8a52", [0, 1, 0]],
  ["z", "#3f6fc0", [0, 0, 1]],
];
/** Side length of the corner in pixels. */
const SIDE = 84;

export class Axes {
  private readonly scene = new THREE.Scene();
  private readonly camera = new THREE.OrthographicCamera(-1.5, 1.5, 1.5, -1.5, 0.1, 10);

  constructor() {
    this.scene.add(new THREE.AmbientLight("#ffffff", 3));
    for (const [name, color, direction] of AXES) {
      const along = new THREE.Vector3(...direction);
      const shaft = arrow(0.9, 0.045, color, 0.3);
      shaft.position.copy(along).multiplyScalar(0.9);
      shaft.quaternion.copy(turnTo(along));
      const letter = label(name, color, 0.56);
      letter.position.copy(along).multiplyScalar(1.18);
      this.scene.add(shaft, letter);
    }
  }

  /** Draws the axes over the scene, seen from the same direction. */
  render(renderer: THREE.WebGLRenderer, eye: THREE.Camera): void {
    this.camera.quaternion.copy(eye.quaternion);
    this.camera.position.set(0, 0, 5).applyQuaternion(eye.quaternion);
    const size = renderer.getSize(new THREE.Vector2());
    renderer.autoClear = false;
    renderer.clearDepth();
    renderer.setViewport(0, 0, SIDE, SIDE);
    renderer.render(this.scene, this.camera);
    renderer.setViewport(0, 0, size.x, size.y);
    renderer.autoClear = true;
  }
}
