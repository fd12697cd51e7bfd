/** Edits the constraints: regions, which are drawn in the 3-D view, distances, and fixed fingers. */

import type { Constraints, Shape, Vec3 } from "../api/types";
import { h } from "../dom";
import type { SceneRegion } from "../scene";
import type { Stage } from "../stage";
import { decimals, extent } from "../text/format";
import { FixedFingers } from "./fingers";

type Kind = "box" | "half_space" | "sphere";

const KINDS: [Kind, string][] = [
  ["box", "Box"],
  ["half_space", "Half-space"],
  ["sphere", "Ball"],
];
/** Labels of the numbers of each kind, in order. */
const NUMBERS: Record<Kind, string[]> = {
  box: ["lowest x", "lowest y", "lowest z", "highest x", "highest y", "highest z"],
  half_space: ["point x", "point y", "point z", "normal x", "normal y", "normal z"],
  sphere: ["centre x", "centre y", "centre z", "radius"],
};
const USES = ["include", "exclude"] as const;

interface Row {
  element: HTMLElement;
  region: () => SceneRegion;
}

export class ConstraintsEditor {
  readonly element: HTMLElement;
  private readonly stage: Stage;
  private readonly bounds: [Vec3, Vec3];
  private readonly changed: () => void;
  private readonly rows: Row[] = [];
  private readonly list = h("div");
  private readonly adder = h("button", { type: "button" }, "Add region");
  private readonly fingers: FixedFingers;
  private readonly least: HTMLInputElement;
  private readonly most: HTMLInputElement;
  /** Constraints for which the form has no fields. */
  private kept: Constraints = {};
  private readonly keptNote = h("p", { class: "muted" });

  constructor(stage: Stage, bounds: [Vec3, Vec3], changed: () => void) {
    this.stage = stage;
    this.bounds = bounds;
    this.changed = (): void => {
      this.draw();
      changed();
    };
    this.fingers = new FixedFingers(stage, extent(bounds), this.changed);
    const kind = h(
      "select",
      { "aria-label": "Kind of region" },
      ...KINDS.map(([value, title]) => h("option", { value }, title)),
    );
    this.adder.addEventListener("click", () => {
      const chosen = kind.value as Kind;
      this.add(chosen, "exclude", this.start(chosen)).focus();
    });
    const distance = (id: string): HTMLInputElement => {
      const input = h("input", { type: "number", step: "any", id, placeholder: "none" });
      input.addEventListener("input", changed);
      return input;
    };
    this.least = distance("min-distance");
    this.most = distance("max-distance");
    this.element = h(
      "div",
      {},
      h(
        "p",
        { class: "muted" },
        "Regions that fingers must avoid or stay within, in the frame of the mesh.",
      ),
      this.list,
      h("div", { class: "row" }, kind, this.adder),
      h(
        "div",
        { class: "pair" },
        h(
          "div",
          { class: "field" },
          h("label", { for: "min-distance" }, "Least distance between fingers"),
          this.least,
        ),
        h(
          "div",
          { class: "field" },
          h("label", { for: "max-distance" }, "Greatest distance (span of the hand)"),
          this.most,
        ),
      ),
      this.fingers.element,
      this.keptNote,
    );
  }

  /** The constraints of the request; undefined if there are none. */
  get value(): Constraints | undefined {
    const value: Constraints = {};
    const regions = this.rows.map((row) => row.region());
    for (const use of USES) {
      const shapes = regions.filter((region) => region.use === use).map(({ shape }) => shape);
      const all = [...shapes, ...(this.kept[use] ?? [])];
      if (all.length > 0) {
        value[use] = all;
      }
    }
    if (this.least.value !== "") {
      value.min_contact_distance = Number(this.least.value);
    }
    if (this.most.value !== "") {
      value.max_contact_distance = Number(this.most.value);
    }
    const given = this.fingers.places.map((point) => ({ point }));
    const fixed = [...given, ...(this.kept.fixed_contacts ?? [])];
    if (fixed.length > 0) {
      value.fixed_contacts = fixed;
    }
    const all = { ...this.kept, ...value };
    return Object.keys(all).length > 0 ? all : undefined;
  }

  /** Fills the form. */
  fill(constraints: Constraints): void {
    const {
      min_contact_distance: least,
      max_contact_distance: most,
      fixed_contacts: fixed = [],
      ...kept
    } = constraints;
    const others = fixed.filter((contact) => !isPlace(contact));
    const regions = drawnRegions(constraints);
    for (const use of USES) {
      kept[use] = (kept[use] ?? []).filter((shape) => !isDrawn(shape));
    }
    const left = Object.entries({ ...kept, fixed_contacts: others }).filter(
      ([, value]) => !(Array.isArray(value) && value.length === 0),
    );
    // First, because each of the following reports a change, for which the value must be complete.
    this.kept = Object.fromEntries(left);
    this.showKept();
    this.least.value = String(least ?? "");
    this.most.value = String(most ?? "");
    for (const { use, shape } of regions) {
      const [kind, numbers] = numbersOf(shape);
      this.add(kind, use, numbers);
    }
    for (const { point } of fixed.filter(isPlace)) {
      this.fingers.fix(point);
    }
  }

