/** The body and the grasp in three dimensions; drawn when something has changed and at no other time. */

import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";

import { Body } from "./body";
import { PALETTES } from "./colors";
import type { SceneMesh } from "./glb";
import { GraspMarks } from "./grasp";
import { disposeAll } from "./marks";
import { regionMark } from "./regions";
import type { Hit, Part, SceneGrasp, SceneRegion, ViewName } from "./types";

export { readMesh, type SceneMesh } from "./glb";
export * from "./types";

/** Direction to the eye; the first is that of the service's own pictures. */
const VIEWS: Record<ViewName, [number, number, number]> = {
  iso: [0.62, -1, 0.62],
  front: [0, -1, 0],
  back: [0, 1, 0],
  left: [-1, 0, 0],
  right: [1, 0, 0],
  top: [0, -1e-3, 1],
  bottom: [0, -1e-3, -1],
};
const FIELD = 30;
const TURN = Math.PI / 24;
const ZOOM = 1.15;
/** How far the pointer may move between down and up for a click, in pixels. */
const CLICK = 4;

export class Scene {
  private readonly host: HTMLElement;
  private readonly renderer: THREE.WebGLRenderer;
  private readonly scene = new THREE.Scene();
  private readonly camera = new THREE.PerspectiveCamera(FIELD);
  private readonly controls: OrbitControls;
  private readonly lamp = new THREE.DirectionalLight("#ffffff", 2.1);
  private readonly regions = new THREE.Group();
  private readonly visible: Record<Part, boolean> = {
    arrows: true,
    cones: true,
    weakest: true,
    wireframe: false,
  };
  private readonly reducedMotion: boolean;
  private readonly observer: ResizeObserver;
  private theme: "light" | "dark" = "light";
  private body: Body | null = null;
  private origin = new THREE.Vector3();
  private marks: GraspMarks | null = null;
  private ghost: GraspMarks | null = null;
  private pending = false;
  private before = 0;
  private picked: ((hit: Hit) => void) | null = null;
  private down: [number, number] = [0, 0];

  /** Throws where the browser has no WebGL. */
  constructor(host: HTMLElement, options: { reducedMotion: boolean }) {
    this.host = host;
    this.reducedMotion = options.reducedMotion;
    this.renderer = new THREE.WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    const canvas = this.renderer.domElement;
    canvas.setAttribute("aria-hidden", "true");
    host.append(canvas);
    this.camera.up.set(0, 0, 1);
    this.scene.add(this.camera, this.regions, new THREE.HemisphereLight("#ffffff", "#8f98a8", 1.5));
    this.camera.add(this.lamp);
    this.lamp.position.set(-0.5, 0.9, 0.6);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enableDamping = false;
    this.controls.zoomToCursor = true;
    this.controls.addEventListener("change", () => {
      this.render();
    });
    host.addEventListener("keydown", (event) => {
      this.key(event);
    });
    canvas.addEventListener("pointerdown", (event) => {
      this.down = [event.clientX, event.clientY];
    });
    canvas.addEventListener("pointerup", (event) => {
      this.click(event);
    });
    canvas.addEventListener("webglcontextlost", (event) => {
      event.preventDefault();
    });
    canvas.addEventListener("webglcontextrestored", () => {
      this.render();
    });
    this.observer = new ResizeObserver(() => {
      this.resize();
    });
    this.observer.observe(host);
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
      this.ghost = new GraspMarks(radius, this.origin, {
        ...this.visible,
        cones: false,
        weakest: false,
      });
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
    this.ghost?.group.traverse((object) => {
      if (object instanceof THREE.Mesh) {
        const material = object.material as THREE.MeshBasicMaterial;
        material.transparent = true;
        material.opacity = 0.25;
        material.color.set(PALETTES[this.theme].ghost);
      }
    });
    this.render();
  }

  setRegions(regions: SceneRegion[]): void {
    disposeAll(this.regions);
    this.regions.clear();
    const body = this.body?.sphere;
    if (body !== undefined) {
      this.regions.add(...regions.map((region) => regionMark(region, body, this.origin)));
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
    this.render();
  }

  setVisible(parts: Partial<Record<Part, boolean>>): void {
    Object.assign(this.visible, parts);
    this.marks?.applyVisible();
    this.body?.setWireframe(this.visible.wireframe);
    this.render();
  }

  view(name: ViewName): void {
    const body = this.body?.sphere;
    if (body === undefined) {
      return;
    }
    // The arrows stand out from the body by half its radius.
    const radius = 1.45 * body.radius;
    const half = Math.tan((FIELD * Math.PI) / 360) * Math.min(1, this.camera.aspect);
    const away = radius / Math.sin(Math.atan(half));
    this.controls.target.copy(body.center);
    this.camera.position
      .set(...VIEWS[name])
      .setLength(away)
      .add(body.center);
    this.camera.near = away / 100;
    this.camera.far = away * 20;
    this.camera.updateProjectionMatrix();
    this.controls.minDistance = body.radius * 0.05;
    this.controls.maxDistance = away * 10;
    this.controls.update();
    this.render();
  }

  /** Whom to tell when a place on the body is chosen. */
  onPick(picked: ((hit: Hit) => void) | null): void {
    this.picked = picked;
  }

  dispose(): void {
    this.observer.disconnect();
    this.clear();
    this.controls.dispose();
    this.renderer.dispose();
    this.renderer.domElement.remove();
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

  private resize(): void {
    const { clientWidth, clientHeight } = this.host;
    if (clientWidth > 0 && clientHeight > 0) {
      this.renderer.setSize(clientWidth, clientHeight);
      this.camera.aspect = clientWidth / clientHeight;
      this.camera.updateProjectionMatrix();
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
    // After a rest the first step is a small one.
    const passed = Math.min(now - this.before, 40);
    this.before = now;
    const moving = this.marks?.step(passed) ?? false;
    this.renderer.render(this.scene, this.camera);
    if (moving) {
      this.render();
    }
  }

  private key(event: KeyboardEvent): void {
    const turns: Record<string, [number, number]> = {
      ArrowLeft: [-TURN, 0],
      ArrowRight: [TURN, 0],
      ArrowUp: [0, -TURN],
      ArrowDown: [0, TURN],
    };
    const turn = turns[event.key];
    const offset = this.camera.position.clone().sub(this.controls.target);
    if (turn !== undefined) {
      const place = new THREE.Spherical().setFromVector3(
        new THREE.Vector3(offset.x, offset.z, -offset.y),
      );
      place.theta += turn[0];
      place.phi += turn[1];
      place.makeSafe();
      const { x, y, z } = new THREE.Vector3().setFromSpherical(place);
      offset.set(x, -z, y);
    } else if (event.key === "+" || event.key === "=") {
      offset.divideScalar(ZOOM);
    } else if (event.key === "-") {
      offset.multiplyScalar(ZOOM);
    } else if (event.key === "Home") {
      this.view("iso");
      event.preventDefault();
      return;
    } else {
      return;
    }
    event.preventDefault();
    this.camera.position.copy(this.controls.target).add(offset);
    this.controls.update();
    this.render();
  }

  private click(event: PointerEvent): void {
    const [x, y] = this.down;
    const still = Math.hypot(event.clientX - x, event.clientY - y) < CLICK;
    if (!still || this.body === null || this.picked === null) {
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
