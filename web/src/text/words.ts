/** Texts for names and values of the service. */

import type { Measures } from "../api/types";
import { place } from "./format";

/** The measures of a grasp, each with a title and an explanation. */
export const MEASURES: [
  name: Exclude<keyof Measures, "epsilon_exact">,
  title: string,
  meaning: string,
][] = [
  [
    "epsilon_l1",
    "ε, forces shared",
    "The least disturbance that can break the grasp when all fingers together push with a force of one. Greater is better.",
  ],
  [
    "epsilon_linf",
    "ε, each finger at full force",
    "The same when every finger may push with a force of one by itself. Greater is better.",
  ],
  [
    "volume_l1",
    "Volume of wrenches",
    "How much force and torque can be resisted overall, not only in the weakest direction. Greater is better.",
  ],
  [
    "smallest_singular_value",
    "Distance from singular",
    "Near zero, there is a force or torque that the fingers can hardly resist. Greater is better.",
  ],
  [
    "isotropy",
    "Isotropy",
    "One when all directions are held equally well, zero when one is not held at all.",
  ],
  [
    "ellipsoid_volume",
    "Volume of the wrench ellipsoid",
    "All directions together, from the grasp matrix alone. Greater is better.",
  ],
  [
    "centroid_distance",
    "Distance to the centre of mass",
    "From the centroid of the contacts, in the unit of the mesh. Less means less torque from gravity and inertia.",
  ],
  [
    "polygon_area",
    "Area of the contact polygon",
    "Contacts far apart resist torques better. In the unit of the mesh, squared.",
  ],
  [
    "polygon_shape",
    "Irregularity of the contact polygon",
    "Zero when the contacts are a regular polygon, one when they are nearly in a line.",
  ],
];

export const STATES: Record<string, string> = {
  queued: "Waiting",
  running: "Searching",
  succeeded: "Done",
  failed: "Failed",
  cancelled: "Cancelled",
};

export const PHASES: Record<string, string> = {
  preparing: "Reading the mesh",
  initial: "Looking for a first grasp that holds",
  search: "Improving the grasp",
  analysis: "Analysing the best grasp",
};

export const STOPS: Record<string, string> = {
  generation_limit: "all generations were run",
  local_optimum: "no single finger can be improved further",
  evaluation_limit: "the evaluation limit was reached",
  target_quality: "the target quality was reached",
  time_limit: "the time limit was reached",
  cancelled: "it was cancelled; the best grasp found by then is shown",
  impossible: "it is proven that no such grasp exists",
  infeasible: "no grasp satisfies the constraints",
};

export const METHODS: Record<string, string> = {
  memetic: "Memetic",
  modified_ga: "Genetic algorithm of the paper",
  local: "Local search",
  random: "Random grasps",
};

/** Describes a grasp on a body of the given size, for screen readers. */
export function graspWords(
  contacts: readonly { position: readonly number[] }[],
  size: number,
): string {
  const places = contacts.map(({ position }, index) => `${index + 1} at ${place(position, size)}`);
  return `A body held by ${contacts.length} fingers: ${places.join("; ")}.`;
}
