/** The body and the grasp in three dimensions; drawn when something has changed and at no other time. */

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
/** Of a movement that begins, in milliseconds: how long the frame before it was tells nothing. */
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
  /** The view that is shown, until the reader turns the body. */
  private fitted: ViewName | null = null;
  /** Whom to tell which view is shown. */
  private readonly viewed: (view: ViewName | null) => void;
  private pending = false;
  private moving = false;
  private before = 0;
  private picked: ((hit: Hit) => void) | null = null;
  /** Where a click may have begun. */
  private down: [number, number] | null = null;

  /** Throws where the browser has no WebGL. */
  constructor(
    host: HTMLElement,
    options: { reducedMotion: boolean; viewed: (view: ViewName | null) => void },
  ) {
    this.host = host;
    this.viewed = options.viewed;
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
    // A click alone begins and ends, too, and turns nothing.
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
      // A second finger zooms, another button moves.
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
      this.notice.textContent = "The browser has taken the 3-D view away for now. All else works.";
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

  /** Another grasp to compare with, faint. */
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

  /** Where each contact may be alone: numbers of triangles in the file, in the order of the contacts. */
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

  /** Shows the whole body from a side. */
  view(name: ViewName): void {
    if (this.body !== null) {
      look(name, this.camera, this.controls, this.body);
      this.fitted = name;
      this.viewed(name);
      this.render();
    }
  }

  /** Whom to tell when a place on the body is chosen. */
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

  /** Light from above, and a lamp over the shoulder that goes with the eye. */
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
      // Who has turned the body keeps what they see.
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
    this.viewed(null);
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
