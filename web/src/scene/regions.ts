/** Boxes, balls and half-spaces of the constraints. */

import * as THREE from "three";

import { EXCLUDE_COLOR, INCLUDE_COLOR } from "./colors";
import { turnTo } from "./marks";
import type { SceneRegion } from "./types";

/** One region; a half-space is a disc about the size of the body with an arrow into it. */
export function regionMark(
  { shape, use }: SceneRegion,
  body: THREE.Sphere,
  origin: THREE.Vector3,
): THREE.Group {
  const color = use === "exclude" ? EXCLUDE_COLOR : INCLUDE_COLOR;
  const group = new THREE.Group();
  const add = (geometry: THREE.BufferGeometry): void => {
    const fill = new THREE.MeshBasicMaterial({
      color,
      transparent: true,
      opacity: 0.16,
      depthWrite: false,
      side: THREE.DoubleSide,
    });
    const line = new THREE.LineBasicMaterial({ color, transparent: true, opacity: 0.8 });
    group.add(new THREE.Mesh(geometry, fill));
    group.add(new THREE.LineSegments(new THREE.EdgesGeometry(geometry, 20), line));
  };
  if ("box" in shape) {
    const low = new THREE.Vector3(...shape.box.min);
    const high = new THREE.Vector3(...shape.box.max);
    const size = high.clone().sub(low);
    add(new THREE.BoxGeometry(size.x, size.y, size.z));
    group.position.copy(low).add(high).multiplyScalar(0.5).sub(origin);
  } else if ("sphere" in shape) {
    add(new THREE.SphereGeometry(shape.sphere.radius, 24, 16));
    group.position.set(...shape.sphere.center).sub(origin);
  } else {
    const normal = new THREE.Vector3(...shape.half_space.normal);
    if (normal.lengthSq() === 0) {
      return group;
    }
    normal.normalize();
    const disc = new THREE.CircleGeometry(1.25 * body.radius, 48);
    disc.rotateX(-Math.PI / 2);
    add(disc);
    group.add(
      new THREE.ArrowHelper(new THREE.Vector3(0, 1, 0), undefined, 0.5 * body.radius, color),
    );
    group.quaternion.copy(turnTo(normal));
    // The point of the plane that is nearest to the middle of the body.
    const point = new THREE.Vector3(...shape.half_space.point).sub(origin);
    const away = normal.dot(point.sub(body.center));
    group.position.copy(body.center).addScaledVector(normal, away);
  }
  return group;
}
