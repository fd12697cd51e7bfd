/** What the service sends and takes, as far as the page looks at it; see /openapi.json. */

export type Vec3 = [number, number, number];

export type JobState = "queued" | "running" | "succeeded" | "failed" | "cancelled";
export type ContactModel = "hard" | "soft" | "frictionless";

export interface FieldError {
  pointer: string;
  detail: string;
}

export interface ProblemBody {
  type?: string;
  title: string;
  status: number;
  detail: string;
  errors?: FieldError[];
}

export interface MeshReport {
  triangles: number;
  candidates: number;
  watertight: boolean;
  center_of_mass: Vec3;
  bounds: [Vec3, Vec3];
  bounding_radius: number;
  volume: number | null;
  area: number;
  warnings: { kind: string; detail: string }[];
}

export interface MeshRecord {
  id: string;
  format: string;
  units?: string;
  file_name?: string;
  report: MeshReport;
}

export interface Contact {
  position: Vec3;
  normal: Vec3;
  triangle?: number;
  fixed?: boolean;
  forces?: Vec3;
}

export interface Progress {
  phase: "preparing" | "initial" | "search" | "analysis";
  generation: number;
  generations: number;
  evaluations: number;
  best_quality: number | null;
  best_contacts?: { position: Vec3; normal: Vec3 }[];
  elapsed_s: number;
}

export interface HistoryEntry {
  generation: number;
  best: number | null;
  mean: number | null;
  evaluations: number;
  elapsed_s: number;
}

export interface WeakestWrench {
  force: Vec3;
  torque: Vec3;
  description: string;
}

export interface PlanResult {
  force_closure: boolean;
  quality: number | null;
  margin: number | null;
  exact: boolean | null;
  bounds?: [number, number] | null;
  contacts: Contact[];
  weakest_wrench: WeakestWrench | null;
  measures?: Record<string, number | null> | null;
  robustness?: {
    sigma: number;
    samples: number;
    expected: number;
    percentile_5: number;
    force_closure_probability: number;
  };
  independent_regions?: Region[];
  explanation?: { reason: string; proven: boolean; detail: string };
  initial: { quality: number; contacts: Contact[] } | null;
  units?: string;
  torque_scale: { kind: string; value: number };
  center_of_mass: Vec3;
  contact_model: ContactModel;
  wrench_space?: string;
  friction?: number;
  candidates: number;
  method: string;
  /** Text where it is beyond what a number keeps. */
  seed: number | string;
  stopped_because: string;
  top?: { quality: number; distance_to_best: number; contacts: Contact[] }[];
  polish?: { quality_before: number; gain: number };
  single_exchange_optimal: boolean;
  reproducible: boolean;
  evaluations: number;
  history: HistoryEntry[];
  elapsed_s: number;
  version: string;
}

/** What a given grasp is worth. */
export interface Evaluation {
  contacts: Contact[];
  weakest_wrench: WeakestWrench | null;
  measures?: Record<string, number | null> | null;
  independent_regions?: Region[];
}

/** Where a finger may be while the others stay. */
export interface Region {
  triangles: number[];
  truncated: boolean;
  count: number;
  area: number;
}

export interface JobRecord {
  id: string;
  mesh_id: string;
  state: JobState;
  label?: string;
  request: Record<string, unknown>;
  progress?: Progress;
  result?: PlanResult;
  problem?: ProblemBody;
  mesh_report?: MeshReport;
  revision: number;
  created_at: string;
}

export interface JobPage {
  jobs: JobRecord[];
  next_cursor?: string;
}

/** A box, half-space or sphere of the constraints. */
export type Shape =
  | { box: { min: Vec3; max: Vec3 } }
  | { half_space: { point: Vec3; normal: Vec3 } }
  | { sphere: { center: Vec3; radius: number } };

/** Where the contacts of a request may be. */
export interface Constraints {
  include?: (Shape | { triangles: number[] })[];
  exclude?: (Shape | { triangles: number[] })[];
  min_contact_distance?: number;
  max_contact_distance?: number;
  fixed_contacts?: { point?: Vec3; [other: string]: unknown }[];
  /** The page has nothing to set these with. */
  [other: string]: unknown;
}
