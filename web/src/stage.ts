/** The three-dimensional view with what belongs to it: loading, views, what is shown, words for those who do not see. */

import * as api from "./api/client";
import type { MeshRecord } from "./api/types";
import { h, replace, showBlob } from "./dom";
import { type Hit, type Part, readMesh, Scene, type SceneGrasp, type SceneRegion } from "./scene";
import { followTheme, theme } from "./theme";
import { count, extent } from "./text/format";
import { graspWords } from "./text/words";

/** Most triangles that are drawn: software rendering turns so many without stalling. */
const BUDGET = 150_000;

const NO_WEBGL =
  "This browser has no WebGL: instead of a body that can be turned there are pictures.";

const NOTHING = "No body is shown.";

const VIEWS = ["iso", "front", "back", "left", "right", "top", "bottom"] as const;
const PARTS: [Part, string][] = [
  ["arrows", "Arrows"],
  ["cones", "Friction cones"],
  ["weakest", "Weakest wrench"],
  ["regions", "Regions"],
  ["wireframe", "Triangles"],
];

export class Stage {
  readonly element: HTMLElement;
  private readonly host: HTMLElement;
  private readonly notice = h("p", { class: "notice", hidden: true });
  private readonly hint = h("p", { class: "hint" });
  private readonly view = h(
    "select",
    { "aria-label": "View" },
    ...VIEWS.map((name) => h("option", { value: name }, name === "iso" ? "oblique" : name)),
    h("option", { value: "", hidden: true }, "as turned"),
  );
  /** By the service, where the browser cannot draw. */
  private readonly picture = h("img", { alt: "", hidden: true });
  /** What it is to show: an address without the theme. */
  private wanted = "";
  /** The address of the picture that is shown or on its way. */
  private asked = "";
  private readonly summary = h("p", { class: "visually-hidden", id: "scene-summary" });
  private readonly scene: Scene | null;
  private shown: string | null = null;
  /** The body that is shown, in words. */
  private body = NOTHING;
  private size = 0;
  private loading = new AbortController();
  /** Settled once the body that is to be shown is there. */
  private surface: Promise<void> = Promise.resolve();

  constructor() {
    this.host = h("div", {
      class: "canvas",
      tabindex: "0",
      role: "application",
      "aria-label": "Body in three dimensions: arrow keys turn it, plus and minus zoom, Home fits",
      "aria-describedby": "scene-summary",
    });
    this.element = h(
      "section",
      { class: "stage", "aria-label": "Three-dimensional view" },
      this.host,
      this.notice,
      this.summary,
      this.hint,
    );
    this.scene = hasWebGl() ? this.begin() : null;
    if (this.scene === null) {
      this.host.removeAttribute("tabindex");
      this.host.setAttribute("role", "group");
      this.host.append(this.picture);
    } else {
      this.hint.before(this.toolbar());
    }
    this.clear();
    followTheme((theme) => {
      this.scene?.setTheme(theme);
      this.setPicture(this.wanted);
    });
  }

  private begin(): Scene | null {
    const reducedMotion = window.matchMedia("(prefers-reduced-motion: reduce)").matches;
    const viewed = (view: string | null): void => {
      this.view.value = view ?? "";
    };
    try {
      return new Scene(this.host, { reducedMotion, viewed });
    } catch {
      // The browser said that it could.
      return null;
    }
  }

  /** Shows the surface of a mesh, and nothing on it, unless it is there already. */
  showMesh(mesh: MeshRecord): Promise<void> {
    if (this.shown !== mesh.id) {
      this.clear();
      this.shown = mesh.id;
      this.surface = this.load(mesh);
    }
    return this.surface;
  }

  /** Takes an invitation back. */
  dismiss(): void {
    if (this.shown === null) {
      this.tell(null);
    }
  }

  /** Shows nothing of any other mesh, while this one is waited for. */
  leaveFor(id: string): void {
    if (this.shown !== id) {
      this.clear();
    }
  }

