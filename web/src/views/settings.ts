/** The view of a mesh: its report, and the form of a planning request. */

import * as api from "../api/client";
import { Problem } from "../api/client";
import { stringify } from "../api/json";
import { retry } from "../api/retry";
import type { Constraints, MeshRecord } from "../api/types";
import { h, replace } from "../dom";
import { jobLink } from "../routes";
import { count, extent, place, vector } from "../text/format";
import { ConstraintsEditor } from "./constraints";
import { alertBox, type Context, heading, problemBox } from "./context";
import { copyButtons } from "./copying";
import { FieldControl, FIELDS } from "./fields";
import { formOf, keepForm } from "./forms";

/** Settings without fields that apply to one search method only. */
const OF_METHOD = ["initial", "polish"];
const DEFAULT_METHOD = "memetic";
/** Settings without fields that are kept when a job is planned again. */
const OTHERS = [
  "candidates",
  "center_of_mass",
  "gravity",
  "independent_regions",
  "robustness",
  "task_wrenches",
  ...OF_METHOD,
];

/** Fills the next form of this mesh with the request of a job, without the settings that control its effort. */
export function remember(meshId: string, request: Record<string, unknown>): void {
  const names = FIELDS.filter(({ effort }) => effort !== true).map(({ name }) => name);
  keepForm(meshId, pick(request, [...names, ...OTHERS, "constraints"]));
}

/** The entries with these names that have a value. */
function pick(request: Record<string, unknown>, names: string[]): Record<string, unknown> {
  const entries = names.map((name) => [name, request[name]] as const);
  return Object.fromEntries(entries.filter(([, value]) => value !== undefined && value !== null));
}

export async function settingsView(context: Context, id: string): Promise<void> {
  const { panel, stage } = context;
  const title = heading("Mesh");
  const body = h("div", {}, h("p", {}, "Loading…"));
  replace(panel, title, body);
  stage.keepOnly(id);
  stage.setGrasp(null);
  stage.setGhost(null);
  stage.setColors(null);
  const { signal } = context;
  const mesh = await retry(() => api.mesh(id, signal), signal, context.reachable);
  if (mesh === null) {
    return;
  }
  const surface = retry(() => stage.showMesh(mesh), signal, context.reachable);
  const message = h("div");
  const before = formOf(id);
  const changed = (): void => {
    update();
    // Keep the form for users who leave the view and return.
    keepForm(id, request());
  };
  const controls = FIELDS.map((field) => new FieldControl(field, changed));
  for (const control of controls) {
    const value = before[control.name];
    if (typeof value === "string" || typeof value === "number") {
      control.fill(String(value));
    }
  }
  const constraints = new ConstraintsEditor(stage, mesh.report.bounds, changed);
  const request = (): Record<string, unknown> => {
    const given = controls
      .filter((control) => !control.element.hidden)
      .map((control) => [control.name, control.value] as const);
    const method = (given.find(([name]) => name === "method")?.[1] ?? DEFAULT_METHOD) as string;
    const same = method === (before["method"] ?? DEFAULT_METHOD);
    const kept = OTHERS.filter((name) => same || !OF_METHOD.includes(name));
    const all = [
      ...Object.entries(pick(before, kept)),
      ...given,
      ["constraints", constraints.value] as const,
      ["units", mesh.units] as const,
    ];
    return Object.fromEntries(all.filter(([, value]) => value !== undefined));
  };
  const update = (): void => {
    const model = controls.find((control) => control.name === "contact_model")?.value ?? "hard";
    for (const control of controls) {
      if (control.name === "friction" || control.name === "cone_edges") {
        control.hidden = model === "frictionless";
      } else if (control.name === "torsional_friction") {
        control.hidden = model !== "soft";
      }
    }
  };
  constraints.fill((before["constraints"] as Constraints | undefined) ?? {});
  // A request that was sent without an answer is sent again under its key, so that it is not planned twice.
  let tried = { body: "", key: "" };
  const submit = h("button", { type: "submit", class: "primary" }, "Plan the grasp");
  const form = h(
    "form",
    { novalidate: true },
    ...controls.filter((control) => !isAdvanced(control)).map((control) => control.element),
    h(
      "details",
      { open: constraints.value !== undefined },
      h("summary", {}, "Where fingers may be"),
      constraints.element,
    ),
    h(
      "details",
      {},
      h("summary", {}, "More settings"),
      ...controls.filter(isAdvanced).map((control) => control.element),
    ),
    message,
    submit,
  );
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    controls.forEach((control) => {
      control.showError(null);
    });
    replace(message);
    const invalid = firstInvalid(form);
    if (invalid !== null) {
      invalid.closest("details")?.setAttribute("open", "");
      replace(
        message,
        alertBox(
          invalid.validity.customError
            ? invalid.validationMessage
            : "Enter a number in the field with the cursor.",
        ),
      );
      invalid.focus();
      return;
    }
    submit.disabled = true;
    const submission = { mesh_id: id, ...request() };
    if (stringify(submission) !== tried.body) {
      tried = { body: stringify(submission), key: randomKey() };
    }
    api
      .submit(submission, tried.key)
      .then((job) => {
        context.go(jobLink(job.id));
      })
      .catch((error: unknown) => {
        submit.disabled = false;
        if (isRefusal(error)) {
          tried = { body: "", key: "" };
        }
        showErrors(error, controls, message);
      });
  });
  title.textContent = mesh.file_name ?? "Mesh";
  context.announce(title.textContent);
  replace(
    body,
    report(mesh),
    form,
    h("h3", {}, "The same request from a program"),
    copyButtons(() => ({ meshId: id, request: request() })),
  );
  update();
  await surface;
  // Do not draw on the body of another view.
  signal.throwIfAborted();
  constraints.draw();
}

