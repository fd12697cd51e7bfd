/** The jobs that are there, newest first, each with a picture. */

import * as api from "../api/client";
import type { JobRecord } from "../api/types";
import { h, replace, showBlob } from "../dom";
import { jobLink } from "../routes";
import { ago, number } from "../text/format";
import { STATES } from "../text/words";
import { theme } from "../theme";
import { type Context, problemBox } from "./context";

/** How many are shown at first, and how many more each time. */
const PAGE = 8;
/** Most that are shown. */
const MOST = 200;
/** Time between two looks while jobs wait or run, in milliseconds. */
const AGAIN = 3000;

/** Jobs with the pictures that were asked for in vain, since the mesh is gone or nothing was found. */
const missing = new Set<string>();

/** Shows them in `host`, and what becomes of them, until the reader goes elsewhere. */
export async function recentJobs(context: Context, host: HTMLElement): Promise<void> {
  const { signal } = context;
  const list = h("ul", { class: "jobs" });
  const more = h("button", { type: "button", hidden: true }, "Show more");
  const said = h("div");
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
      // What is in its place is not touched, since it may have the focus.
      if (list.children[index] !== item.element) {
        list.insertBefore(item.element, list.children[index] ?? null);
      }
    }
    [...list.children].slice(jobs.length).forEach((element) => {
      element.remove();
    });
    refused = "";
    replace(said, jobs.length === 0 && h("p", { class: "muted" }, "None yet."));
  };
  const load = async (): Promise<void> => {
    clearTimeout(timer);
    loading.abort();
    const wanted = (loading = new AbortController()).signal;
    try {
      const page = await api.jobs(limit, AbortSignal.any([signal, wanted]));
      more.hidden = page.next_cursor === undefined || limit === MOST;
      show(page.jobs);
      if (page.jobs.some(({ state }) => state === "queued" || state === "running")) {
        lookAgain();
      }
    } catch (error) {
      if (!signal.aborted && !wanted.aborted) {
        // Told once, not at each look.
        if (refused !== String(error)) {
          refused = String(error);
          replace(said, problemBox(error));
        }
        lookAgain();
      }
    }
  };
  const lookAgain = (): void => {
    timer = setTimeout(() => {
      if (document.hidden) {
        lookAgain();
      } else {
        void load();
      }
    }, AGAIN);
  };
  signal.addEventListener("abort", () => {
    clearTimeout(timer);
  });
  more.addEventListener("click", () => {
    limit = Math.min(limit + PAGE, MOST);
    void load();
  });
  replace(host, said, list, more);
  await load();
}

/** One of the list. */
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

  /** The first of them that there is. */
  private async draw(id: string, paths: string[]): Promise<void> {
    for (const path of paths.filter((path) => !missing.has(`${id} ${path}`))) {
      try {
        const bytes = await api.blob(path, this.signal);
        if (this.shown === paths) {
          await showBlob(this.picture, bytes);
        }
        return;
      } catch (error) {
        // Words tell what there is.
        if (error instanceof api.Problem && (error.status === 404 || error.status === 410)) {
          missing.add(`${id} ${path}`);
        }
      }
    }
  }
}

/** The grasp where there is one, else the body. */
function picturesOf(job: JobRecord): string[] {
  const mesh = `/meshes/${job.mesh_id}/preview.png?width=256&theme=${theme()}`;
  const grasp = `/jobs/${job.id}/grasp.png?width=192&view=iso&legend=false&theme=${theme()}`;
  // One that was cancelled may have handed in nothing.
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
