/** The surface of the body: one geometry in a single colour, and one with a colour per triangle that shows regions. */

import * as THREE from "three";

import { contactColor, type Palette } from "./colors";
import { creases } from "./creases";
import type { SceneMesh } from "./glb";

/** Most triangles of a surface whose sharp edges are drawn. */
const MOST_FOR_CREASES = 200_000;
/** Share of the contact's colour in its region; the rest is that of the body, so that the shape stays visible. */
const TINT = 0.75;

export class Body {
  readonly group = new THREE.Group();
  readonly sphere: THREE.Sphere;
  readonly box: THREE.Box3;
  private readonly plain = new THREE.BufferGeometry();
  private readonly surface: THREE.Mesh;
  private readonly wire: THREE.Mesh;
  private readonly material: THREE.MeshLambertMaterial;
  private readonly wireMaterial: THREE.MeshBasicMaterial;
  private readonly lines: THREE.LineSegments<THREE.BufferGeometry, THREE.LineBasicMaterial>;
  private colored: THREE.BufferGeometry | null = null;
  private regions: readonly (readonly number[])[] | null = null;
  private readonly mesh: SceneMesh;
  private palette: Palette;

  constructor(mesh: SceneMesh, palette: Palette) {
    this.mesh = mesh;
    this.palette = palette;
    this.plain.setAttribute("position", new THREE.BufferAttribute(mesh.positions, 3));
    this.plain.setIndex(new THREE.BufferAttribute(mesh.indices, 1));
    this.plain.computeBoundingSphere();
    this.plain.computeBoundingBox();
    this.sphere = this.plain.boundingSphere ?? new THREE.Sphere();
    this.box = this.plain.boundingBox ?? new THREE.Box3();
    this.material = new THREE.MeshLambertMaterial({
      color: palette.body,
      flatShading: true,
      side: THREE.DoubleSide,
      polygonOffset: true,
      polygonOffsetFactor: 1,
      polygonOffsetUnits: 1,
    });
    this.wireMaterial = new THREE.MeshBasicMaterial({ color: palette.wire, wireframe: true });
    this.surface = new THREE.Mesh(this.plain, this.material);
    this.wire = new THREE.Mesh(this.plain, this.wireMaterial);
    this.wire.visible = false;
    const sharp = new THREE.BufferGeometry();
    if (mesh.triangles.length <= MOST_FOR_CREASES) {
      const { ends, closed } = creases(mesh.positions, mesh.indices);
      // Half the work for software rendering.
      this.material.side = closed ? THREE.FrontSide : THREE.DoubleSide;
      // The edges of a coarsened surface are not those of the body.
      if (!mesh.coarse) {
        sharp.setAttribute("position", new THREE.BufferAttribute(ends, 3));
      }
    }
    this.lines = new THREE.LineSegments(
      sharp,
      new THREE.LineBasicMaterial({ color: palette.crease, transparent: true, opacity: 0.55 }),
    );
    this.group.add(this.surface, this.wire, this.lines);
  }

  /** Three numbers per vertex. */
  get positions(): Float32Array {
    return this.mesh.positions;
  }

  setPalette(palette: Palette): void {
    this.palette = palette;
    this.wireMaterial.color.set(palette.wire);
    this.lines.material.color.set(palette.crease);
    if (this.regions === null) {
      this.material.color.set(palette.body);
    } else {
      this.setRegions(this.regions);
    }
  }

  setWireframe(visible: boolean): void {
    this.wire.visible = visible;
  }

  /** Colours the triangles, by their numbers in the file, that each contact may be on; `null` colours none. */
  setRegions(perContact: readonly (readonly number[])[] | null): void {
    this.regions = perContact;
    this.colored?.dispose();
    this.colored = null;
    if (perContact === null) {
      this.surface.geometry = this.plain;
      this.material.vertexColors = false;
      this.material.color.set(this.palette.body);
    } else {
      const body = new THREE.Color(this.palette.body);
      const colors = perContact.map((_, index) =>
        body.clone().lerp(new THREE.Color(contactColor(index)), TINT),
      );
      this.colored = this.plain.toNonIndexed();
      const paint = regionColors(
        this.mesh.triangles,
        perContact,
        colors.map((color) => [color.r, color.g, color.b]),
        [body.r, body.g, body.b],
      );
      this.colored.setAttribute("color", new THREE.BufferAttribute(paint, 3));
      this.surface.geometry = this.colored;
      this.material.vertexColors = true;
      this.material.color.set("#ffffff");
    }
    this.material.needsUpdate = true;
  }

  /** The first triangle along a ray, by its number in the file, and the point of intersection. */
  pick(ray: THREE.Raycaster): { triangle: number; point: THREE.Vector3 } | null {
    const hit = ray.intersectObject(this.surface, false)[0];
    const triangle = this.mesh.triangles[hit?.faceIndex ?? -1];
    return hit === undefined || triangle === undefined ? null : { triangle, point: hit.point };
  }

  dispose(): void {
    this.plain.dispose();
    this.lines.geometry.dispose();
    this.lines.material.dispose();
    this.colored?.dispose();
    this.material.dispose();
    this.wireMaterial.dispose();
  }
}

type Rgb = readonly [number, number, number];

/**
 * Nine numbers per triangle: the colour of the contact in whose region it lies, the mean colour if it lies in several
 * regions, and the colour of the body otherwise.
 */
export function regionColors(
  triangles: Uint32Array,
  perContact: readonly (readonly number[])[],
  colors: readonly (readonly number[])[],
  body: Rgb,
): Float32Array<ArrayBuffer> {
  const sums = new Map<number, [number, number, number, number]>();
  perContact.forEach((region, contact) => {
    const [r = 0, g = 0, b = 0] = colors[contact] ?? [];
    for (const triangle of region) {
      const sum = sums.get(triangle) ?? [0, 0, 0, 0];
      sums.set(triangle, [sum[0] + r, sum[1] + g, sum[2] + b, sum[3] + 1]);
    }
  });
  const paint = new Float32Array(9 * triangles.length);
  triangles.forEach((triangle, index) => {
    const sum = sums.get(triangle);
    const color: Rgb =
      sum === undefined ? body : [sum[0] / sum[3], sum[1] / sum[3], sum[2] / sum[3]];
    for (let corner = 0; corner < 3; corner += 1) {
      paint.set(color, 9 * index + 3 * corner);
    }
  });
  return paint;
}
