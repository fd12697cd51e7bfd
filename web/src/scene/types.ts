import type { ContactModel, Shape, Vec3 } from "../api/types";

export interface SceneContact {
  position: Vec3;
  /** The inward normal. */
  normal: Vec3;
  /** The force that the finger exerts against the weakest wrench, in a unit that all contacts share. */
  forces?: Vec3;
  fixed?: boolean;
}

export interface SceneGrasp {
  contacts: SceneContact[];
  friction: number | null;
  contactModel: ContactModel;
  centerOfMass?: Vec3;
  weakest?: { force: Vec3; torque: Vec3 };
}

export interface SceneRegion {
  shape: Shape;
  use: "include" | "exclude";
}

export interface Hit {
  /** Number of the triangle in the file. */
  triangle: number;
  position: Vec3;
}

export type Part = "arrows" | "cones" | "weakest" | "regions" | "wireframe";
export type ViewName = "front" | "back" | "left" | "right" | "top" | "bottom" | "iso";
