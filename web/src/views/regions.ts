/** The colours of the triangles that each finger of a grasp may move to alone. */

import type { JobRecord } from "../api/types";
import { h, replace } from "../dom";
import { count } from "../text/format";
import { type Choice, evaluate } from "./choice";
import { type Context, problemBox } from "./context";

export class RegionColors {
  readonly element: HTMLElement;
  private readonly context: Context;
  private readonly job: JobRecord;
  private readonly surface: Promise<void>;
  private readonly box = h("input", { type: "checkbox" });
  private readonly said = h("div", { "aria-live": "polite" });
  private asked = new AbortController();

  /** Of a job whose body is there once `surface` is settled. */
  constructor(
    context: Context,
    job: JobRecord,
    surface: Promise<void>,
    chosen: () => Choice | undefined,
  ) {
    this.context = context;
    this.job = job;
    this.surface = surface;
    this.box.addEventListener("change", () => {
      const choice = chosen();
      if (this.box.checked && choice !== undefined) {
        void this.color(choice);
      } else {
        this.clear();
      }
    });
    this.element = h(
      "div",
      {},
      h("label", { class: "toggle" }, this.box, "Colour where each finger may be alone"),
      h(
        "small",
        { class: "muted" },
        "One finger may move to the middle of any triangle of its colour, while the others stay, and at least half " +
          "of the quality is left. On a large triangle less may be left towards its edges.",
      ),
      this.said,
    );
  }

  clear(): void {
    this.asked.abort();
    this.box.checked = false;
    this.context.stage.setColors(null);
    replace(this.said);
  }

  private async color(choice: Choice): Promise<void> {
    this.asked.abort();
    this.asked = new AbortController();
    const signal = AbortSignal.any([this.context.signal, this.asked.signal]);
    replace(this.said, h("p", { class: "muted" }, "Deciding every triangle…"));
    try {
      const analyses = { independent_regions: {} };
      const { independent_regions } = await evaluate(this.job, choice, analyses, signal);
      const regions = independent_regions ?? [];
      await this.surface;
      if (signal.aborted) {
        return;
      }
      this.context.stage.setColors(regions.map((region) => region.triangles));
      const words = regions.map((region, i) => `finger ${i + 1}: ${count(region.count)} triangles`);
      replace(
        this.said,
        h(
          "p",
          { class: "muted" },
          `${words.join(", ")}.`,
          regions.some((region) => region.truncated) && " Too many to colour all.",
        ),
      );
    } catch (error) {
      if (!signal.aborted) {
        this.clear();
        replace(this.said, problemBox(error));
      }
    }
  }
}
