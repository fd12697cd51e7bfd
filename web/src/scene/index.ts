/** The 3-D scene with the body and the grasp. It is drawn only when something has changed. */

import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";

import { Axes } from "./axes";
import { Body } from "./body";
import { FIELD, look, moveByKey } from "./camera";
import { PALETTES } from "./colors";
import type { SceneMesh } from "./glb";
import { GraspMarks } from "./grasp";
import { disposeAll } from "./marks";
import { regionMark } from "./regions";
import type { Hit, Part, SceneGrasp, SceneRegion, ViewName } from "./types";

export { readMesh, type SceneMesh } from "./glb";
export * from "./types";

/** How far the pointer may move between down and up for a click, in pixels. */
const CLICK = 4;
/** Duration assumed for the first frame of a movement, in milliseconds: no earlier frame measures it. */
const FIRST_STEP = 16;

export class Scene {
  private readonly host: HTMLElement;
  private readonly renderer: THREE.WebGLRenderer;
  private readonly scene = new THREE.Scene();
  private readonly camera = new THREE.PerspectiveCamera(FIELD);
  private readonly controls: OrbitControls;
  private readonly axes = new Axes();
  private readonly regions = new THREE.Group();
  private readonly visible: Record<Part, boolean> = {
    arrows: true,
    cones: true,
    weakest: true,
    regions: true,
    wireframe: false,
  };
  private readonly notice = document.createElement("p");
  private readonly reducedMotion: boolean;
  private theme: "light" | "dark" = "light";
  private body: Body | null = null;
  private origin = new THREE.Vector3();
  private marks: GraspMarks | null = null;
  private ghost: GraspMarks | null = null;
  /** The current named view; `null` once the user has turned the body. */
  private fitted: ViewName | null = null;
  /** Called with the named view that is shown, or `null` after the user has turned the body. */
  private readonly onViewChange: (view: ViewName | null) => void;
  private pending = false;
  private moving = false;
  private before = 0;
  private picked: ((hit: Hit) => void) | null = null;
  /** Position of the last pointer press, which may become a click. */
  private down: [number, number] | null = null;

  /** Throws if the browser has no WebGL. */
  constructor(
    host: HTMLElement,
    options: { reducedMotion: boolean; onViewChange: (view: ViewName | null) => void },
  ) {
    this.host = host;
    this.onViewChange = options.onViewChange;
    this.reducedMotion = options.reducedMotion;
    this.renderer = new THREE.WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    const canvas = this.renderer.domElement;
    canvas.setAttribute("aria-hidden", "true");
    host.append(canvas);
    this.camera.up.set(0, 0, 1);
    this.scene.add(this.camera, this.regions);
    this.light();
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enableDamping = false;
    this.controls.zoomToCursor = true;
    // A mere click also sends start and end, but turns nothing.
    let byHand = false;
    this.controls.addEventListener("start", () => {
      byHand = true;
    });
    this.controls.addEventListener("end", () => {
      byHand = false;
    });
    this.controls.addEventListener("change", () => {
      if (byHand) {
        this.turned();
      }
      this.render();
    });
    host.addEventListener("keydown", (event) => {
      this.key(event);
    });
    canvas.addEventListener("pointerdown", (event) => {
      // A second finger zooms, and other buttons pan.
      const points = event.isPrimary && event.button === 0;
      this.down = points ? [event.clientX, event.clientY] : null;
    });
    canvas.addEventListener("pointerup", (event) => {
      this.click(event);
    });
    this.notice.className = "notice";
    this.notice.setAttribute("role", "status");
    canvas.addEventListener("webglcontextlost", (event) => {
      event.preventDefault();
      this.notice.textContent =
        "The browser has suspended the 3-D view for now. Everything else works.";
      host.append(this.notice);
    });
    canvas.addEventListener("webglcontextrestored", () => {
      this.notice.remove();
      this.render();
    });
    new ResizeObserver(() => {
      this.resize();
    }).observe(host);
    this.resize();
    this.setTheme("light");
  }

  setMesh(mesh: SceneMesh | null): void {
    this.clear();
    if (mesh !== null) {
      this.body = new Body(mesh, PALETTES[this.theme]);
      this.origin = new THREE.Vector3(...mesh.origin);
      const radius = this.body.sphere.radius;
      this.marks = new GraspMarks(radius, this.origin, this.visible);
      this.ghost = new GraspMarks(radius, this.origin, this.visible, PALETTES[this.theme].ghost);
      this.scene.add(this.body.group, this.marks.group, this.ghost.group);
      this.body.setWireframe(this.visible.wireframe);
      this.view("iso");
    }
    this.host.dataset["triangles"] = String(mesh?.triangles.length ?? 0);
    this.render();
  }

