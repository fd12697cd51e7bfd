/** Colours the triangles to which each finger may move while the others stay. */

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
  private readonly message = h("div", { "aria-live": "polite" });
  private request = new AbortController();

  /** `surface` settles once the body of the job is shown. */
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
      h("label", { class: "toggle" }, this.box, "Colour where each finger may be moved alone"),
      h(
        "small",
        { class: "muted" },
        "One finger may move to the centroid of any triangle of its colour while the others stay, and at least half " +
          "of the quality remains. On a large triangle less may remain towards its edges.",
      ),
      this.message,
    );
  }

  clear(): void {
    this.request.abort();
    this.box.checked = false;
    this.context.stage.setColors(null);
    replace(this.message);
  }

  private async color(choice: Choice): Promise<void> {
    this.request.abort();
    this.request = new AbortController();
    const signal = AbortSignal.any([this.context.signal, this.request.signal]);
    replace(this.message, h("p", { class: "muted" }, "Evaluating every triangle…"));
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
        this.message,
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
        replace(this.message, problemBox(error));
      }
    }
  }
}
