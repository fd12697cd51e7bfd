/** The view of a job: its progress while it runs, its result when it has ended. */

import * as api from "../api/client";
import { follow } from "../api/follow";
import { retry } from "../api/retry";
import type { Constraints, ContactModel, JobRecord, JobState, Progress } from "../api/types";
import { ConvergenceChart, type Point } from "../charts/convergence";
import { h, replace } from "../dom";
import { meshLink, START } from "../routes";
import { followTheme } from "../theme";
import { count, number, seconds } from "../text/format";
import { PHASES, STATES } from "../text/words";
import { drawnRegions } from "./constraints";
import { type Context, heading, problemBox } from "./context";
import { copyButtons } from "./copying";
import { resultView } from "./result";
import { remember } from "./settings";

/** Interval at which screen readers read the progress, in milliseconds. */
const ANNOUNCE = 10_000;

export async function jobView(context: Context, id: string): Promise<void> {
  const { panel, stage, signal } = context;
  const title = heading("Job");
  const body = h("div");
  const chartHost = h("div", { class: "chart" });
  const live = new ProgressView(context, chartHost);
  let ended = false;
  let surface: Promise<void> | null = null;
  replace(panel, title, body);
  replace(body, h("p", { class: "muted" }, "Loading…"));
  stage.dismiss();

  const show = (job: JobRecord): void => {
    title.textContent = job.label ?? `Job ${job.id.slice(-8)}`;
    document.title = `${title.textContent} – graspd`;
    stage.keepOnly(job.mesh_id);
    if (surface === null) {
      context.announce(title.textContent);
      stage.setGrasp(null);
      surface = showBody(context, job, body);
    }
    if (job.state === "queued" || job.state === "running") {
      if (!body.contains(live.element)) {
        replace(body, live.element, chartHost, againLinks(job, context));
      }
      live.update(job.state, job.progress, job);
      return;
    }
    ended = true;
    // The element with the focus, such as the cancel button, is about to be removed.
    const losesFocus = body.contains(document.activeElement);
    const { result, problem } = job;
    const points = result?.history ?? [];
    replace(
      body,
      h("p", { class: `state ${job.state}` }, STATES[job.state] ?? job.state),
      problem !== undefined && problemBox(new api.Problem({ ...problem, status: problem.status })),
      result === undefined &&
        job.state === "cancelled" &&
        h("p", {}, "It was cancelled before it had a result."),
      result !== undefined && resultView(context, job, result, surface),
      points.length > 0 && h("h3", {}, "Progress of the search"),
      points.length > 0 && chartHost,
      h("h3", {}, "The same request from a program"),
      copyButtons(() => ({ meshId: job.mesh_id, request: job.request })),
      againLinks(job, context),
    );
    live.chart.set(points);
    if (losesFocus) {
      title.focus({ preventScroll: true });
    }
    context.announce(endWords(job));
  };

  signal.addEventListener("abort", () => {
    live.chart.dispose();
  });
  followTheme(() => {
    live.chart.restyle();
  }, signal);
  stage.setColors(null);
  stage.setGhost(null);
  stage.setRegions([]);
  await follow(
    id,
    {
      record: show,
      progress: (state, progress) => {
        if (!ended) {
          live.update(state, progress);
        }
      },
      reachable: (is) => {
        context.reachable(is);
      },
    },
    signal,
  );
}

/** Shows the surface of the job's mesh, or says that it has been deleted. */
async function showBody(context: Context, job: JobRecord, body: HTMLElement): Promise<void> {
  const { signal } = context;
  try {
    await retry(
      async () => {
        const mesh = await api.mesh(job.mesh_id, signal);
        signal.throwIfAborted();
        await context.stage.showMesh(mesh);
      },
      signal,
      context.reachable,
    );
    if (!signal.aborted) {
      const constraints = job.request["constraints"] as Constraints | null | undefined;
      context.stage.setRegions(drawnRegions(constraints ?? {}));
    }
  } catch (error) {
    if (!signal.aborted) {
      context.stage.clear();
      const gone = error instanceof api.Problem && error.status === 404;
      body.before(
        gone
          ? h("p", { class: "warning" }, "The mesh of this job has been deleted.")
          : problemBox(error),
      );
    }
  }
}

function endWords(job: JobRecord): string {
  const quality = job.result?.quality;
  if (quality !== null && quality !== undefined) {
    return `Done: the grasp holds with quality ${number(quality)}.`;
  }
  return job.state === "succeeded" ? "Done: no grasp holds the body." : `Job ${job.state}.`;
}

function againLinks(job: JobRecord, context: Context): HTMLElement {
  const message = h("span");
  return h(
    "p",
    { class: "row" },
    h(
      "a",
      {
        href: meshLink(job.mesh_id),
        class: "button",
        onclick: () => {
          remember(job.mesh_id, job.request);
        },
      },
      "Plan again with other settings",
    ),
    h("a", { href: START, class: "button" }, "Another mesh"),
    removeButton(job, context, message),
    message,
  );
}