/** Whether the service has refused the request, so that there is no job. */
const isRefusal = (error: unknown): boolean =>
  error instanceof Problem && error.status >= 400 && error.status < 500 && error.status !== 409;

/** A key that is unique and cannot be guessed; a page loaded over plain HTTP has no `randomUUID`. */
const randomKey = (): string =>
  [...crypto.getRandomValues(new Uint8Array(16))]
    .map((byte) => byte.toString(16).padStart(2, "0"))
    .join("");

/** The first visible field of a form with an invalid value. */
function firstInvalid(form: HTMLFormElement): HTMLInputElement | null {
  const inputs = [...form.querySelectorAll("input")];
  const shown = inputs.filter((input) => input.closest("[hidden]") === null);
  return (
    shown.find(
      ({ validity, required, value }) =>
        validity.badInput || validity.customError || (required && value === ""),
    ) ?? null
  );
}

const isAdvanced = (control: FieldControl): boolean =>
  FIELDS.find((field) => field.name === control.name)?.advanced === true;

/** Shows each error at its field, and errors without a field above the button. */
function showErrors(error: unknown, controls: FieldControl[], message: HTMLElement): void {
  let first: FieldControl | undefined;
  let placed = 0;
  const errors = error instanceof Problem ? error.errors : [];
  for (const { pointer, detail } of errors) {
    const name = pointer.split("/")[1];
    const control = controls.find((control) => control.name === name);
    if (control !== undefined) {
      control.element.closest("details")?.setAttribute("open", "");
      control.showError(detail);
      first ??= control;
      placed += 1;
    }
  }
  if (placed === 0 || placed < errors.length) {
    replace(message, problemBox(error));
  } else {
    replace(message, alertBox("Some settings cannot be used; see the fields."));
  }
  first?.focus();
}

function report(mesh: MeshRecord): HTMLElement {
  const { report } = mesh;
  const size = report.bounds[1].map((high, axis) => high - (report.bounds[0][axis] ?? 0));
  const facts: [string, string][] = [
    ["Triangles", count(report.triangles)],
    ["Size", `${vector(size)}${mesh.units === undefined ? "" : ` ${mesh.units}`}`],
    ["Surface", report.watertight ? "closed" : "open or with defects"],
    ["Centre of mass", place(report.center_of_mass, extent(report.bounds))],
  ];
  return h(
    "div",
    {},
    h(
      "dl",
      { class: "facts" },
      ...facts.flatMap(([name, value]) => [h("dt", {}, name), h("dd", {}, value)]),
    ),
    ...report.warnings.map((warning) => h("p", { class: "warning" }, warning.detail)),
  );
}
