/** What things mean, in plain words. */

import { place } from "./format";

/** The measures of a grasp besides ε, each with what it says. */
export const MEASURES: [name: string, title: string, meaning: string][] = [
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
    "How much of force and torque can be resisted on the whole, not only in the weakest direction. Greater is better.",
  ],
  [
    "smallest_singular_value",
    "Distance from singular",
    "Near zero there is a force or torque that the fingers hardly have any hold on. Greater is better.",
  ],
  [
    "isotropy",
    "Isotropy",
    "One when all directions are held alike, zero when one is not held at all.",
  ],
  [
    "ellipsoid_volume",
    "Volume of the wrench ellipsoid",
    "All the directions together, from the grasp matrix alone. Greater is better.",
  ],
  [
    "centroid_distance",
    "Distance to the centre of mass",
    "From the middle of the contacts, in the unit of the mesh. Less means less torque from gravity and inertia.",
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
  search: "Improving it",
  analysis: "Looking closer at the best grasp",
};

export const STOPS: Record<string, string> = {
  generation_limit: "all generations were run",
  local_optimum: "no single finger can be improved any more",
  evaluation_limit: "the evaluations were used up",
  target_quality: "the wanted quality was reached",
  time_limit: "the time was over",
  cancelled: "it was cancelled; what had been found is shown",
  impossible: "it is proven that nothing can be found",
  infeasible: "the constraints leave nothing to try",
};

export const METHODS: Record<string, string> = {
  memetic: "Memetic",
  modified_ga: "Genetic algorithm of the paper",
  local: "Local search",
  random: "Random grasps",
};

/** A grasp on a body of some size, for those who do not see it. */
export function graspWords(
  contacts: readonly { position: readonly number[] }[],
  size: number,
): string {
  const places = contacts.map(({ position }, index) => `${index + 1} at ${place(position, size)}`);
  return `A body held by ${contacts.length} fingers: ${places.join("; ")}.`;
}
