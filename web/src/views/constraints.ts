/** Where fingers may be: regions, which are shown in the scene, distances, and fingers that are given. */

import type { Shape, Vec3 } from "../api/types";
import { h } from "../dom";
import type { Hit, SceneRegion } from "../scene";
import type { Stage } from "../stage";
import { vector } from "../text/format";

type Kind = "box" | "half_space" | "sphere";

const KINDS: [Kind, string][] = [
  ["box", "Box"],
  ["half_space", "Half-space"],
  ["sphere", "Ball"],
];
/** Names of the numbers of each kind, in their order. */
const NUMBERS: Record<Kind, string[]> = {
  box: ["lowest x", "lowest y", "lowest z", "highest x", "highest y", "highest z"],
  half_space: ["point x", "point y", "point z", "normal x", "normal y", "normal z"],
  sphere: ["centre x", "centre y", "centre z", "radius"],
};

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
  private readonly fixed: Vec3[] = [];
  private readonly fixedList = h("ul", { class: "plain" });
  private readonly least: HTMLInputElement;
  private readonly most: HTMLInputElement;

  constructor(stage: Stage, bounds: [Vec3, Vec3], changed: () => void) {
    this.stage = stage;
    this.bounds = bounds;
    this.changed = changed;
    const kind = h(
      "select",
      { "aria-label": "Kind of region" },
      ...KINDS.map(([value, title]) => h("option", { value }, title)),
    );
    const add = h("button", { type: "button" }, "Add region");
    add.addEventListener("click", () => {
      this.add(kind.value as Kind);
    });
    const distance = (id: string): HTMLInputElement => {
      const input = h("input", { type: "number", step: "any", id, placeholder: "none" });
      input.addEventListener("input", changed);
      return input;
    };
    this.least = distance("min-distance");
    this.most = distance("max-distance");
    const picked = h(
      "p",
      { class: "muted", "aria-live": "polite" },
      "Click the body to fix a finger there.",
    );
    stage.onPick((hit) => {
      this.offer(picked, hit);
    });
    this.element = h(
      "div",
      {},
      h(
        "p",
        { class: "muted" },
        "Regions to keep fingers out of, or to keep them within, in the frame of the mesh.",
      ),
      this.list,
      h("div", { class: "row" }, kind, add),
      h(
        "div",
        { class: "pair" },
        h(
          "div",
          { class: "field" },
          h("label", { for: "min-distance" }, "Least distance of two fingers"),
          this.least,
        ),
        h(
          "div",
          { class: "field" },
          h("label", { for: "max-distance" }, "Greatest, the span of the hand"),
          this.most,
        ),
      ),
      h("h4", {}, "Fingers that are given"),
      this.fixedList,
      picked,
    );
  }

  /** As the service takes it; nothing where there is none. */
  get value(): Record<string, unknown> | undefined {
    const regions = this.rows.map((row) => row.region());
    const shapes = (use: string): Shape[] =>
      regions.filter((region) => region.use === use).map((region) => region.shape);
    const value: Record<string, unknown> = {};
    for (const [name, list] of [
      ["include", shapes("include")],
      ["exclude", shapes("exclude")],
      ["fixed_contacts", this.fixed.map((point) => ({ point }))],
    ] as const) {
      if (list.length > 0) {
        value[name] = list;
      }
    }
    for (const [name, input] of [
      ["min_contact_distance", this.least],
      ["max_contact_distance", this.most],
    ] as const) {
      if (input.value !== "") {
        value[name] = Number(input.value);
      }
    }
    return Object.keys(value).length > 0 ? value : undefined;
  }

  /** Shows the regions, and where fingers are fixed as small balls, in the scene. */
  draw(): void {
    const [low, high] = this.bounds;
    const radius = 0.015 * Math.hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]);
    const fixed = this.fixed.map((center) => ({
      use: "include" as const,
      shape: { sphere: { center, radius } },
    }));
    this.stage.setRegions([...this.rows.map((row) => row.region()), ...fixed]);
  }

  private add(kind: Kind): void {
    const use = h(
      "select",
      { "aria-label": "Use of the region" },
      h("option", { value: "exclude" }, "keep out of"),
      h("option", { value: "include" }, "keep within"),
    );
    const inputs = this.start(kind).map((value, index) =>
      h("input", {
        type: "number",
        step: "any",
        required: true,
        value: Number(value.toPrecision(4)),
        "aria-label": NUMBERS[kind][index],
        title: NUMBERS[kind][index],
      }),
    );
    const remove = h("button", { type: "button" }, "Remove");
    const title = KINDS.find(([name]) => name === kind)?.[1] ?? kind;
    const element = h(
      "fieldset",
      { class: "region" },
      h("legend", {}, title),
      use,
      h("div", { class: "numbers" }, ...inputs),
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
    const update = (): void => {
      this.draw();
      this.changed();
    };
    element.addEventListener("input", update);
    remove.addEventListener("click", () => {
      this.rows.splice(this.rows.indexOf(row), 1);
      element.remove();
      update();
    });
    this.rows.push(row);
    this.list.append(element);
    update();
    use.focus();
  }

  /** The upper half of the body, to begin with. */
  private start(kind: Kind): number[] {
    const [low, high] = this.bounds;
    const middle = low.map((x, axis) => (x + (high[axis] ?? 0)) / 2) as Vec3;
    const size = Math.hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]);
    switch (kind) {
      case "box":
        return [low[0], low[1], middle[2], ...high];
      case "half_space":
        return [...middle, 0, 0, 1];
      case "sphere":
        return [middle[0], middle[1], high[2], size / 4];
    }
  }

  private offer(host: HTMLElement, hit: Hit): void {
    const keep = h("button", { type: "button" }, "Fix a finger here");
    keep.addEventListener("click", () => {
      const { position } = hit;
      this.fixed.push(position);
      const remove = h("button", { type: "button" }, "Remove");
      const item = h("li", {}, `At ${vector(position)} `, remove);
      const update = (): void => {
        this.draw();
        this.changed();
      };
      remove.addEventListener("click", () => {
        this.fixed.splice(this.fixed.indexOf(position), 1);
        item.remove();
        update();
      });
      this.fixedList.append(item);
      update();
      host.replaceChildren("Fixed. Click elsewhere to fix another.");
    });
    host.replaceChildren(`Triangle ${hit.triangle} at ${vector(hit.position)} `, keep);
  }
}

export function shapeOf(kind: Kind, numbers: readonly number[]): Shape {
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
