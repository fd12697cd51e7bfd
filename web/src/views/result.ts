/** What a job has found, and what it means. */

import * as api from "../api/client";
import type { Contact, JobRecord, PlanResult } from "../api/types";
import { h, replace } from "../dom";
import { contactColor } from "../scene/colors";
import type { SceneGrasp } from "../scene";
import { count, extent, number, place, seconds, vector } from "../text/format";
import { MEASURES, METHODS, STOPS } from "../text/words";
import { theme } from "../theme";
import { type Context, problemBox } from "./context";

/** Settings that an evaluation shares with a planning request. */
const SHARED = [
  "contact_model",
  "friction",
  "cone_edges",
  "torsional_friction",
  "edge_norm",
  "wrench_space",
  "torque_scale",
  "center_of_mass",
];

/** One of the grasps of a result. */
interface Choice {
  /** As the service's pictures and exports name it. */
  name: string;
  title: string;
  contacts: Contact[];
  quality: number | null;
}

export function resultView(
  context: Context,
  job: JobRecord,
  result: PlanResult,
  surface: Promise<void>,
): HTMLElement {
  const choices = choicesOf(result);
  const table = h("div", {
    class: "scroll",
    tabindex: "0",
    role: "region",
    "aria-label": "Contacts",
  });
  const files = h("div");
  let asked = new AbortController();
  const size = job.mesh_report === undefined ? 0 : extent(job.mesh_report.bounds);
  const show = (choice: Choice): void => {
    asked.abort();
    regionBox.checked = false;
    replace(regionSaid);
    const shown = sceneGrasp(result, choice);
    const first = choices.find((other) => other.name === "initial");
    const ghost = first !== undefined && first !== choice && compare.checked ? first : null;
    replace(table, contactTable(choice.contacts, size));
    replace(files, downloads(job, result, choice));
    void surface.then(() => {
      if (!context.signal.aborted) {
        context.stage.setColors(null);
        context.stage.setGrasp(shown);
        context.stage.setGhost(ghost === null ? null : sceneGrasp(result, ghost));
        context.stage.setPicture(`/jobs/${job.id}/grasp.png?grasp=${choice.name}&legend=false`);
      }
    });
  };
  let current = choices[0];
  const compare = h("input", { type: "checkbox" });
  compare.addEventListener("change", () => {
    if (current !== undefined) {
      show(current);
    }
  });
  const picker = h(
    "select",
    { id: "choice" },
    ...choices.map((choice) => h("option", { value: choice.name }, choice.title)),
  );
  picker.addEventListener("change", () => {
    current = choices.find((choice) => choice.name === picker.value) ?? current;
    if (current !== undefined) {
      show(current);
    }
  });
  const regionBox = h("input", { type: "checkbox" });
  const regionSaid = h("div", { "aria-live": "polite" });
  regionBox.addEventListener("change", () => {
    if (current !== undefined) {
      asked.abort();
      asked = new AbortController();
      const signal = AbortSignal.any([context.signal, asked.signal]);
      void colorRegions(context, job, current, regionBox, regionSaid, signal);
    }
  });
  if (current !== undefined) {
    show(current);
  }
  return h(
    "div",
    {},
    verdict(result),
    current !== undefined && h("h3", {}, "The grasp"),
    choices.length > 1 &&
      h(
        "div",
        { class: "field" },
        h("label", { for: "choice" }, "Shown"),
        picker,
        choices.some((choice) => choice.name === "initial") &&
          h("label", { class: "toggle" }, compare, "with the first grasp, faint, to compare"),
      ),
    current !== undefined && table,
    result.force_closure &&
      h(
        "div",
        {},
        h("label", { class: "toggle" }, regionBox, "Colour where each finger may be alone"),
        h(
          "small",
          { class: "muted" },
          "Wherever one finger touches in its colour while the others stay, at least half of the quality is left.",
        ),
        regionSaid,
      ),
    weakest(result),
    measures(result),
    facts(result),
    current !== undefined && files,
  );
}

