/** Marks of the boxes, balls and half-spaces of the constraints. */

import * as THREE from "three";

import { EXCLUDE_COLOR, INCLUDE_COLOR } from "./colors";
import { arrow, turnTo } from "./marks";
import type { SceneRegion } from "./types";

/** The mark of a region; a half-space is a disc about as large as the body, with arrows into the half-space. */
export function regionMark(
  { shape, use }: SceneRegion,
  body: THREE.Sphere,
  origin: THREE.Vector3,
): THREE.Group {
  const color = use === "exclude" ? EXCLUDE_COLOR : INCLUDE_COLOR;
  const group = new THREE.Group();
  const add = (geometry: THREE.BufferGeometry, outline: THREE.BufferGeometry): void => {
    const fill = new THREE.MeshBasicMaterial({
      color,
      transparent: true,
      opacity: 0.16,
      depthWrite: false,
      side: THREE.DoubleSide,
    });
    const line = new THREE.LineBasicMaterial({ color, transparent: true, opacity: 0.8 });
    group.add(new THREE.Mesh(geometry, fill));
    group.add(new THREE.LineSegments(outline, line));
  };
  if ("box" in shape) {
    const low = new THREE.Vector3(...shape.box.min);
    const high = new THREE.Vector3(...shape.box.max);
    const size = high.clone().sub(low);
    const box = new THREE.BoxGeometry(size.x, size.y, size.z);
    add(box, new THREE.EdgesGeometry(box));
    group.position.copy(low).add(high).multiplyScalar(0.5).sub(origin);
  } else if ("sphere" in shape) {
    add(new THREE.SphereGeometry(shape.sphere.radius, 48, 24), greatCircles(shape.sphere.radius));
    group.position.set(...shape.sphere.center).sub(origin);
  } else {
    const normal = new THREE.Vector3(...shape.half_space.normal);
    if (normal.lengthSq() === 0) {
      return group;
    }
    normal.normalize();
    const disc = new THREE.CircleGeometry(1.25 * body.radius, 48);
    disc.rotateX(-Math.PI / 2);
    add(disc, new THREE.EdgesGeometry(disc));
    for (let quarter = 0; quarter < 4; quarter += 1) {
      const into = arrow(0.22 * body.radius, 0.012 * body.radius, color);
      const angle = (quarter * Math.PI) / 2;
      into.position.set(Math.cos(angle), 0, Math.sin(angle)).multiplyScalar(1.25 * body.radius);
      into.position.y = 0.22 * body.radius;
      group.add(into);
    }
    group.quaternion.copy(turnTo(normal));
    // The point of the plane nearest to the centre of the body.
    const point = new THREE.Vector3(...shape.half_space.point).sub(origin);
    const away = normal.dot(point.sub(body.center));
    group.position.copy(body.center).addScaledVector(normal, away);
  }
  return group;
}

/** Three circles about the axes, as line segments. */
function greatCircles(radius: number): THREE.BufferGeometry {
  const pieces = 64;
  const points: THREE.Vector3[] = [];
  for (let axis = 0; axis < 3; axis += 1) {
    for (let piece = 0; piece < pieces; piece += 1) {
      for (const end of [piece, piece + 1]) {
        const angle = (2 * Math.PI * end) / pieces;
        const at = [radius * Math.cos(angle), radius * Math.sin(angle), 0];
        points.push(new THREE.Vector3(at[axis], at[(axis + 1) % 3], at[(axis + 2) % 3]));
      }
    }
  }
  return new THREE.BufferGeometry().setFromPoints(points);
}
