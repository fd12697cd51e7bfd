/** The grasps of a result, one of which is shown. */

import * as api from "../api/client";
import type { Contact, Evaluation, JobRecord, PlanResult, WeakestWrench } from "../api/types";
import type { SceneGrasp } from "../scene";
import { number } from "../text/format";

/** What the page shows of a grasp besides its contacts. */
export interface GraspDetails {
  weakest_wrench: WeakestWrench | null;
  measures?: PlanResult["measures"];
  robustness?: PlanResult["robustness"];
}

/** One of the grasps of a result. */
export interface Choice {
  /** The name in the URLs of pictures and exports. */
  readonly name: string;
  readonly title: string;
  /** These have forces once the grasp has been evaluated. */
  contacts: Contact[];
  /** A result contains them for the best grasp only. */
  details: GraspDetails | null;
}

/** Settings that an evaluation shares with a planning request. */
const SHARED = [
  "contact_model",
  "friction",
  "cone_edges",
  "torsional_friction",
  "edge_norm",
  "wrench_space",
  "torque_scale",
  "center_of_mass",
];

/** All grasps of a result; the first is the best one, or the nearest miss if none holds. */
export function choicesOf(result: PlanResult): Choice[] {
  const { contacts, quality, initial, top } = result;
  if (contacts.length === 0) {
    return [];
  }
  const title = quality === null ? "Nearest miss" : `Best: ε ${number(quality)}`;
  const choices: Choice[] = [{ name: "best", title, contacts, details: result }];
  top?.slice(1).forEach(({ quality, contacts }, index) => {
    const title = `Number ${index + 2}: ε ${number(quality)}`;
    choices.push({ name: String(index + 2), title, contacts, details: null });
  });
  if (initial !== null) {
    const title = `First found: ε ${number(initial.quality)}`;
    choices.push({ name: "initial", title, contacts: initial.contacts, details: null });
  }
  return choices;
}

/** Evaluates a grasp with the settings of its job, and runs the given analyses. */
export function evaluate(
  job: JobRecord,
  { contacts }: Choice,
  analyses: Record<string, unknown>,
  signal: AbortSignal,
): Promise<Evaluation> {
  const settings = SHARED.map((name) => [name, job.request[name]] as const);
  const given = settings.filter(([, value]) => value !== undefined && value !== null);
  return api.evaluate(
    {
      mesh_id: job.mesh_id,
      // On an edge, a point alone does not determine the normal.
      grasps: [contacts.map(({ position, normal }) => ({ point: position, normal }))],
      ...Object.fromEntries(given),
      ...analyses,
    },
    signal,
  );
}

/** Loads the details and forces of a grasp for which the result does not contain them. */
export async function loadDetails(
  job: JobRecord,
  choice: Choice,
  signal: AbortSignal,
): Promise<void> {
  const evaluation = await evaluate(job, choice, {}, signal);
  choice.contacts = choice.contacts.map((contact, index) => {
    const forces = evaluation.contacts[index]?.forces;
    return forces === undefined ? contact : { ...contact, forces };
  });
  choice.details = evaluation;
}

/** The grasp as the 3-D view draws it. */
export function sceneGrasp(result: PlanResult, { contacts, details }: Choice): SceneGrasp {
  const wrench = details?.weakest_wrench ?? null;
  return {
    contacts,
    friction: result.friction ?? null,
    contactModel: result.contact_model,
    centerOfMass: result.center_of_mass,
    ...(wrench === null ? {} : { weakest: { force: wrench.force, torque: wrench.torque } }),
  };
}
