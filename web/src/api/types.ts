/**
 * The types of the service's requests and answers. They come from its OpenAPI description, which does not say how long
 * lists are; that is added here.
 */

import type { components } from "./openapi";

type Schemas = components["schemas"];

/** A type with some members narrowed; members that the type does not have do not compile. */
type Narrow<
  T,
  Members extends { [K in keyof Members]: K extends keyof T ? unknown : never },
> = Omit<T, keyof Members> & Members;

export type Vec3 = [number, number, number];

export type JobState = Schemas["JobState"];
export type ContactModel = Schemas["ContactModel"];
export type FieldError = Schemas["FieldError"];
/** Problems that the page makes itself have no type. */
export type ProblemBody = Narrow<Schemas["Problem"], { type?: string }>;

export type MeshReport = Narrow<
  Schemas["MeshReport"],
  { center_of_mass: Vec3; bounds: [Vec3, Vec3]; warnings: Schemas["MeshWarning"][] }
>;
export type MeshRecord = Narrow<Schemas["MeshRecord"], { report: MeshReport }>;

export type Contact = Narrow<
  Schemas["ContactPoint"],
  { position: Vec3; normal: Vec3; forces?: Vec3 }
>;
type Place = Narrow<Schemas["ProgressContact"], { position: Vec3; normal: Vec3 }>;
export type Progress = Narrow<
  Schemas["Progress"],
  { best_quality: number | null; best_contacts?: Place[] }
>;
export type HistoryEntry = Narrow<
  Schemas["HistoryEntry"],
  { best: number | null; mean: number | null }
>;
export type WeakestWrench = Narrow<Schemas["WeakestWrench"], { force: Vec3; torque: Vec3 }>;
/** The triangles to which one finger may move while the others stay. */
export type Measures = Schemas["Measures"];
export type Region = Schemas["IndependentRegion"];
type InitialGrasp = Narrow<Schemas["InitialGrasp"], { contacts: Contact[] }>;
type TopGrasp = Narrow<Schemas["TopGrasp"], { contacts: Contact[] }>;

export type PlanResult = Narrow<
  Schemas["PlanResult"],
  {
    contacts: Contact[];
    history: HistoryEntry[];
    weakest_wrench: WeakestWrench | null;
    initial: InitialGrasp | null;
    top?: TopGrasp[];
    center_of_mass: Vec3;
    bounds?: [number, number] | null;
    /** A string if it is too large for an exact number. */
    seed: number | string;
  }
>;

/** The evaluation of a given grasp. */
export type Evaluation = Pick<PlanResult, "contacts" | "weakest_wrench"> &
  Pick<Schemas["GraspEvaluation"], "measures" | "independent_regions">;

export type JobRecord = Narrow<
  Schemas["JobRecord"],
  {
    request: Record<string, unknown>;
    progress?: Progress;
    result?: PlanResult;
    mesh_report?: MeshReport;
  }
>;
export type JobPage = Narrow<Schemas["JobPage"], { jobs: JobRecord[] }>;

/** A box, half-space or sphere of the constraints. */
export type Shape =
  | { box: Narrow<Schemas["Corners"], { min: Vec3; max: Vec3 }> }
  | { half_space: Narrow<Schemas["HalfSpace"], { point: Vec3; normal: Vec3 }> }
  | { sphere: Narrow<Schemas["Sphere"], { center: Vec3 }> };

/** The constraints on the contacts of a request. */
export type Constraints = Narrow<
  Schemas["Constraints"],
  {
    include?: (Shape | { triangles: number[] })[];
    exclude?: (Shape | { triangles: number[] })[];
    fixed_contacts?: Narrow<Schemas["ContactSpec"], { point?: Vec3 }>[];
  }
>;