function verdict(result: PlanResult): HTMLElement {
  if (!result.force_closure) {
    return h(
      "div",
      { class: "verdict bad" },
      h("p", { class: "verdict-title" }, "No grasp that holds"),
      h("p", {}, result.explanation?.detail ?? "Nothing was found."),
      result.margin !== null &&
        result.contacts.length > 0 &&
        h(
          "p",
          { class: "muted" },
          `What came nearest is shown; its margin is ${number(result.margin)}.`,
        ),
    );
  }
  const bounds = result.bounds;
  return h(
    "div",
    { class: "verdict good" },
    h("p", { class: "verdict-title" }, "Force closure: it holds against every small push and turn"),
    h(
      "p",
      { class: "quality" },
      h("span", { class: "quality-number", "data-testid": "quality" }, number(result.quality)),
      " quality ε",
    ),
    h(
      "p",
      {},
      (result.wrench_space === "linf"
        ? "With every finger force at most one"
        : "With finger forces that sum to one") +
        ", the weakest disturbance that could break the grasp has this size, " +
        `torques scaled by ${number(result.torque_scale.value)} per length.`,
      bounds !== null &&
        bounds !== undefined &&
        result.contact_model !== "frictionless" &&
        ` With the round friction cone it is ${between(bounds)}.`,
    ),
    result.single_exchange_optimal &&
      h(
        "p",
        {},
        `Proven: of the ${count(result.candidates)} places that were searched, no other one for any single finger ` +
          "is better" +
          ((result.polish?.gain ?? 0) > 0
            ? ", before the fingers slid to where they are now."
            : "."),
      ),
  );
}

function between([low, high]: [number, number]): string {
  const [from, to] = [number(low), number(high)];
  return from === to ? from : `from ${from} to ${to}`;
}

function weakest(result: PlanResult): HTMLElement | false {
  const wrench = result.weakest_wrench;
  return (
    wrench !== null &&
    h(
      "p",
      {},
      h("strong", {}, "Weakest against: "),
      wrench.description,
      " It is drawn at the centre of mass, the force straight and red, the torque bent and violet. " +
        "Thin red arrows are the forces with which the fingers answer it.",
    )
  );
}

function contactTable(contacts: Contact[], size: number): HTMLElement {
  const heads = ["", "x, y, z", "inward normal", "triangle", "force"];
  return h(
    "table",
    {},
    h(
      "thead",
      {},
      h("tr", {}, ...heads.map((name, i) => h("th", { scope: "col" }, i === 0 ? "finger" : name))),
    ),
    h(
      "tbody",
      {},
      ...contacts.map((contact, index) => {
        const swatch = h("span", { class: "swatch", "aria-hidden": "true" });
        swatch.style.background = contactColor(index);
        return h(
          "tr",
          {},
          h(
            "th",
            { scope: "row" },
            swatch,
            `${index + 1}${contact.fixed === true ? " (fixed)" : ""}`,
          ),
          h("td", {}, place(contact.position, size)),
          h("td", {}, vector(contact.normal)),
          h("td", {}, contact.triangle === undefined ? "–" : String(contact.triangle)),
          h("td", {}, contact.forces === undefined ? "–" : number(Math.hypot(...contact.forces))),
        );
      }),
    ),
  );
}

function measures(result: PlanResult): HTMLElement | false {
  const values = result.measures;
  if (values === null || values === undefined) {
    return false;
  }
  const rows = MEASURES.filter(([name]) => values[name] !== undefined);
  return h(
    "details",
    { open: true },
    h("summary", {}, "All measures"),
    h(
      "dl",
      { class: "measures" },
      ...rows.flatMap(([name, title, meaning]) => [
        h("dt", {}, title, h("span", { class: "value" }, number(values[name]))),
        h("dd", {}, meaning),
      ]),
      ...(result.robustness === undefined
        ? []
        : [
            h(
              "dt",
              {},
              "Expected ε when fingers miss",
              h("span", { class: "value" }, number(result.robustness.expected)),
            ),
            h(
              "dd",
              {},
              `Mean over ${count(result.robustness.samples)} grasps scattered by ${number(result.robustness.sigma)}; ` +
                `${number(100 * result.robustness.force_closure_probability)} in 100 of them hold.`,
            ),
          ]),
    ),
  );
}

function facts(result: PlanResult): HTMLElement {
  const rows: [string, string][] = [
    ["Search", METHODS[result.method] ?? result.method],
    ["It ended because", STOPS[result.stopped_because] ?? result.stopped_because],
    ["First grasp", result.initial === null ? "–" : `ε ${number(result.initial.quality)}`],
    ["Sliding on the surface brought", number(result.polish?.gain)],
    ["Grasps evaluated", count(result.evaluations)],
    ["Places searched", count(result.candidates)],
    ["Time", seconds(result.elapsed_s)],
    ["Seed", `${result.seed}${result.reproducible ? "" : " (not repeatable: it was cut short)"}`],
  ];
  return h(
    "details",
    {},
    h("summary", {}, "About the search"),
    h(
      "dl",
      { class: "facts" },
      ...rows.flatMap(([name, value]) => [h("dt", {}, name), h("dd", {}, value)]),
    ),
  );
}