  /** Shows a grasp; with `animate` its contacts move there from the nearest of those shown. */
  setGrasp(grasp: SceneGrasp | null, options: { animate?: boolean } = {}): void {
    this.marks?.set(grasp, options.animate === true && !this.reducedMotion);
    this.render();
  }

  /** Shows a second grasp faintly, for comparison. */
  setGhost(grasp: SceneGrasp | null): void {
    this.ghost?.set(grasp, false);
    this.render();
  }

  setRegions(regions: SceneRegion[]): void {
    disposeAll(this.regions);
    this.regions.clear();
    const body = this.body?.sphere;
    if (body !== undefined) {
      for (const region of regions) {
        this.regions.add(regionMark(region, body, this.origin));
      }
    }
    this.render();
  }

  /** Colours the triangles of each contact's independent region, given by their numbers in the file. */
  setColors(perContact: readonly (readonly number[])[] | null): void {
    this.body?.setRegions(perContact);
    this.render();
  }

  setTheme(theme: "light" | "dark"): void {
    this.theme = theme;
    this.scene.background = new THREE.Color(PALETTES[theme].background);
    this.body?.setPalette(PALETTES[theme]);
    this.ghost?.setColor(PALETTES[theme].ghost);
    this.render();
  }

  setVisible(parts: Partial<Record<Part, boolean>>): void {
    Object.assign(this.visible, parts);
    this.marks?.applyVisible();
    this.ghost?.applyVisible();
    this.body?.setWireframe(this.visible.wireframe);
    this.regions.visible = this.visible.regions;
    this.render();
  }

  /** Shows the whole body from the side with this name. */
  view(name: ViewName): void {
    if (this.body !== null) {
      look(name, this.camera, this.controls, this.body);
      this.fitted = name;
      this.onViewChange(name);
      this.render();
    }
  }

  /** Sets the function that is called when the user clicks a place on the body. */
  onPick(picked: ((hit: Hit) => void) | null): void {
    this.picked = picked;
  }

  private clear(): void {
    for (const part of [this.body, this.marks, this.ghost]) {
      if (part !== null) {
        this.scene.remove(part.group);
        part.dispose();
      }
    }
    this.body = this.marks = this.ghost = null;
    disposeAll(this.regions);
    this.regions.clear();
  }

  /** Light from above, and a lamp that moves with the camera. */
  private light(): void {
    const sky = new THREE.HemisphereLight("#ffffff", "#59616e", 1.5);
    sky.position.set(0, 0, 1);
    const lamp = new THREE.DirectionalLight("#ffffff", 2.2);
    lamp.position.set(-0.8, 1, 0.9);
    this.camera.add(lamp, lamp.target);
    this.scene.add(sky);
  }

  private resize(): void {
    const { clientWidth, clientHeight } = this.host;
    if (clientWidth > 0 && clientHeight > 0) {
      this.renderer.setSize(clientWidth, clientHeight);
      this.camera.aspect = clientWidth / clientHeight;
      this.camera.updateProjectionMatrix();
      // Keep the view of a user who has turned the body.
      if (this.fitted !== null) {
        this.view(this.fitted);
      }
      this.render();
    }
  }

  private render(): void {
    if (!this.pending) {
      this.pending = true;
      requestAnimationFrame((now) => {
        this.frame(now);
      });
    }
  }

  private frame(now: number): void {
    this.pending = false;
    const passed = this.moving ? now - this.before : FIRST_STEP;
    this.before = now;
    this.moving = this.marks?.step(passed) ?? false;
    this.renderer.render(this.scene, this.camera);
    if (this.body !== null) {
      this.axes.render(this.renderer, this.camera);
    }
    if (this.moving) {
      this.render();
    }
  }

  private key(event: KeyboardEvent): void {
    if (event.key === "Home") {
      this.view("iso");
    } else if (
      event.ctrlKey ||
      event.metaKey ||
      event.altKey ||
      !moveByKey(event.key, this.controls)
    ) {
      return;
    } else {
      this.turned();
    }
    event.preventDefault();
    this.render();
  }

  private turned(): void {
    this.fitted = null;
    this.onViewChange(null);
  }

  private click(event: PointerEvent): void {
    const { down } = this;
    this.down = null;
    if (down === null || this.body === null || this.picked === null) {
      return;
    }
    if (Math.hypot(event.clientX - down[0], event.clientY - down[1]) >= CLICK) {
      return;
    }
    const { left, top, width, height } = this.host.getBoundingClientRect();
    const at = new THREE.Vector2(
      (2 * (event.clientX - left)) / width - 1,
      1 - (2 * (event.clientY - top)) / height,
    );
    const ray = new THREE.Raycaster();
    ray.setFromCamera(at, this.camera);
    const hit = this.body.pick(ray);
    if (hit !== null) {
      const { x, y, z } = hit.point.add(this.origin);
      this.picked({ triangle: hit.triangle, position: [x, y, z] });
    }
  }
}
