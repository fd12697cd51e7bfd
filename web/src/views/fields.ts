/** The settings of a planning request that the page offers. */

import { h, replace } from "../dom";
import definitions from "../settings.json";

/** How the page shows a setting; its meaning and range are in its definition. */
interface Shown {
  name: string;
  label: string;
  /** Step of the arrows of a number field. */
  step?: string;
  advanced?: boolean;
  /** Whether it controls how long the search runs, rather than which grasp is sought. */
  effort?: boolean;
}

const SHOWN: Shown[] = [
  { name: "contact_model", label: "Kind of contact" },
  { name: "contacts", label: "Fingers" },
  { name: "friction", label: "Friction μ", step: "0.05" },
  { name: "method", label: "Search" },
  { name: "time_limit_s", label: "Time limit, seconds", effort: true },
  { name: "label", label: "Label" },
  { name: "top", label: "Different grasps to show", advanced: true },
  { name: "seed", label: "Seed", advanced: true, effort: true },
  { name: "generations", label: "Generations", advanced: true, effort: true },
  { name: "population", label: "Population", advanced: true, effort: true },
  { name: "target_quality", label: "Good enough", advanced: true, effort: true },
  { name: "cone_edges", label: "Edges of the friction cone", advanced: true },
  { name: "torsional_friction", label: "Torsional friction of soft fingers", advanced: true },
  { name: "wrench_space", label: "Forces of the fingers", advanced: true },
  { name: "edge_norm", label: "Length of cone edges", advanced: true },
  { name: "torque_scale", label: "Torque scale", advanced: true },
];

/** A setting as the service defines it, and as the page shows it. */
export interface Field extends Shown {
  kind: string;
  help: string;
  /** The default as text. */
  default: string;
  min?: number;
  max?: number;
  /** Each name with its title; the first is the default, which is omitted from requests. */
  choices: string[][];
}

export const FIELDS: Field[] = SHOWN.map((shown) => {
  const definition = definitions.find(({ name }) => name === shown.name);
  if (definition === undefined) {
    throw new Error(`${shown.name} is not a setting`);
  }
  return { ...definition, ...shown };
});

const INEXACT = "Browsers represent whole numbers exactly only up to 9007199254740991.";

const isNumber = ({ kind }: Field): boolean => kind === "integer" || kind === "number";

/** The control of a setting, with its help text and a place for its error. */
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
            ...field.choices.map(([value, title]) =>
              h("option", { value: value ?? "" }, title ?? ""),
            ),
          )
        : h("input", {
            ...described,
            type: isNumber(field) ? "number" : "text",
            step: field.kind === "integer" ? "1" : (field.step ?? "any"),
            min: field.min,
            max: field.max,
            placeholder: field.default,
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

  /** Whether the browser would send a different number from the one in the field. */
  private isInexact(): boolean {
    const value = Number(this.input.value);
    return this.field.kind === "integer" && Number.isInteger(value) && !Number.isSafeInteger(value);
  }

  get name(): string {
    return this.field.name;
  }

  /** The value for the request; undefined for the default. */
  get value(): unknown {
    const text = this.input.value.trim();
    if (text === "" || (this.field.kind === "choice" && text === this.field.choices[0]?.[0])) {
      return undefined;
    }
    // A text that is not a number is sent as it is: the service explains what is wrong with it.
    const mayBeNumber = isNumber(this.field) || this.field.kind === "name or number";
    return mayBeNumber && Number.isFinite(Number(text)) ? Number(text) : text;
  }

  /** Sets the value. */
  fill(text: string): void {
    this.input.value = text;
  }

  showError(error: string | null): void {
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
