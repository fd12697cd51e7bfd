/** Edits the fixed fingers, whose positions are clicked on the body or typed. */

import type { Vec3 } from "../api/types";
import { h } from "../dom";
import type { Stage } from "../stage";
import { place } from "../text/format";

const AXES = ["x", "y", "z"];

export class FixedFingers {
  readonly element: HTMLElement;
  /** Positions in the frame of the mesh; the service moves each to the nearest point of the surface. */
  readonly places: Vec3[] = [];
  private readonly size: number;
  private readonly changed: () => void;
  private readonly button = h("button", { type: "button" }, "Fix a finger here");
  private readonly list = h("ul", { class: "plain" });
  private readonly inputs = AXES.map(() => h("input", { type: "number", step: "any" }));
  private readonly message = h("p", { class: "muted", "aria-live": "polite" });

  /** `size` is the extent of the body. */
  constructor(stage: Stage, size: number, changed: () => void) {
    this.size = size;
    this.changed = changed;
    this.button.addEventListener("click", () => {
      this.fixTyped();
    });
    for (const input of this.inputs) {
      input.addEventListener("input", () => {
        this.markPending(this.inputs.some(({ value }) => value !== ""));
      });
      // Enter must not submit the whole form.
      input.addEventListener("keydown", (event) => {
        if (event.key === "Enter") {
          event.preventDefault();
          this.fixTyped();
        }
      });
    }
    stage.onPick(({ triangle, position }) => {
      this.inputs.forEach((input, axis) => {
        input.value = String(position[axis]);
      });
      // A click may only have been a look, so it does not have to be fixed.
      this.markPending(false);
      this.message.textContent = `Triangle ${triangle} at ${place(position, this.size)}.`;
    });
    this.element = h(
      "div",
      {},
      h("h3", {}, "Fixed fingers"),
      h(
        "p",
        { class: "muted" },
        "Click the body, or type x, y and z: the finger is fixed at the nearest point of the surface.",
      ),
      this.list,
      h(
        "div",
        { class: "numbers" },
        ...this.inputs.map((input, axis) => h("label", {}, `${AXES[axis]} of the place`, input)),
      ),
      h("div", { class: "row" }, this.button),
      this.message,
    );
  }

  /** Adds a fixed finger. */
  fix(position: Vec3): void {
    this.places.push(position);
    const remove = h("button", { type: "button" }, "Remove");
    const item = h("li", {}, `At ${place(position, this.size)} `, remove);
    remove.addEventListener("click", () => {
      this.places.splice(this.places.indexOf(position), 1);
      item.remove();
      this.message.textContent = "";
      this.changed();
      this.button.focus();
    });
    this.list.append(item);
    this.changed();
  }

  /** Marks the position in the fields as one that must be fixed or removed before the form is sent. */
  private markPending(pending: boolean): void {
    const [first] = this.inputs;
    first?.setCustomValidity(
      pending ? "Fix the finger at this position, or clear the fields." : "",
    );
  }

  /** Fixes a finger at the position in the fields. */
  private fixTyped(): void {
    const missing = this.inputs.find((input) => input.value === "");
    if (missing !== undefined) {
      this.message.textContent = "A position has three numbers.";
      missing.focus();
      return;
    }
    const position = this.inputs.map((input) => Number(input.value)) as Vec3;
    for (const input of this.inputs) {
      input.value = "";
    }
    this.markPending(false);
    this.message.textContent = `Fixed at ${place(position, this.size)}.`;
    this.fix(position);
  }
}