  clear(): void {
    this.loading.abort();
    this.loading = new AbortController();
    this.picture.hidden = true;
    this.wanted = this.asked = "";
    this.shown = null;
    this.scene?.setMesh(null);
    this.body = NOTHING;
    this.describe(this.body);
    this.tell(null);
    replace(this.hint, this.scene === null && NO_WEBGL);
  }

  setGrasp(grasp: SceneGrasp | null, animate = false): void {
    this.scene?.setGrasp(grasp, { animate });
    if (grasp === null && this.shown !== null) {
      this.setPicture(previewOf(this.shown));
    }
    this.describe(grasp === null ? this.body : graspWords(grasp.contacts, this.size));
  }

  setGhost(grasp: SceneGrasp | null): void {
    this.scene?.setGhost(grasp);
  }

  setRegions(regions: SceneRegion[]): void {
    this.scene?.setRegions(regions);
  }

  setColors(perContact: readonly (readonly number[])[] | null): void {
    this.scene?.setColors(perContact);
  }

  /** What the service draws of it, for browsers that cannot. */
  setPicture(path: string): void {
    this.wanted = path;
    const address = `${path}&theme=${theme()}`;
    if (this.scene === null && path !== "" && address !== this.asked) {
      this.asked = address;
      void this.draw(address);
    }
  }

  private async draw(address: string): Promise<void> {
    try {
      const bytes = await api.blob(address);
      if (this.asked === address) {
        await showBlob(this.picture, bytes);
        this.picture.hidden = this.asked !== address;
      }
    } catch {
      // Words tell what there is.
    }
  }

  onPick(picked: ((hit: Hit) => void) | null): void {
    this.scene?.onPick(picked);
  }

  /** Says what may be done while no body is shown. */
  invite(): void {
    this.tell("Drop a mesh here, or take one of the examples.");
  }

  /** What is seen, in words. */
  private describe(text: string): void {
    this.summary.textContent = text;
  }

  private async load({ id, report }: MeshRecord): Promise<void> {
    this.size = extent(report.bounds);
    this.body = `A body of ${count(report.triangles)} triangles.`;
    this.describe(this.body);
    if (this.scene === null) {
      this.setPicture(previewOf(id));
      return;
    }
    this.tell("Loading the surface…");
    const loading = this.loading;
    try {
      const surface = readMesh(await api.meshFile(id, BUDGET, loading.signal));
      if (loading.signal.aborted) {
        return;
      }
      this.scene.setMesh(surface);
      this.tell(null);
      replace(
        this.hint,
        surface.coarse
          ? `Shown with ${count(surface.triangles.length)} of its ${count(surface.whole)} triangles; planned on all.`
          : null,
      );
    } catch (error) {
      if (!loading.signal.aborted) {
        this.clear();
        throw error;
      }
    }
  }

  private tell(text: string | null): void {
    this.notice.textContent = text ?? "";
    this.notice.hidden = text === null;
  }

  private toolbar(): HTMLElement {
    this.view.addEventListener("change", () => {
      this.scene?.view(this.view.value as (typeof VIEWS)[number]);
    });
    const parts = PARTS.map(([part, title]) => {
      const box = h("input", { type: "checkbox" });
      box.checked = part !== "wireframe";
      box.addEventListener("change", () => {
        this.scene?.setVisible({ [part]: box.checked });
      });
      return h("label", { class: "toggle" }, box, title);
    });
    return h(
      "div",
      { class: "toolbar", role: "group", "aria-label": "What is shown" },
      this.view,
      ...parts,
    );
  }
}

const previewOf = (mesh: string): string => `/meshes/${mesh}/preview.png?width=1024`;

/** Asked of a canvas of its own, as three.js says on the console what it could not have. */
function hasWebGl(): boolean {
  return document.createElement("canvas").getContext("webgl2") !== null;
}