/** A button that deletes the job when it is pressed twice. */
function removeButton(job: JobRecord, context: Context, message: HTMLElement): HTMLElement {
  const button = h("button", { type: "button" });
  let sure = false;
  const ask = (again: boolean): void => {
    sure = again;
    button.textContent = again ? "Press again to delete the job and its result" : "Delete this job";
  };
  ask(false);
  button.addEventListener("blur", () => {
    ask(false);
  });
  button.addEventListener("click", () => {
    if (!sure) {
      ask(true);
      return;
    }
    button.disabled = true;
    api.remove(job.id).then(
      () => {
        context.go(START);
      },
      (error: unknown) => {
        button.disabled = false;
        ask(false);
        replace(message, problemBox(error));
      },
    );
  });
  return button;
}

/** Shows the progress of a running job. */
class ProgressView {
  readonly element: HTMLElement;
  readonly chart: ConvergenceChart;
  private readonly context: Context;
  private readonly phase = h("p", { class: "phase" });
  private readonly bar = h("progress", { "aria-label": "Generations", max: 1, value: 0 });
  private readonly best = h("dd", { class: "best" }, "–");
  private readonly evaluations = h("dd");
  private readonly elapsed = h("dd");
  private readonly cancel = h("button", { type: "button" }, "Cancel");
  private readonly message = h("div");
  private readonly points: Point[] = [];
  private id = "";
  private friction: number | null = null;
  private model: ContactModel = "hard";
  /** Number of fixed contacts, which come first. */
  private fixedCount = 0;
  private announced = 0;
  /** Whether the message says that the server does not answer. */
  private lost = false;

  constructor(context: Context, chartHost: HTMLElement) {
    this.context = context;
    this.chart = new ConvergenceChart(chartHost);
    let asked = false;
    this.cancel.addEventListener("click", () => {
      if (asked) {
        return;
      }
      // The button is not disabled, because it would lose the focus.
      asked = true;
      replace(this.message);
      api.cancel(this.id).catch((error: unknown) => {
        asked = false;
        this.lost = error instanceof api.Problem && error.status === 0;
        replace(this.message, problemBox(error));
      });
    });
    this.element = h(
      "section",
      { "aria-label": "Search" },
      this.phase,
      this.bar,
      h(
        "dl",
        { class: "facts" },
        h("dt", {}, "Best quality ε so far"),
        this.best,
        h("dt", {}, "Grasps evaluated"),
        this.evaluations,
        h("dt", {}, "Time"),
        this.elapsed,
      ),
      this.cancel,
      this.message,
    );
  }

  update(state: JobState, progress: Progress | undefined, job?: JobRecord): void {
    if (this.lost) {
      this.lost = false;
      replace(this.message);
    }
    if (job !== undefined) {
      this.id = job.id;
      const { friction, contact_model: model } = job.request;
      this.friction = typeof friction === "number" ? friction : null;
      this.model = (model as ContactModel | undefined) ?? "hard";
      const constraints = job.request["constraints"] as Constraints | null | undefined;
      this.fixedCount = constraints?.fixed_contacts?.length ?? 0;
    }
    if (state === "queued" || progress === undefined) {
      this.phase.textContent = state === "queued" ? "Waiting for its turn" : "Starting";
      this.bar.removeAttribute("value");
      return;
    }
    const phase = PHASES[progress.phase] ?? progress.phase;
    this.phase.textContent = `${phase}: generation ${count(progress.generation)} of ${count(progress.generations)}`;
    this.bar.max = Math.max(progress.generations, 1);
    this.bar.value = progress.generation;
    this.best.textContent = number(progress.best_quality);
    this.evaluations.textContent = count(progress.evaluations);
    this.elapsed.textContent = seconds(progress.elapsed_s);
    const last = this.points.at(-1);
    const { generation, best_quality: best, evaluations } = progress;
    const point = { generation, best, evaluations };
    if (last !== undefined && generation < last.generation) {
      // The job was started again, for example after a crash of its server.
      this.points.length = 0;
    }
    if (last?.generation === point.generation) {
      this.points[this.points.length - 1] = point;
    } else {
      this.points.push(point);
    }
    this.chart.set(this.points);
    if (progress.best_contacts !== undefined) {
      const grasp = {
        contacts: progress.best_contacts.map((contact, index) => ({
          ...contact,
          fixed: index < this.fixedCount,
        })),
        friction: this.friction,
        contactModel: this.model,
      };
      this.context.stage.setGrasp(grasp, true);
    }
    const now = performance.now();
    if (now - this.announced > ANNOUNCE) {
      this.announced = now;
      this.context.announce(`${phase}. Best quality so far ${number(progress.best_quality)}.`);
    }
  }
}
