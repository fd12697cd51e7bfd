/** The settings of a planning request that the page offers, each with what it means. */

import { h, replace } from "../dom";

export interface Field {
  name: string;
  label: string;
  help: string;
  kind: "integer" | "number" | "text" | "choice";
  /** What is sent for each choice; the first is sent as nothing, which is the service's default. */
  choices?: [value: string, title: string][];
  placeholder?: string;
  step?: string;
  advanced?: boolean;
  /** Says how long to look for a grasp, not what is wanted of it. */
  effort?: boolean;
}

export const FIELDS: Field[] = [
  {
    name: "contact_model",
    label: "Kind of contact",
    kind: "choice",
    choices: [
      ["hard", "Hard fingertip with friction"],
      ["soft", "Soft fingertip: also holds against turning on the spot"],
      ["frictionless", "No friction, as a locator of a fixture"],
    ],
    help: "What a finger can do where it touches.",
  },
  {
    name: "contacts",
    label: "Fingers",
    kind: "integer",
    placeholder: "4; 7 without friction",
    help: "With friction three or four are usual. Without, seven are needed to hold any body.",
  },
  {
    name: "friction",
    label: "Friction μ",
    kind: "number",
    placeholder: "0.5",
    step: "0.05",
    help: "Rubber on wood about 0.8, plastic on metal about 0.3. More friction makes every grasp better.",
  },
  {
    name: "method",
    label: "Search",
    kind: "choice",
    choices: [
      ["memetic", "Memetic: the best known, with a proof that no single finger does better"],
      ["modified_ga", "Genetic algorithm of the paper"],
      ["local", "Local search: one finger after the other"],
      ["random", "Random grasps, to compare with"],
    ],
    help: "How the grasp is looked for.",
  },
  {
    name: "time_limit_s",
    label: "Time limit, seconds",
    kind: "number",
    placeholder: "none",
    help: "What has been found by then is kept.",
    effort: true,
  },
  {
    name: "label",
    label: "Label",
    kind: "text",
    placeholder: "none",
    help: "A name to find the job again.",
  },
  {
    name: "top",
    label: "Different grasps to show",
    kind: "integer",
    placeholder: "1",
    help: "The best grasp and others whose contacts are elsewhere.",
    advanced: true,
  },
  {
    name: "seed",
    label: "Seed",
    kind: "integer",
    placeholder: "at random",
    help: "The same mesh, settings and seed give the same grasp again.",
    advanced: true,
    effort: true,
  },
  {
    name: "generations",
    label: "Generations",
    kind: "integer",
    placeholder: "25; 100 for other searches",
    help: "How long the search goes on.",
    advanced: true,
    effort: true,
  },
  {
    name: "population",
    label: "Population",
    kind: "integer",
    placeholder: "8; 200 for other searches",
    help: "How many grasps are improved side by side.",
    advanced: true,
    effort: true,
  },
  {
    name: "target_quality",
    label: "Good enough",
    kind: "number",
    placeholder: "none",
    help: "Quality ε at which the search ends early.",
    advanced: true,
    effort: true,
  },
  {
    name: "cone_edges",
    label: "Edges of the friction cone",
    kind: "integer",
    placeholder: "8",
    help: "The cone is replaced by a pyramid of so many edges; 0 is the round cone itself.",
    advanced: true,
  },
  {
    name: "torsional_friction",
    label: "Torsional friction of soft fingers",
    kind: "number",
    placeholder: "a twentieth of the body's radius",
    help: "A length in the unit of the mesh: greatest torque about the normal over the force.",
    advanced: true,
  },
  {
    name: "wrench_space",
    label: "Forces of the fingers",
    kind: "choice",
    choices: [
      ["l1", "All together have a force of one"],
      ["linf", "Each has a force of one"],
    ],
    help: "What the quality is measured against.",
    advanced: true,
  },
  {
    name: "edge_norm",
    label: "Length of cone edges",
    kind: "choice",
    choices: [
      ["unit_edge", "One along the edge (the paper)"],
      ["unit_normal", "One along the normal (GraspIt!)"],
    ],
    help: "Only changes the scale of ε.",
    advanced: true,
  },
  {
    name: "torque_scale",
    label: "Torque scale",
    kind: "text",
    placeholder: "max_radius",
    help: "max_radius makes ε free of units; none takes torques as they are; or a number, one over a length.",
    advanced: true,
  },
];

const INEXACT = "A browser keeps whole numbers exactly up to 9007199254740991 only.";

/** A field as people fill it in, and where an error about it is told. */
export class FieldControl {
  readonly element: HTMLElement;
  private readonly field: Field;
  private readonly input: HTMLInputElement | HTMLSelectElement;
  private readonly error: HTMLElement;

  constructor(field: Field, changed: () => void) {
    this.field = field;
    const id = `field-${field.name}`;
    const [help, error] = [`${id}-help`, `${id}-error`];
    const described = { id, name: field.name, "aria-describedby": `${help} ${error}` };
    this.input =
      field.kind === "choice"
        ? h(
            "select",
            described,
            ...(field.choices ?? []).map(([value, title]) => h("option", { value }, title)),
          )
        : h("input", {
            ...described,
            type: field.kind === "text" ? "text" : "number",
            step: field.kind === "integer" ? "1" : (field.step ?? "any"),
            placeholder: field.placeholder,
            autocomplete: "off",
          });
    this.input.addEventListener("input", () => {
      this.input.setCustomValidity(this.isInexact() ? INEXACT : "");
      changed();
    });
    this.error = h("p", { id: error, class: "field-error" });
    this.element = h(
      "div",
      { class: "field" },
      h("label", { for: id }, field.label),
      this.input,
      h("small", { id: help }, field.help),
      this.error,
    );
  }

  /** Whether the browser would send another number than the one that is written. */
  private isInexact(): boolean {
    const value = Number(this.input.value);
    return this.field.kind === "integer" && Number.isInteger(value) && !Number.isSafeInteger(value);
  }

  get name(): string {
    return this.field.name;
  }

  /** As the service takes it; nothing where its default is meant. */
  get value(): unknown {
    const text = this.input.value.trim();
    if (text === "" || (this.field.kind === "choice" && text === this.field.choices?.[0]?.[0])) {
      return undefined;
    }
    // The service says what is wrong with a text that is no number.
    const isNumber = this.field.kind !== "text" || this.field.name === "torque_scale";
    return isNumber && this.field.kind !== "choice" && Number.isFinite(Number(text))
      ? Number(text)
      : text;
  }

  /** Begins with a value. */
  fill(text: string): void {
    this.input.value = text;
  }

  show(error: string | null): void {
    replace(this.error, error);
    this.input.setAttribute("aria-invalid", String(error !== null));
  }

  focus(): void {
    this.input.focus();
  }

  set hidden(hidden: boolean) {
    this.element.hidden = hidden;
  }
}
