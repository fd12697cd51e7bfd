/** The camera: its named views, the distance that shows the whole body, and the keys that move it. */

import * as THREE from "three";
import type { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";

import type { ViewName } from "./types";

/** Vertical angle of view in degrees. */
export const FIELD = 30;

/** Direction to the camera; the first is that of the service's own pictures. */
const VIEWS: Record<ViewName, [number, number, number]> = {
  iso: [0.62, -1, 0.62],
  front: [0, -1, 0],
  back: [0, 1, 0],
  left: [-1, 0, 0],
  right: [1, 0, 0],
  top: [0, -1e-3, 1],
  bottom: [0, -1e-3, -1],
};
/** Room for the arrows and their numbers outside the body, in radii of the body. */
const ROOM = 0.6;
/** Number of vertices that are sampled: enough to know the extent of a body. */
const SAMPLES = 5_000;
const TURN = Math.PI / 24;
const ZOOM = 1.15;

/**
 * The distance of the camera from `center` at which all points are in the picture, with `room` around each; z is up.
 * `direction` points from `center` to the camera, `field` is the vertical angle of view in radians.
 */
export function fittingDistance(
  positions: Float32Array,
  center: THREE.Vector3,
  direction: THREE.Vector3,
  field: number,
  aspect: number,
  room: number,
): number {
  const back = direction.clone().normalize();
  const right = new THREE.Vector3(0, 0, 1).cross(back).normalize();
  const up = back.clone().cross(right);
  const vertical = Math.tan(field / 2);
  const step = 3 * Math.ceil(positions.length / 3 / SAMPLES);
  const at = new THREE.Vector3();
  let away = 0;
  for (let start = 0; start < positions.length; start += step) {
    at.fromArray(positions, start).sub(center);
    const wide = (Math.abs(at.dot(right)) + room) / (vertical * aspect);
    const high = (Math.abs(at.dot(up)) + room) / vertical;
    away = Math.max(away, Math.max(wide, high) + at.dot(back));
  }
  return away;
}

/** Points the camera at the whole body from the side with this name. */
export function look(
  name: ViewName,
  camera: THREE.PerspectiveCamera,
  controls: OrbitControls,
  body: { box: THREE.Box3; sphere: THREE.Sphere; positions: Float32Array },
): void {
  const { radius } = body.sphere;
  const direction = new THREE.Vector3(...VIEWS[name]);
  const field = THREE.MathUtils.degToRad(FIELD);
  const center = body.box.getCenter(controls.target);
  const room = ROOM * radius;
  const away = fittingDistance(body.positions, center, direction, field, camera.aspect, room);
  camera.position.copy(direction).setLength(away).add(controls.target);
  camera.near = away / 200;
  camera.far = away * 20;
  camera.updateProjectionMatrix();
  controls.minDistance = radius * 0.1;
  controls.maxDistance = away * 8;
  controls.update();
}

/** Turns or zooms the view by a key; returns whether the key has a meaning. */
export function moveByKey(key: string, controls: OrbitControls): boolean {
  const moves: Record<string, () => void> = {
    ArrowLeft: () => {
      controls.rotateLeft(TURN);
    },
    ArrowRight: () => {
      controls.rotateLeft(-TURN);
    },
    ArrowUp: () => {
      controls.rotateUp(TURN);
    },
    ArrowDown: () => {
      controls.rotateUp(-TURN);
    },
    "+": () => {
      controls.dollyIn(1 / ZOOM);
    },
    "=": () => {
      controls.dollyIn(1 / ZOOM);
    },
    "-": () => {
      controls.dollyOut(1 / ZOOM);
    },
  };
  const move = moves[key];
  move?.();
  return move !== undefined;
}
