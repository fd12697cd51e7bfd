/** Fingers that are given: at places which are clicked on the body, or typed. */

import type { Vec3 } from "../api/types";
import { h } from "../dom";
import type { Stage } from "../stage";
import { place } from "../text/format";

const AXES = ["x", "y", "z"];

export class GivenFingers {
  readonly element: HTMLElement;
  /** Places in the frame of the mesh; the service takes the nearest of the surface. */
  readonly places: Vec3[] = [];
  private readonly size: number;
  private readonly changed: () => void;
  private readonly button = h("button", { type: "button" }, "Fix a finger here");
  private readonly list = h("ul", { class: "plain" });
  private readonly inputs = AXES.map(() => h("input", { type: "number", step: "any" }));
  private readonly said = h("p", { class: "muted", "aria-live": "polite" });

  /** Of a body of some size. */
  constructor(stage: Stage, size: number, changed: () => void) {
    this.size = size;
    this.changed = changed;
    this.button.addEventListener("click", () => {
      this.take();
    });
    for (const input of this.inputs) {
      input.addEventListener("input", () => {
        this.expect(this.inputs.some(({ value }) => value !== ""));
      });
      // Not yet the whole form.
      input.addEventListener("keydown", (event) => {
        if (event.key === "Enter") {
          event.preventDefault();
          this.take();
        }
      });
    }
    stage.onPick(({ triangle, position }) => {
      this.inputs.forEach((input, axis) => {
        input.value = String(position[axis]);
      });
      // Who clicks may only have looked.
      this.expect(false);
      this.said.textContent = `Triangle ${triangle} at ${place(position, this.size)}.`;
    });
    this.element = h(
      "div",
      {},
      h("h3", {}, "Fingers that are given"),
      h(
        "p",
        { class: "muted" },
        "Click the body, or type x, y and z: the nearest place on it counts.",
      ),
      this.list,
      h(
        "div",
        { class: "numbers" },
        ...this.inputs.map((input, axis) => h("label", {}, `${AXES[axis]} of the place`, input)),
      ),
      h("div", { class: "row" }, this.button),
      this.said,
    );
  }

  /** Gives a finger. */
  fix(position: Vec3): void {
    this.places.push(position);
    const remove = h("button", { type: "button" }, "Remove");
    const item = h("li", {}, `At ${place(position, this.size)} `, remove);
    remove.addEventListener("click", () => {
      this.places.splice(this.places.indexOf(position), 1);
      item.remove();
      this.said.textContent = "";
      this.changed();
      this.button.focus();
    });
    this.list.append(item);
    this.changed();
  }

  /** Whether a place is written that must not be passed over. */
  private expect(it: boolean): void {
    const [first] = this.inputs;
    first?.setCustomValidity(it ? "Fix the finger whose place is written here, or empty it." : "");
  }

  /** That at the place which is written. */
  private take(): void {
    const missing = this.inputs.find((input) => input.value === "");
    if (missing !== undefined) {
      this.said.textContent = "A place has three numbers.";
      missing.focus();
      return;
    }
    const position = this.inputs.map((input) => Number(input.value)) as Vec3;
    for (const input of this.inputs) {
      input.value = "";
    }
    this.expect(false);
    this.said.textContent = `Fixed at ${place(position, this.size)}.`;
    this.fix(position);
  }
}
