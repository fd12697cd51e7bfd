/** The jobs that are there, newest first, each with a picture. */

import * as api from "../api/client";
import type { JobRecord } from "../api/types";
import { append, h, replace } from "../dom";
import { jobLink } from "../routes";
import { ago, number } from "../text/format";
import { STATES } from "../text/words";
import { theme } from "../theme";
import { type Context, problemBox } from "./context";

const PAGE = 8;

export async function recentJobs(context: Context, host: HTMLElement): Promise<void> {
  const list = h("ul", { class: "jobs" });
  const more = h("button", { type: "button", hidden: true }, "Show more");
  let cursor: string | undefined;
  const load = async (): Promise<void> => {
    try {
      const page = await api.jobs(PAGE, cursor);
      cursor = page.next_cursor;
      more.hidden = cursor === undefined;
      append(
        list,
        page.jobs.map((job) => item(job, context.signal)),
      );
      if (list.children.length === 0) {
        replace(host, h("p", { class: "muted" }, "None yet."));
      }
    } catch (error) {
      replace(host, problemBox(error));
    }
  };
  more.addEventListener("click", () => void load());
  replace(host, list, more);
  await load();
}

function item(job: JobRecord, signal: AbortSignal): HTMLElement {
  const picture = h("img", { alt: "", width: 96, height: 72 });
  void thumbnail(job, picture, signal);
  const quality = job.progress?.best_quality;
  return h(
    "li",
    {},
    h(
      "a",
      { href: jobLink(job.id) },
      picture,
      h(
        "span",
        { class: "job-words" },
        h("span", { class: "job-title" }, job.label ?? title(job)),
        h(
          "span",
          { class: "muted" },
          `${STATES[job.state] ?? job.state}, ${ago(job.created_at)}`,
          quality === null || quality === undefined ? null : `, ε ${number(quality)}`,
        ),
      ),
    ),
  );
}

function title(job: JobRecord): string {
  const { contacts, contact_model: model } = job.request as {
    contacts: number;
    contact_model: string;
  };
  return `${contacts} contacts, ${model === "frictionless" ? "no friction" : model}`;
}

/** The grasp where there is one, else the body, else nothing. */
async function thumbnail(
  job: JobRecord,
  picture: HTMLImageElement,
  signal: AbortSignal,
): Promise<void> {
  const mesh = `/meshes/${job.mesh_id}/preview.png?width=256&theme=${theme()}`;
  const grasp = `/jobs/${job.id}/grasp.png?width=192&view=iso&legend=false&theme=${theme()}`;
  const ended = job.state === "succeeded" || job.state === "cancelled";
  const hasGrasp = ended && typeof job.progress?.best_quality === "number";
  for (const path of hasGrasp ? [grasp, mesh] : [mesh]) {
    try {
      const bytes = await api.blob(path);
      const address = URL.createObjectURL(bytes);
      picture.src = address;
      signal.addEventListener("abort", () => {
        URL.revokeObjectURL(address);
      });
      return;
    } catch {
      // Its mesh may be gone, or there is nothing to show: the words do.
    }
  }
}
