/** The 3-D view and everything around it: loading, toolbar, notices, and descriptions for screen readers. */

import * as api from "./api/client";
import type { MeshRecord } from "./api/types";
import { h, replace, showBlob } from "./dom";
import { type Hit, type Part, readMesh, Scene, type SceneGrasp, type SceneRegion } from "./scene";
import { followTheme, theme } from "./theme";
import { count, extent } from "./text/format";
import { graspWords } from "./text/words";

/** Most triangles that are drawn: software rendering can rotate this many without stalling. */
const BUDGET = 150_000;

const NO_WEBGL =
  "This browser has no WebGL: pictures are shown instead of a body that can be turned.";

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
  /** A picture drawn by the service, for browsers without WebGL. */
  private readonly picture = h("img", { alt: "", hidden: true });
  /** The path of the picture, without the theme. */
  private picturePath = "";
  /** The URL of the picture that is shown or being loaded. */
  private pictureUrl = "";
  private readonly summary = h("p", { class: "visually-hidden", id: "scene-summary" });
  private readonly scene: Scene | null;
  private shown: string | null = null;
  /** A description of the body for screen readers. */
  private body = NOTHING;
  private size = 0;
  private loading = new AbortController();
  /** Settles once the body of the mesh is shown. */
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
    this.scene = hasWebGl() ? this.createScene() : null;
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
      this.setPicture(this.picturePath);
    });
  }

  private createScene(): Scene | null {
    const reducedMotion = window.matchMedia("(prefers-reduced-motion: reduce)").matches;
    const onViewChange = (view: string | null): void => {
      this.view.value = view ?? "";
    };
    try {
      return new Scene(this.host, { reducedMotion, onViewChange });
    } catch {
      // The browser has claimed to support WebGL, but fails.
      return null;
    }
  }

  /** Shows the surface of a mesh without a grasp, unless that mesh is already shown. */
  showMesh(mesh: MeshRecord): Promise<void> {
    if (this.shown !== mesh.id) {
      this.clear();
      this.shown = mesh.id;
      this.surface = this.load(mesh);
    }
    return this.surface;
  }

  /** Hides the invitation. */
  dismiss(): void {
    if (this.shown === null) {
      this.showNotice(null);
    }
  }

  /** Clears the view unless it shows the mesh with this id. */
  keepOnly(id: string): void {
    if (this.shown !== id) {
      this.clear();
    }
  }

  clear(): void {
    this.loading.abort();
    this.loading = new AbortController();
    this.picture.hidden = true;
    this.picturePath = this.pictureUrl = "";
    this.shown = null;
    this.scene?.setMesh(null);
    this.body = NOTHING;
    this.describe(this.body);
    this.showNotice(null);
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

  /** Shows a picture drawn by the service, if the browser has no WebGL. */
  setPicture(path: string): void {
    this.picturePath = path;
    const url = `${path}&theme=${theme()}`;
    if (this.scene === null && path !== "" && url !== this.pictureUrl) {
      this.pictureUrl = url;
      void this.draw(url);
    }
  }

  private async draw(url: string): Promise<void> {
    try {
      const bytes = await api.blob(url);
      if (this.pictureUrl === url) {
        await showBlob(this.picture, bytes);
        this.picture.hidden = this.pictureUrl !== url;
      }
    } catch {
      // The description of the body remains.
    }
  }

  onPick(picked: ((hit: Hit) => void) | null): void {
    this.scene?.onPick(picked);
  }

  /** Shows how to choose a mesh, while no body is shown. */
  invite(): void {
    this.showNotice("Drop a mesh here, or choose one of the examples.");
  }

  /** Sets the description for screen readers. */
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
    this.showNotice("Loading the surface…");
    const loading = this.loading;
    try {
      const surface = readMesh(await api.meshFile(id, BUDGET, loading.signal));
      if (loading.signal.aborted) {
        return;
      }
      this.scene.setMesh(surface);
      this.showNotice(null);
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

  private showNotice(text: string | null): void {
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

/** Uses a canvas of its own, because three.js writes to the console when it fails. */
function hasWebGl(): boolean {
  return document.createElement("canvas").getContext("webgl2") !== null;
}
