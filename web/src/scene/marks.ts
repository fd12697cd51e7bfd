/** Marks of contacts, cones, centre of mass and weakest wrench. Each is faintly visible through the body. */

import * as THREE from "three";

import { contactColor, FORCE_COLOR, TORQUE_COLOR } from "./colors";
import type { SceneContact, SceneGrasp } from "./types";

const UP = new THREE.Vector3(0, 1, 0);
/** Lengths in radii of the body, as in the service's own GLB. */
const ARROW = 0.45;
const CONE = 0.3;
const WEAKEST = 0.6;
const BENT = 0.3;
const FORCE = 0.4;
const SHAFT = 0.012;
const HEAD = 0.09;
/** Opacity of marks that the body hides, and of marks that are always inside it. */
const HIDDEN = 0.25;
const INSIDE = 0.55;
const GHOST = 0.45;
/** Shares of the weakest wrench, or of the greatest force, below which nothing is shown. */
const NEGLIGIBLE = 1e-3;

/** A mesh that is drawn twice: normally, and faintly over everything else. */
export function mark(
  geometry: THREE.BufferGeometry,
  color: string,
  opacity = 1,
  hidden = HIDDEN,
): THREE.Group {
  const material = new THREE.MeshLambertMaterial({
    color,
    transparent: opacity < 1,
    opacity,
    depthWrite: opacity === 1,
    side: opacity < 1 ? THREE.DoubleSide : THREE.FrontSide,
  });
  const faint = new THREE.MeshBasicMaterial({
    color,
    transparent: true,
    opacity: hidden * opacity,
    depthTest: false,
    depthWrite: false,
  });
  const group = new THREE.Group();
  const front = new THREE.Mesh(geometry, material);
  const behind = new THREE.Mesh(geometry, faint);
  front.renderOrder = 2;
  behind.renderOrder = 1;
  group.add(front, behind);
  return group;
}

/** A straight arrow along +y that ends at the origin. */
export function arrow(
  length: number,
  radius: number,
  color: string,
  head = HEAD * (radius / SHAFT),
  opacity = 1,
  hidden = HIDDEN,
): THREE.Group {
  const tip = Math.min(head, 0.5 * length);
  const cone = new THREE.ConeGeometry(Math.min(2.6 * radius, 0.5 * tip), tip, 20);
  cone.translate(0, -tip / 2, 0);
  const shaft = new THREE.CylinderGeometry(radius, radius, length - tip, 16);
  shaft.translate(0, -tip - (length - tip) / 2, 0);
  const group = new THREE.Group();
  group.add(mark(shaft, color, opacity, hidden), mark(cone, color, opacity, hidden));
  return group;
}

/** A number on a disc that always faces the camera. */
export function label(text: string, color: string, size: number): THREE.Sprite {
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = 64;
  const context = canvas.getContext("2d");
  if (context !== null) {
    context.fillStyle = color;
    context.beginPath();
    context.arc(32, 32, 30, 0, 2 * Math.PI);
    context.fill();
    context.fillStyle = "#ffffff";
    context.font = "600 36px system-ui, sans-serif";
    context.textAlign = "center";
    context.textBaseline = "middle";
    context.fillText(text, 32, 34);
  }
  const texture = new THREE.CanvasTexture(canvas);
  texture.colorSpace = THREE.SRGBColorSpace;
  const sprite = new THREE.Sprite(
    new THREE.SpriteMaterial({ map: texture, depthTest: false, transparent: true }),
  );
  sprite.scale.setScalar(size);
  sprite.renderOrder = 3;
  return sprite;
}

export interface ContactMark {
  group: THREE.Group;
  arrows: THREE.Object3D[];
  cones: THREE.Object3D[];
}

/** The mark of a contact, which is at the origin; +y is the inward normal. */
export function contactMark(
  index: number,
  grasp: SceneGrasp,
  radius: number,
  fixed: boolean,
): ContactMark {
  const color = contactColor(index);
  const group = new THREE.Group();
  const arrows: THREE.Object3D[] = [];
  const cones: THREE.Object3D[] = [];
  const pointer = arrow(ARROW * radius, SHAFT * radius, color);
  const dot = mark(new THREE.SphereGeometry(1.8 * SHAFT * radius, 16, 12), color);
  const number = label(String(index + 1), color, 0.13 * radius);
  number.position.y = -(ARROW + 0.07) * radius;
  arrows.push(pointer, dot, number);
  if (fixed) {
    const collar = new THREE.CylinderGeometry(
      3 * SHAFT * radius,
      3 * SHAFT * radius,
      2 * SHAFT * radius,
      24,
    );
    for (const share of [0.55, 0.7]) {
      arrows.push(mark(collar.clone().translate(0, -share * ARROW * radius, 0), color));
    }
    collar.dispose();
  }
  if (grasp.contactModel === "soft") {
    const ring = new THREE.TorusGeometry(7 * SHAFT * radius, 0.6 * SHAFT * radius, 8, 40);
    ring.rotateX(Math.PI / 2);
    arrows.push(mark(ring, color));
  }
  const friction = grasp.friction ?? 0;
  if (grasp.contactModel !== "frictionless" && friction > 0) {
    cones.push(mark(frictionCone(friction, CONE * radius), color, 0.4));
  }
  group.add(...arrows, ...cones);
  return { group, arrows, cones };
}

