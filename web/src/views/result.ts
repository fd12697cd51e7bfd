/** Shows the result of a job and explains its numbers. */

import { retry } from "../api/retry";
import type { Contact, JobRecord, PlanResult } from "../api/types";
import { h, replace } from "../dom";
import { contactColor } from "../scene/colors";
import { count, extent, number, place, seconds, vector } from "../text/format";
import { MEASURES, METHODS, STOPS } from "../text/words";
import { type Choice, choicesOf, type GraspDetails, loadDetails, sceneGrasp } from "./choice";
import { type Context, problemBox } from "./context";
import { downloads } from "./downloads";
import { RegionColors } from "./regions";

export function resultView(
  context: Context,
  job: JobRecord,
  result: PlanResult,
  surface: Promise<void>,
): HTMLElement {
  const { stage } = context;
  const choices = choicesOf(result);
  const first = choices.find(({ name }) => name === "initial");
  const size = job.mesh_report === undefined ? 0 : extent(job.mesh_report.bounds);
  let current = choices[0];
  let loading = new AbortController();
  const table = h("div", {
    class: "scroll",
    tabindex: "0",
    role: "region",
    "aria-label": "Contacts",
  });
  const details = h("div");
  const compare = h("input", { type: "checkbox" });
  const picker = h(
    "select",
    { id: "choice" },
    ...choices.map(({ name, title }) => h("option", { value: name }, title)),
  );
  const regions = new RegionColors(context, job, surface, () => current);
  const drawGhost = (): void => {
    const ghost = compare.checked && first !== current ? first : undefined;
    stage.setGhost(ghost === undefined ? null : sceneGrasp(result, ghost));
  };
  const show = (choice: Choice): void => {
    replace(table, contactTable(choice.contacts, size));
    if (choice.details !== null) {
      replace(details, weakest(choice, result), measures(choice.details));
    }
    void surface.then(() => {
      if (!context.signal.aborted && choice === current) {
        stage.setGrasp(sceneGrasp(result, choice));
        stage.setPicture(`/jobs/${job.id}/grasp.png?grasp=${choice.name}&legend=false`);
        drawGhost();
      }
    });
  };
  const choose = async (choice: Choice): Promise<void> => {
    loading.abort();
    loading = new AbortController();
    const signal = AbortSignal.any([context.signal, loading.signal]);
    current = choice;
    regions.clear();
    show(choice);
    context.announce(`Shown: ${choice.title}`);
    if (choice.details === null) {
      replace(details, h("p", { class: "muted" }, "Evaluating this grasp…"));
      try {
        await retry(() => loadDetails(job, choice, signal), signal, context.reachable);
        if (!signal.aborted) {
          show(choice);
        }
      } catch (error) {
        if (!signal.aborted) {
          replace(details, h("p", {}, "This grasp could not be evaluated."), problemBox(error));
        }
      }
    }
  };
  picker.addEventListener("change", () => {
    const choice = choices.find(({ name }) => name === picker.value);
    if (choice !== undefined) {
      void choose(choice);
    }
  });
  compare.addEventListener("change", drawGhost);
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
        first !== undefined &&
          h("label", { class: "toggle" }, compare, "with the first grasp, faintly, for comparison"),
      ),
    current !== undefined && table,
    result.force_closure && regions.element,
    details,
    facts(result),
    current !== undefined && downloads(job, result, () => current),
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
          `The nearest miss is shown; its margin is ${number(result.margin)}.`,
        ),
    );
  }
  const bounds = result.bounds;
  return h(
    "div",
    { class: "verdict good" },
    h(
      "p",
      { class: "verdict-title" },
      "Force closure: the grasp resists every small push and twist",
    ),
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
        `Proven: moving any single finger to another of the ${count(result.candidates)} places searched does not ` +
          "improve the grasp" +
          ((result.polish?.gain ?? 0) > 0
            ? ", before the fingers slid to their final positions."
            : "."),
      ),
  );
}

function between([low, high]: [number, number]): string {
  const [from, to] = [number(low), number(high)];
  return from === to ? from : `from ${from} to ${to}`;
}

function weakest({ details, contacts }: Choice, result: PlanResult): HTMLElement | false {
  const wrench = details?.weakest_wrench ?? null;
  const answered = contacts.some(({ forces }) => forces !== undefined);
  const answer =
    result.contact_model === "frictionless"
      ? "The table has the forces with which the fingers answer it, along their normals."
      : "Thin red arrows are the forces with which the fingers answer it.";
  return (
    wrench !== null &&
    h(
      "p",
      {},
      h("strong", {}, "Weakest against: "),
      wrench.description,
      " It is drawn at the centre of mass, the force as a straight red arrow, the torque as a bent violet one. ",
      answered && answer,
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

function measures({ measures: values, robustness }: GraspDetails): HTMLElement | false {
  if (values === null || values === undefined) {
    return false;
  }
  const rows = MEASURES.filter(([name]) => values[name] !== undefined);
  const bound = (name: string) =>
    name.startsWith("epsilon") && values.epsilon_exact === false ? "at least " : "";
  return h(
    "details",
    { open: true },
    h("summary", {}, "All measures"),
    h(
      "dl",
      { class: "measures" },
      ...rows.flatMap(([name, title, meaning]) => [
        h("dt", {}, title, h("span", { class: "value" }, bound(name) + number(values[name]))),
        h("dd", {}, meaning),
      ]),
      ...(robustness == null
        ? []
        : [
            h(
              "dt",
              {},
              "Expected ε when fingers miss",
              h("span", { class: "value" }, number(robustness.expected)),
            ),
            h(
              "dd",
              {},
              `Mean over ${count(robustness.samples)} grasps with contacts scattered by ${number(robustness.sigma)}; ` +
                `${number(100 * robustness.force_closure_probability)} in 100 of them hold.`,
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
    ["Gained by sliding on the surface", number(result.polish?.gain)],
    ["Grasps evaluated", count(result.evaluations)],
    ["Places searched", count(result.candidates)],
    ["Time", seconds(result.elapsed_s)],
    [
      "Seed",
      `${result.seed}${result.reproducible ? "" : " (not repeatable: the search was cut short)"}`,
    ],
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
