/** Downloads of the files that the service generates from a result. */

import * as api from "../api/client";
import type { JobRecord, PlanResult } from "../api/types";
import { h, replace } from "../dom";
import { theme } from "../theme";
import type { Choice } from "./choice";
import { problemBox } from "./context";

/** Buttons for all files; files with one grasp contain the one that is chosen at the time. */
export function downloads(
  job: JobRecord,
  result: PlanResult,
  chosen: () => Choice | undefined,
): HTMLElement {
  const message = h("div");
  const units = h(
    "select",
    { "aria-label": "Unit of the mesh, for Isaac Sim and MoveIt" },
    h("option", { value: "" }, "unit of the mesh"),
    ...["m", "cm", "mm", "um", "in", "ft"].map((unit) => h("option", { value: unit }, unit)),
  );
  const unit = (): string => (units.value === "" ? "" : `&units=${units.value}`);
  const grasps: [string, string, () => string][] = [
    ["GLB", "grasp.glb", () => ""],
    ["PNG", "grasp.png", () => `&width=1600&theme=${theme()}`],
    ["SVG", "grasp.svg", () => `&theme=${theme()}`],
    ["CSV", "grasp.csv", () => ""],
  ];
  const pose = result.contacts.length === 2;
  if (pose) {
    grasps.push(["Isaac Sim", "grasp.isaac.yaml", unit], ["MoveIt", "grasp.moveit.json", unit]);
  }
  const button = (title: string, get: () => Promise<void>): HTMLElement => {
    const button = h("button", { type: "button" }, title);
    button.addEventListener("click", () => {
      const of = chosen()?.title ?? "";
      replace(message);
      get().catch((error: unknown) => {
        replace(message, h("p", {}, `${title} (${of}):`), problemBox(error));
      });
    });
    return button;
  };
  const buttons = [
    ...grasps.map(([title, file, query]) =>
      button(title, () => {
        const name = chosen()?.name ?? "best";
        const which = name === "best" ? "" : `-${name}`;
        return save(
          job.id,
          `${file}?grasp=${name}${query()}`,
          file.replace("grasp", `grasp${which}`),
        );
      }),
    ),
    button("Convergence SVG", () =>
      save(job.id, `convergence.svg?theme=${theme()}`, "convergence.svg"),
    ),
    button("Convergence CSV", () => save(job.id, "convergence.csv", "convergence.csv")),
  ];
  return h(
    "div",
    {},
    h("h3", {}, "Download"),
    h("div", { class: "row" }, ...buttons, pose && result.units === undefined && units),
    message,
  );
}

/** Downloads a file of a job; its name contains the end of the job's id. */
async function save(id: string, path: string, file: string): Promise<void> {
  const url = URL.createObjectURL(await api.blob(`/jobs/${id}/${path}`));
  h("a", { href: url, download: file.replace(".", `-${id.slice(-8)}.`) }).click();
  setTimeout(() => {
    URL.revokeObjectURL(url);
  }, 10_000);
}