/**
 * The cone of half angle atan μ about -y with its apex at the origin: it opens away from the body, to be visible.
 * `slant` is the length of its side.
 */
export function frictionCone(friction: number, slant: number): THREE.BufferGeometry {
  const height = slant / Math.hypot(1, friction);
  const cone = new THREE.ConeGeometry(height * friction, height, 40, 1, true);
  return cone.translate(0, -height / 2, 0);
}

/** The mark of a contact in the grasp for comparison: only an arrow. */
export function ghostMark(radius: number, color: string): ContactMark {
  const group = new THREE.Group();
  const arrows = [arrow(ARROW * radius, SHAFT * radius, color, HEAD * radius, GHOST, HIDDEN)];
  group.add(...arrows);
  return { group, arrows, cones: [] };
}

/** A thin arrow to each contact for the force with which it answers the weakest wrench; lengths are proportional. */
export function forceMarks(
  contacts: SceneContact[],
  radius: number,
  origin: THREE.Vector3,
): THREE.Group {
  const group = new THREE.Group();
  const forces = contacts.map(({ forces }) => new THREE.Vector3(...(forces ?? [0, 0, 0])));
  const greatest = Math.max(...forces.map((force) => force.length()));
  contacts.forEach((contact, index) => {
    const force = forces[index];
    if (force === undefined || !(force.length() > NEGLIGIBLE * greatest)) {
      return;
    }
    const length = (FORCE * radius * force.length()) / greatest;
    const thin = arrow(length, 0.5 * SHAFT * radius, FORCE_COLOR);
    thin.quaternion.copy(turnTo(force));
    thin.position.set(...contact.position).sub(origin);
    group.add(thin);
  });
  return group;
}

/** The rotation from +y to `direction`. */
export function turnTo(direction: THREE.Vector3): THREE.Quaternion {
  return new THREE.Quaternion().setFromUnitVectors(UP, direction.clone().normalize());
}

/** The symbol of a centre of mass: a ball in black and white quarters. */
export function centerMark(radius: number): THREE.Group {
  const group = new THREE.Group();
  for (let quarter = 0; quarter < 4; quarter += 1) {
    const piece = new THREE.SphereGeometry(
      2.6 * SHAFT * radius,
      10,
      16,
      (quarter * Math.PI) / 2,
      Math.PI / 2,
    );
    const material = new THREE.MeshBasicMaterial({
      color: quarter % 2 === 0 ? "#14161a" : "#ffffff",
      depthTest: false,
      transparent: true,
      opacity: 0.9,
    });
    const mesh = new THREE.Mesh(piece, material);
    mesh.renderOrder = 3;
    group.add(mesh);
  }
  return group;
}

/** The weakest force as a straight arrow from the centre of mass, and the weakest torque as an arrow bent around it. */
export function weakestMarks(
  weakest: NonNullable<SceneGrasp["weakest"]>,
  radius: number,
): THREE.Group {
  const group = new THREE.Group();
  const force = new THREE.Vector3(...weakest.force);
  if (force.length() > NEGLIGIBLE) {
    const length = WEAKEST * radius * force.length();
    const straight = arrow(length, 1.4 * SHAFT * radius, FORCE_COLOR, HEAD * radius, 1, INSIDE);
    straight.quaternion.copy(turnTo(force));
    straight.position.copy(force).setLength(length);
    group.add(straight);
  }
  const torque = new THREE.Vector3(...weakest.torque);
  if (torque.length() > NEGLIGIBLE) {
    const bend = 1.5 * Math.PI;
    const arc = new THREE.TorusGeometry(BENT * radius, 1.4 * SHAFT * radius, 10, 64, bend);
    const tip = new THREE.ConeGeometry(3.6 * SHAFT * radius, HEAD * radius, 20);
    // At the end of the arc, in its direction.
    tip.translate(0, (HEAD * radius) / 2, 0);
    tip.rotateZ(bend);
    tip.translate(BENT * radius * Math.cos(bend), BENT * radius * Math.sin(bend), 0);
    const bent = new THREE.Group();
    bent.add(mark(arc, TORQUE_COLOR, 1, INSIDE), mark(tip, TORQUE_COLOR, 1, INSIDE));
    bent.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), torque.normalize());
    group.add(bent);
  }
  return group;
}

/** Frees the graphics memory of an object and all its children. */
export function disposeAll(root: THREE.Object3D): void {
  root.traverse((object) => {
    if (object instanceof THREE.Mesh || object instanceof THREE.LineSegments) {
      (object.geometry as THREE.BufferGeometry).dispose();
      (object.material as THREE.Material).dispose();
    } else if (object instanceof THREE.Sprite) {
      object.material.map?.dispose();
      object.material.dispose();
    }
  });
}