  /** Shows the regions, and fixed fingers as small balls, in the 3-D view. */
  draw(): void {
    const radius = 0.015 * extent(this.bounds);
    const fixed = this.fingers.places.map((center) => ({
      use: "include" as const,
      shape: { sphere: { center, radius } },
    }));
    const regions = [...this.rows.map((row) => row.region()), ...fixed];
    this.stage.setRegions(regions.filter(({ shape }) => numbersOf(shape)[1].every(isUsable)));
  }

  private showKept(): void {
    const names = Object.keys(this.kept);
    if (names.length === 0) {
      this.keptNote.replaceChildren();
      return;
    }
    const remove = h("button", { type: "button" }, "Remove");
    remove.addEventListener("click", () => {
      this.kept = {};
      this.showKept();
      this.changed();
    });
    this.keptNote.replaceChildren(
      `Taken over from the previous job, without fields here: ${names.join(", ")}. `,
      remove,
    );
  }

  /** Adds a region and returns its first control. */
  private add(kind: Kind, begin: SceneRegion["use"], numbers: readonly number[]): HTMLElement {
    const use = h(
      "select",
      { "aria-label": "Use of the region" },
      h("option", { value: "exclude" }, "keep out of"),
      h("option", { value: "include" }, "keep within"),
    );
    use.value = begin;
    const inputs = numbers.map((value) =>
      h("input", { type: "number", step: "any", required: true, value }),
    );
    const remove = h("button", { type: "button" }, "Remove");
    const title = KINDS.find(([name]) => name === kind)?.[1] ?? kind;
    const element = h(
      "fieldset",
      { class: "region" },
      h("legend", {}, title),
      use,
      h(
        "div",
        { class: "numbers" },
        ...inputs.map((input, index) => h("label", {}, NUMBERS[kind][index], input)),
      ),
      remove,
    );
    const row: Row = {
      element,
      region: () => ({
        use: use.value === "include" ? "include" : "exclude",
        shape: shapeOf(
          kind,
          inputs.map((input) => Number(input.value)),
        ),
      }),
    };
    element.addEventListener("input", this.changed);
    remove.addEventListener("click", () => {
      this.rows.splice(this.rows.indexOf(row), 1);
      element.remove();
      this.changed();
      this.adder.focus();
    });
    this.rows.push(row);
    this.list.append(element);
    this.changed();
    return use;
  }

  /** The initial numbers of a region: about the upper half of the body. */
  private start(kind: Kind): number[] {
    const [low, high] = this.bounds;
    const size = extent(this.bounds);
    const middle = low.map((x, axis) => (x + (high[axis] ?? 0)) / 2) as Vec3;
    const rounded = (value: number): number => Number(value.toFixed(decimals(size)));
    // A little more than the body, so that the box contains its faces.
    const margin = 0.01 * size;
    const numbers = {
      box: [low[0] - margin, low[1] - margin, middle[2], ...high.map((value) => value + margin)],
      half_space: [...middle, 0, 0, 1],
      sphere: [middle[0], middle[1], high[2], size / 4],
    }[kind];
    return numbers.map(rounded);
  }
}

/** Whether a fixed contact is given by a point alone. */
const isPlace = (contact: { point?: Vec3 }): contact is { point: Vec3 } =>
  contact.point !== undefined && Object.keys(contact).length === 1;

/** The regions of a request that can be drawn. */
export function drawnRegions(constraints: Constraints): SceneRegion[] {
  return USES.flatMap((use) =>
    (constraints[use] ?? []).filter(isDrawn).map((shape) => ({ use, shape })),
  );
}

/** Whether the service accepts a coordinate; greater ones cannot be drawn either. */
const isUsable = (value: number): boolean => Math.abs(value) <= 1e12;

const isDrawn = (shape: Shape | { triangles: number[] }): shape is Shape => !("triangles" in shape);

function numbersOf(shape: Shape): [Kind, number[]] {
  if ("box" in shape) {
    return ["box", [...shape.box.min, ...shape.box.max]];
  }
  if ("half_space" in shape) {
    return ["half_space", [...shape.half_space.point, ...shape.half_space.normal]];
  }
  return ["sphere", [...shape.sphere.center, shape.sphere.radius]];
}

function shapeOf(kind: Kind, numbers: readonly number[]): Shape {
  const [a = 0, b = 0, c = 0, d = 0, e = 0, f = 0] = numbers;
  switch (kind) {
    case "box":
      return { box: { min: [a, b, c], max: [d, e, f] } };
    case "half_space":
      return { half_space: { point: [a, b, c], normal: [d, e, f] } };
    case "sphere":
      return { sphere: { center: [a, b, c], radius: d } };
  }
}
