/** The marks of a grasp on the body, whose contacts move smoothly when a better grasp arrives. */

import * as THREE from "three";

import {
  centerMark,
  type ContactMark,
  contactMark,
  disposeAll,
  forceMarks,
  ghostMark,
  turnTo,
  weakestMarks,
} from "./marks";
import type { Part, SceneContact, SceneGrasp } from "./types";

/** Duration of a contact's movement to its next position, in milliseconds. */
const MOVE = 200;

interface Shown extends ContactMark {
  from: { position: THREE.Vector3; turn: THREE.Quaternion };
  to: { position: THREE.Vector3; turn: THREE.Quaternion };
}

export class GraspMarks {
  readonly group = new THREE.Group();
  private shown: Shown[] = [];
  private last: SceneContact[] = [];
  private weakest: THREE.Group | null = null;
  private kind = "";
  private moved = 1;
  private readonly visible: Record<Part, boolean>;
  private readonly radius: number;
  private readonly origin: THREE.Vector3;
  private ghost: string | null;

  /** With a colour `ghost`, the grasp is drawn faintly for comparison. */
  constructor(
    radius: number,
    origin: THREE.Vector3,
    visible: Record<Part, boolean>,
    ghost: string | null = null,
  ) {
    this.ghost = ghost;
    this.radius = radius;
    this.origin = origin;
    this.visible = visible;
  }

  set(grasp: SceneGrasp | null, animate: boolean): void {
    const contacts =
      grasp === null ? [] : animate ? inOldOrder(this.last, grasp.contacts) : grasp.contacts;
    const fixed = contacts.map((contact) => (contact.fixed === true ? "f" : "p")).join("");
    const kind = grasp === null ? "" : `${grasp.contactModel} ${grasp.friction ?? 0} ${fixed}`;
    const rebuild = kind !== this.kind;
    if (rebuild) {
      for (const { group } of this.shown) {
        this.drop(group);
      }
      this.shown = [];
      this.kind = kind;
    }
    contacts.forEach((contact, index) => {
      const to = {
        position: new THREE.Vector3(...contact.position).sub(this.origin),
        turn: turnTo(new THREE.Vector3(...contact.normal)),
      };
      const old = this.shown[index];
      if (old === undefined) {
        const mark =
          this.ghost === null
            ? contactMark(index, grasp as SceneGrasp, this.radius, contact.fixed === true)
            : ghostMark(this.radius, this.ghost);
        this.group.add(mark.group);
        this.shown[index] = { ...mark, from: to, to };
      } else {
        const from = {
          position: old.group.position.clone(),
          turn: old.group.quaternion.clone(),
        };
        this.shown[index] = { ...old, from: animate ? from : to, to };
      }
    });
    this.last = contacts;
    this.moved = animate && !rebuild ? 0 : 1;
    this.place();
    if (this.weakest !== null) {
      this.drop(this.weakest);
      this.weakest = null;
    }
    if (grasp?.centerOfMass !== undefined && this.ghost === null) {
      const center = new THREE.Group().add(centerMark(this.radius));
      if (grasp.weakest !== undefined) {
        center.add(weakestMarks(grasp.weakest, this.radius));
      }
      center.position.set(...grasp.centerOfMass).sub(this.origin);
      this.weakest = new THREE.Group();
      this.weakest.add(center, forceMarks(contacts, this.radius, this.origin));
      this.group.add(this.weakest);
    }
    this.applyVisible();
  }

  /** Advances the movement by `passed` milliseconds; returns whether it continues. */
  step(passed: number): boolean {
    if (this.moved >= 1) {
      return false;
    }
    this.moved = Math.min(1, this.moved + passed / MOVE);
    this.place();
    return this.moved < 1;
  }

  applyVisible(): void {
    for (const { arrows, cones } of this.shown) {
      arrows.forEach((object) => (object.visible = this.visible.arrows));
      cones.forEach((object) => (object.visible = this.visible.cones));
    }
    if (this.weakest !== null) {
      this.weakest.visible = this.visible.weakest;
    }
  }

  /** Sets the colour of a grasp drawn for comparison. */
  setColor(ghost: string): void {
    this.ghost = ghost;
    this.group.traverse((object) => {
      if (object instanceof THREE.Mesh) {
        (object.material as THREE.MeshLambertMaterial).color.set(ghost);
      }
    });
  }

  dispose(): void {
    disposeAll(this.group);
  }

  private place(): void {
    const share = this.moved * this.moved * (3 - 2 * this.moved);
    for (const { group, from, to } of this.shown) {
      group.position.lerpVectors(from.position, to.position, share);
      group.quaternion.slerpQuaternions(from.turn, to.turn, share);
    }
  }

  private drop(object: THREE.Object3D): void {
    this.group.remove(object);
    disposeAll(object);
  }
}

/** Orders the contacts so that each is near the old contact of its number: progress reports them in any order. */
export function inOldOrder(old: SceneContact[], contacts: SceneContact[]): SceneContact[] {
  if (old.length !== contacts.length) {
    return contacts;
  }
  const left = [...contacts];
  return old.map(({ position: [x, y, z] }) => {
    const distance = ({ position }: SceneContact): number =>
      Math.hypot(position[0] - x, position[1] - y, position[2] - z);
    let nearest = 0;
    left.forEach((contact, index) => {
      const best = left[nearest];
      if (best !== undefined && distance(contact) < distance(best)) {
        nearest = index;
      }
    });
    return left.splice(nearest, 1)[0] as SceneContact;
  });
}