function downloads(job: JobRecord, result: PlanResult, choice: Choice): HTMLElement {
  const said = h("div");
  const of = `grasp=${choice.name}`;
  const units = h(
    "select",
    { "aria-label": "Unit of the mesh, for Isaac Sim and MoveIt" },
    h("option", { value: "" }, "unit of the mesh"),
    ...["m", "cm", "mm", "um", "in", "ft"].map((unit) => h("option", { value: unit }, unit)),
  );
  const pose = choice.contacts.length === 2;
  const unit = (): string => (units.value === "" ? "" : `&units=${units.value}`);
  const files: [string, () => string][] = [
    ["GLB", () => `grasp.glb?${of}`],
    ["PNG", () => `grasp.png?${of}&width=1600&theme=${theme()}`],
    ["SVG", () => `grasp.svg?${of}&theme=${theme()}`],
    ["CSV", () => `grasp.csv?${of}`],
    ["Convergence SVG", () => `convergence.svg?theme=${theme()}`],
    ["Convergence CSV", () => "convergence.csv"],
  ];
  if (pose) {
    files.push(["Isaac Sim", () => `grasp.isaac.yaml?${of}${unit()}`]);
    files.push(["MoveIt", () => `grasp.moveit.json?${of}${unit()}`]);
  }
  const buttons = files.map(([title, path]) => {
    const button = h("button", { type: "button" }, title);
    button.addEventListener("click", () => {
      replace(said);
      save(job.id, path()).catch((error: unknown) => {
        replace(said, problemBox(error));
      });
    });
    return button;
  });
  return h(
    "div",
    {},
    h("h3", {}, "Download"),
    h("div", { class: "row" }, ...buttons, pose && result.units === undefined && units),
    said,
  );
}

async function save(id: string, path: string): Promise<void> {
  const address = URL.createObjectURL(await api.blob(`/jobs/${id}/${path}`));
  const [file = "grasp"] = path.split("?");
  const name = file.replace(".", `-${id.slice(-8)}.`);
  h("a", { href: address, download: name }).click();
  setTimeout(() => {
    URL.revokeObjectURL(address);
  }, 10_000);
}

async function colorRegions(
  context: Context,
  job: JobRecord,
  choice: Choice,
  box: HTMLInputElement,
  said: HTMLElement,
  signal: AbortSignal,
): Promise<void> {
  if (!box.checked) {
    context.stage.setColors(null);
    replace(said);
    return;
  }
  replace(said, h("p", { class: "muted" }, "Deciding every triangle…"));
  const settings = SHARED.map((name) => [name, job.request[name]] as const);
  const given = settings.filter(([, value]) => value !== undefined && value !== null);
  // A free finger is where it is; any other is on the surface.
  const contacts = choice.contacts.map(({ position, normal, triangle }) =>
    triangle === undefined ? { point: position, normal } : { point: position },
  );
  try {
    const regions = await api.regions(
      {
        mesh_id: job.mesh_id,
        grasps: [contacts],
        independent_regions: {},
        ...Object.fromEntries(given),
      },
      signal,
    );
    if (signal.aborted) {
      return;
    }
    context.stage.setColors(regions.map((region) => region.triangles));
    const words = regions.map((region, i) => `finger ${i + 1}: ${count(region.count)} triangles`);
    replace(
      said,
      h(
        "p",
        { class: "muted" },
        `${words.join(", ")}.`,
        regions.some((region) => region.truncated) && " Too many to colour all.",
      ),
    );
  } catch (error) {
    if (!signal.aborted) {
      box.checked = false;
      replace(said, problemBox(error));
    }
  }
}

function choicesOf(result: PlanResult): Choice[] {
  if (result.contacts.length === 0) {
    return [];
  }
  const { contacts, quality } = result;
  const title = quality === null ? "What came nearest" : `Best: ε ${number(quality)}`;
  const choices: Choice[] = [{ name: "best", title, contacts, quality }];
  result.top?.slice(1).forEach((grasp, index) => {
    choices.push({
      name: String(index + 2),
      title: `Number ${index + 2}: ε ${number(grasp.quality)}`,
      contacts: grasp.contacts,
      quality: grasp.quality,
    });
  });
  if (result.initial !== null) {
    const { quality, contacts } = result.initial;
    choices.push({
      name: "initial",
      title: `First found: ε ${number(quality)}`,
      contacts,
      quality,
    });
  }
  return choices;
}

function sceneGrasp(result: PlanResult, choice: Choice): SceneGrasp {
  const wrench = choice.name === "best" ? result.weakest_wrench : null;
  return {
    contacts: choice.contacts,
    friction: result.friction ?? null,
    contactModel: result.contact_model,
    centerOfMass: result.center_of_mass,
    ...(wrench === null ? {} : { weakest: { force: wrench.force, torque: wrench.torque } }),
  };
}
