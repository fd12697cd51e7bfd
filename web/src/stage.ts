/** The three-dimensional view with what belongs to it: loading, views, what is shown, words for those who do not see. */

import * as api from "./api/client";
import type { MeshRecord } from "./api/types";
import { h, replace } from "./dom";
import { type Hit, type Part, readMesh, Scene, type SceneGrasp, type SceneRegion } from "./scene";
import { followTheme } from "./theme";
import { count } from "./text/format";

/** Most triangles that are drawn: software rendering turns so many without stalling. */
const BUDGET = 150_000;

const NO_WEBGL = "This browser has no WebGL, so nothing can be shown in 3-D. All else works.";

const VIEWS = ["iso", "front", "back", "left", "right", "top", "bottom"] as const;
const PARTS: [Part, string][] = [
  ["arrows", "Arrows"],
  ["cones", "Friction cones"],
  ["weakest", "Centre of mass and weakest wrench"],
  ["wireframe", "Triangles"],
];

export class Stage {
  readonly element: HTMLElement;
  private readonly host: HTMLElement;
  private readonly notice = h("p", { class: "notice", hidden: true });
  private readonly hint = h("p", { class: "hint" });
  private readonly summary = h("p", { class: "visually-hidden", id: "scene-summary" });
  private readonly scene: Scene | null;
  private shown: string | null = null;
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
      this.toolbar(),
      this.hint,
    );
    let scene: Scene | null = null;
    try {
      const reducedMotion = window.matchMedia("(prefers-reduced-motion: reduce)").matches;
      scene = new Scene(this.host, { reducedMotion });
    } catch {
      // The notice says so.
    }
    this.scene = scene;
    this.tell(null);
    followTheme((theme) => this.scene?.setTheme(theme));
  }

  /** Shows the surface of a mesh, and nothing on it, unless it is there already. */
  showMesh(mesh: MeshRecord): Promise<void> {
    if (this.shown !== mesh.id) {
      this.clear();
      this.shown = mesh.id;
      this.surface = this.load(mesh.id);
    }
    return this.surface;
  }

  clear(): void {
    this.loading.abort();
    this.shown = null;
    this.scene?.setMesh(null);
    this.describe("No body is shown.");
    this.tell(null);
    replace(this.hint);
  }

  setGrasp(grasp: SceneGrasp | null, animate = false): void {
    this.scene?.setGrasp(grasp, { animate });
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

  onPick(picked: ((hit: Hit) => void) | null): void {
    this.scene?.onPick(picked);
  }

  /** Says what may be done while no body is shown. */
  invite(): void {
    this.tell("Drop a mesh here, or take one of the examples.");
  }

  /** What is seen, in words, until another body is shown. */
  describe(text: string): void {
    this.summary.textContent = text;
  }

  private async load(id: string): Promise<void> {
    this.tell("Loading the surface…");
    const loading = (this.loading = new AbortController());
    try {
      const surface = readMesh(await api.meshFile(id, BUDGET, loading.signal));
      if (loading.signal.aborted) {
        return;
      }
      this.scene?.setMesh(surface);
      this.describe(`A body of ${count(surface.whole)} triangles.`);
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
    const said = this.scene === null ? NO_WEBGL : text;
    this.notice.textContent = said ?? "";
    this.notice.hidden = said === null;
  }

  private toolbar(): HTMLElement {
    const view = h(
      "select",
      {
        "aria-label": "View",
        onchange: () => {
          this.scene?.view(view.value as (typeof VIEWS)[number]);
        },
      },
      ...VIEWS.map((name) => h("option", { value: name }, name === "iso" ? "oblique" : name)),
    );
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
      view,
      ...parts,
    );
  }
}
