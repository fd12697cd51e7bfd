/** Reads the kind of GLB that the service writes for meshes, and no other. */

import type { Vec3 } from "../api/types";

export interface SceneMesh {
  /** Positions relative to `origin`, three numbers per vertex. */
  positions: Float32Array;
  indices: Uint32Array;
  /** Number of each triangle in the file; in a coarsened mesh, the number of a triangle near it. */
  triangles: Uint32Array;
  /** Offset that single precision could not represent. */
  origin: Vec3;
  coarse: boolean;
  /** Number of triangles of the whole mesh. */
  whole: number;
}

interface Accessor {
  bufferView: number;
  count: number;
  type: "SCALAR" | "VEC3";
}

interface Gltf {
  nodes: {
    name: string;
    translation?: Vec3;
    extras?: { coarse?: boolean; triangles_of_the_mesh?: number };
  }[];
  meshes: {
    primitives: {
      attributes: { POSITION: number };
      indices: number;
      extras: { triangles: number };
    }[];
  }[];
  accessors: Accessor[];
  bufferViews: { byteOffset: number; byteLength: number }[];
}

const MAGIC = 0x46546c67;

export function readMesh(file: ArrayBuffer): SceneMesh {
  const head = new DataView(file);
  if (file.byteLength < 28 || head.getUint32(0, true) !== MAGIC) {
    throw new Error("the file is no GLB");
  }
  const length = head.getUint32(12, true);
  const gltf = JSON.parse(new TextDecoder().decode(new Uint8Array(file, 20, length))) as Gltf;
  const start = 20 + length + 8;
  const bytes = (index: number): [number, number] => {
    const accessor = gltf.accessors[index];
    const view = gltf.bufferViews[accessor?.bufferView ?? -1];
    if (accessor === undefined || view === undefined) {
      throw new Error("the GLB lacks an accessor");
    }
    return [start + view.byteOffset, accessor.count * (accessor.type === "VEC3" ? 3 : 1)];
  };
  const primitive = gltf.meshes[0]?.primitives[0];
  if (primitive === undefined) {
    throw new Error("the GLB has no mesh");
  }
  const root = gltf.nodes.find((node) => node.extras !== undefined)?.extras;
  const triangles = new Uint32Array(file, ...bytes(primitive.extras.triangles));
  return {
    positions: new Float32Array(file, ...bytes(primitive.attributes.POSITION)),
    indices: new Uint32Array(file, ...bytes(primitive.indices)),
    triangles,
    origin: gltf.nodes.find((node) => node.name === "mesh")?.translation ?? [0, 0, 0],
    coarse: root?.coarse ?? false,
    whole: root?.triangles_of_the_mesh ?? triangles.length,
  };
}
