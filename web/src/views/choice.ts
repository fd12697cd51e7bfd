/** The grasps of a result, one of which is shown. */

import * as api from "../api/client";
import type { Contact, Evaluation, JobRecord, PlanResult, WeakestWrench } from "../api/types";
import type { SceneGrasp } from "../scene";
import { number } from "../text/format";

/** What is told of a grasp besides its contacts. */
export interface Told {
  weakest_wrench: WeakestWrench | null;
  measures?: Record<string, number | null> | null;
  robustness?: PlanResult["robustness"];
}

/** One of the grasps of a result. */
export interface Choice {
  /** As the service's pictures and exports name it. */
  readonly name: string;
  readonly title: string;
  /** With forces once it has been evaluated. */
  contacts: Contact[];
  /** A result tells it of the best grasp only. */
  told: Told | null;
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

/** All grasps of a result, the best or what came nearest first. */
export function choicesOf(result: PlanResult): Choice[] {
  const { contacts, quality, initial, top } = result;
  if (contacts.length === 0) {
    return [];
  }
  const title = quality === null ? "What came nearest" : `Best: ε ${number(quality)}`;
  const choices: Choice[] = [{ name: "best", title, contacts, told: result }];
  top?.slice(1).forEach(({ quality, contacts }, index) => {
    const title = `Number ${index + 2}: ε ${number(quality)}`;
    choices.push({ name: String(index + 2), title, contacts, told: null });
  });
  if (initial !== null) {
    const title = `First found: ε ${number(initial.quality)}`;
    choices.push({ name: "initial", title, contacts: initial.contacts, told: null });
  }
  return choices;
}

/** What a grasp is worth by the settings of its job, and what else is asked about it. */
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
      // At an edge a place alone would not tell the normal.
      grasps: [contacts.map(({ position, normal }) => ({ point: position, normal }))],
      ...Object.fromEntries(given),
      ...analyses,
    },
    signal,
  );
}

/** Has the service tell of a grasp what its result does not. */
export async function learn(job: JobRecord, choice: Choice, signal: AbortSignal): Promise<void> {
  const evaluation = await evaluate(job, choice, {}, signal);
  choice.contacts = choice.contacts.map((contact, index) => {
    const forces = evaluation.contacts[index]?.forces;
    return forces === undefined ? contact : { ...contact, forces };
  });
  choice.told = evaluation;
}

/** As it is drawn. */
export function sceneGrasp(result: PlanResult, { contacts, told }: Choice): SceneGrasp {
  const wrench = told?.weakest_wrench ?? null;
  return {
    contacts,
    friction: result.friction ?? null,
    contactModel: result.contact_model,
    centerOfMass: result.center_of_mass,
    ...(wrench === null ? {} : { weakest: { force: wrench.force, torque: wrench.torque } }),
  };
}
