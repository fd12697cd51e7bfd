/** The start view: choose a mesh file, an example, or a recent job. */

import * as api from "../api/client";
import { h, replace } from "../dom";
import { meshLink } from "../routes";
import { type Context, heading, problemBox } from "./context";
import { recentJobs } from "./jobs";

import box from "../../../examples/meshes/box.stl?url";
import duck from "../../../examples/meshes/duck.obj?url";
import knight from "../../../examples/meshes/knight.stl?url";
import rabbit from "../../../examples/meshes/rabbit.ply?url";

const EXAMPLES: [name: string, file: string, address: string][] = [
  ["Duck", "duck.obj", duck],
  ["Rabbit", "rabbit.ply", rabbit],
  ["Chess knight", "knight.stl", knight],
  ["Box", "box.stl", box],
];
const FORMATS = ".stl,.obj,.ply,.off,.glb,.gltf";
const UNITS: [string, string][] = [
  ["", "unknown"],
  ["m", "metres"],
  ["cm", "centimetres"],
  ["mm", "millimetres"],
  ["um", "micrometres"],
  ["in", "inches"],
  ["ft", "feet"],
];

export function startView(context: Context): void {
  const { panel, stage, signal } = context;
  stage.clear();
  stage.invite();
  const message = h("div", { "aria-live": "polite" });
  const units = h(
    "select",
    { id: "units", "aria-describedby": "units-help" },
    ...UNITS.map(([value, title]) => h("option", { value }, title)),
  );
  const busy = h("progress", { max: 1, value: 0, "aria-label": "Upload", hidden: true });
  let sending = new AbortController();
  const send = async (name: string, get: (signal: AbortSignal) => Promise<Blob>): Promise<void> => {
    // Only the mesh that was chosen last counts.
    sending.abort();
    sending = new AbortController();
    const upload = AbortSignal.any([signal, sending.signal]);
    busy.hidden = false;
    busy.value = 0;
    replace(message, h("p", {}, `Sending ${name}…`));
    try {
      const bytes = await get(upload);
      const mesh = await api.upload(
        new File([bytes], name, { type: bytes.type }),
        units.value,
        (share) => {
          busy.value = share;
          if (share === 1) {
            replace(message, h("p", {}, "Reading and checking the mesh…"));
          }
        },
        upload,
      );
      context.go(meshLink(mesh.id));
    } catch (error) {
      if (!upload.aborted) {
        busy.hidden = true;
        replace(message, problemBox(error));
      }
    }
  };
  const sendFile = (file: File): void => {
    void send(file.name, () => Promise.resolve(file));
  };
  const chooser = h("input", { type: "file", id: "file", accept: FORMATS });
  chooser.addEventListener("change", () => {
    const file = chooser.files?.[0];
    if (file !== undefined) {
      sendFile(file);
      // The same file may be chosen again.
      chooser.value = "";
    }
  });
  acceptDrops(signal, sendFile);
  const examples = EXAMPLES.map(([name, file, address]) =>
    h(
      "button",
      {
        type: "button",
        onclick: () => {
          void send(file, (signal) => api.blob(address, signal));
        },
      },
      name,
    ),
  );
  const recent = h("div");
  replace(
    panel,
    heading("Where do the fingers go?"),
    h(
      "p",
      {},
      "Choose a body as a triangle mesh, the number of fingers and their friction, and see where they hold it " +
        "best.",
    ),
    h(
      "div",
      { class: "drop" },
      h("label", { for: "file", class: "file-label" }, "Choose a mesh file, or drop one anywhere"),
      chooser,
      h("small", {}, "STL, OBJ, PLY, OFF, GLB, glTF, 3MF or COLLADA"),
    ),
    h(
      "div",
      { class: "field" },
      h("label", { for: "units" }, "Unit of its coordinates"),
      units,
      h(
        "small",
        { id: "units-help" },
        "Nothing is rescaled. The unit is shown with the result and used in exports.",
      ),
    ),
    busy,
    message,
    h("h3", { id: "examples" }, "Or an example"),
    h("div", { class: "row", role: "group", "aria-labelledby": "examples" }, ...examples),
    h("h3", {}, "Recent jobs"),
    recent,
  );
  void recentJobs(context, recent);
}

/** Accepts a file that is dropped anywhere on the page while the view is shown. */
function acceptDrops(signal: AbortSignal, take: (file: File) => void): void {
  const mark = (over: boolean): void => {
    document.body.classList.toggle("dropping", over);
  };
  document.addEventListener(
    "dragover",
    (event) => {
      event.preventDefault();
      mark(true);
    },
    { signal },
  );
  document.addEventListener(
    "dragleave",
    (event) => {
      if (event.relatedTarget === null) {
        mark(false);
      }
    },
    { signal },
  );
  document.addEventListener(
    "drop",
    (event) => {
      event.preventDefault();
      mark(false);
      const file = event.dataTransfer?.files[0];
      if (file !== undefined) {
        take(file);
      }
    },
    { signal },
  );
}
