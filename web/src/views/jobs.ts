/** A list of the newest jobs, each with a picture. */

import * as api from "../api/client";
import type { JobRecord } from "../api/types";
import { h, replace, showBlob } from "../dom";
import { jobLink } from "../routes";
import { ago, number } from "../text/format";
import { STATES } from "../text/words";
import { theme } from "../theme";
import { type Context, problemBox } from "./context";

/** Number of jobs shown at first, and added each time. */
const PAGE = 8;
/** Most jobs that are shown. */
const MAX_SHOWN = 200;
/** Interval of updates while jobs wait or run, in milliseconds. */
const INTERVAL = 3000;

/** Jobs and pictures that do not exist, because the mesh was deleted or no grasp was found. */
const missing = new Set<string>();

/** Shows the list in `host` and updates it until the user leaves the view. */
export async function recentJobs(context: Context, host: HTMLElement): Promise<void> {
  const { signal } = context;
  const list = h("ul", { class: "jobs" });
  const more = h("button", { type: "button", hidden: true }, "Show more");
  const message = h("div");
  const items = new Map<string, Item>();
  let limit = PAGE;
  let timer: ReturnType<typeof setTimeout> | undefined;
  let loading = new AbortController();
  let refused = "";
  const show = (jobs: readonly JobRecord[]): void => {
    for (const [index, job] of jobs.entries()) {
      let item = items.get(job.id);
      if (item === undefined) {
        item = new Item(job.id, signal);
        items.set(job.id, item);
      }
      item.show(job);
      // An element that is already in its place stays untouched, because it may have the focus.
      if (list.children[index] !== item.element) {
        list.insertBefore(item.element, list.children[index] ?? null);
      }
    }
    [...list.children].slice(jobs.length).forEach((element) => {
      element.remove();
    });
    refused = "";
    replace(message, jobs.length === 0 && h("p", { class: "muted" }, "None yet."));
  };
  const load = async (): Promise<void> => {
    clearTimeout(timer);
    loading.abort();
    const current = (loading = new AbortController()).signal;
    try {
      const page = await api.jobs(limit, AbortSignal.any([signal, current]));
      more.hidden = page.next_cursor === undefined || limit === MAX_SHOWN;
      show(page.jobs);
      if (page.jobs.some(({ state }) => state === "queued" || state === "running")) {
        scheduleUpdate();
      }
    } catch (error) {
      if (!signal.aborted && !current.aborted) {
        // Shown once, not at each update.
        if (refused !== String(error)) {
          refused = String(error);
          replace(message, problemBox(error));
        }
        scheduleUpdate();
      }
    }
  };
  const scheduleUpdate = (): void => {
    timer = setTimeout(() => {
      if (document.hidden) {
        scheduleUpdate();
      } else {
        void load();
      }
    }, INTERVAL);
  };
  signal.addEventListener("abort", () => {
    clearTimeout(timer);
  });
  more.addEventListener("click", () => {
    limit = Math.min(limit + PAGE, MAX_SHOWN);
    void load();
  });
  replace(host, message, list, more);
  await load();
}

/** An item of the list. */
class Item {
  readonly element: HTMLElement;
  private readonly signal: AbortSignal;
  private readonly picture = h("img", { alt: "", width: 96, height: 72 });
  private readonly title = h("span", { class: "job-title" });
  private readonly words = h("span", { class: "muted" });
  private shown: string[] = [];

  constructor(id: string, signal: AbortSignal) {
    this.signal = signal;
    this.element = h(
      "li",
      {},
      h(
        "a",
        { href: jobLink(id) },
        this.picture,
        h("span", { class: "job-words" }, this.title, this.words),
      ),
    );
  }

  show(job: JobRecord): void {
    const quality = job.progress?.best_quality;
    this.title.textContent = job.label ?? title(job);
    this.words.textContent =
      `${STATES[job.state] ?? job.state}, ${ago(job.created_at)}` +
      (quality === null || quality === undefined ? "" : `, ε ${number(quality)}`);
    const paths = picturesOf(job);
    if (this.shown.join() !== paths.join()) {
      this.shown = paths;
      void this.draw(job.id, paths);
    }
  }

  /** Shows the first of the pictures that exists. */
  private async draw(id: string, paths: string[]): Promise<void> {
    for (const path of paths.filter((path) => !missing.has(`${id} ${path}`))) {
      try {
        const bytes = await api.blob(path, this.signal);
        if (this.shown === paths) {
          await showBlob(this.picture, bytes);
        }
        return;
      } catch (error) {
        // The text of the item remains.
        if (error instanceof api.Problem && (error.status === 404 || error.status === 410)) {
          missing.add(`${id} ${path}`);
        }
      }
    }
  }
}

/** The pictures to try: that of the grasp, if there is one, then that of the mesh. */
function picturesOf(job: JobRecord): string[] {
  const mesh = `/meshes/${job.mesh_id}/preview.png?width=256&theme=${theme()}`;
  const grasp = `/jobs/${job.id}/grasp.png?width=192&view=iso&legend=false&theme=${theme()}`;
  // A cancelled job may have no result.
  const hasGrasp = job.state === "succeeded" && typeof job.progress?.best_quality === "number";
  return hasGrasp ? [grasp, mesh] : [mesh];
}

function title(job: JobRecord): string {
  const { contacts, contact_model: model } = job.request as {
    contacts: number;
    contact_model: string;
  };
  return `${contacts} contacts, ${model === "frictionless" ? "no friction" : model}`;
}
