/** Sharp and open edges of a surface, which are drawn as lines. */

/** Angle between two triangles, in radians, from which their edge is sharp. */
const SHARP = (35 * Math.PI) / 180;

export interface Creases {
  /** Both ends of each edge where the surface bends sharply or ends: six numbers per edge. */
  ends: Float32Array<ArrayBuffer>;
  /** Whether every edge has two consistently wound triangles: the inner side is then never visible. */
  closed: boolean;
}

/** O(triangles) in time and memory. */
export function creases(positions: Float32Array, indices: Uint32Array): Creases {
  const vertices = positions.length / 3;
  const normals = triangleNormals(positions, indices);
  const limit = Math.cos(SHARP);
  // The corner at which each edge starts in its first triangle, until its second triangle is found.
  const open = new Map<number, number>();
  const ends: number[] = [];
  let closed = true;
  const draw = (edge: number): void => {
    for (const end of [Math.floor(edge / vertices), edge % vertices]) {
      ends.push(...positions.subarray(3 * end, 3 * end + 3));
    }
  };
  for (let corner = 0; corner < indices.length; corner += 1) {
    const next = corner % 3 === 2 ? corner - 2 : corner + 1;
    const a = indices[corner] ?? 0;
    const b = indices[next] ?? 0;
    const edge = Math.min(a, b) * vertices + Math.max(a, b);
    const other = open.get(edge);
    if (other === undefined) {
      open.set(edge, corner);
    } else {
      open.delete(edge);
      closed &&= indices[other] !== a;
      if (dot(normals, Math.floor(corner / 3), Math.floor(other / 3)) < limit) {
        draw(edge);
      }
    }
  }
  for (const edge of open.keys()) {
    draw(edge);
  }
  return { ends: new Float32Array(ends), closed: closed && open.size === 0 };
}

/** Unit normals, three numbers per triangle; zero if it has no area. */
function triangleNormals(positions: Float32Array, indices: Uint32Array): Float32Array {
  const normals = new Float32Array(indices.length);
  const at = (corner: number, axis: number): number =>
    positions[3 * (indices[corner] ?? 0) + axis] ?? 0;
  for (let first = 0; first < indices.length; first += 3) {
    const side = (corner: number, axis: number): number =>
      at(first + corner, axis) - at(first, axis);
    const x = side(1, 1) * side(2, 2) - side(1, 2) * side(2, 1);
    const y = side(1, 2) * side(2, 0) - side(1, 0) * side(2, 2);
    const z = side(1, 0) * side(2, 1) - side(1, 1) * side(2, 0);
    const length = Math.hypot(x, y, z);
    if (length > 0) {
      normals.set([x / length, y / length, z / length], first);
    }
  }
  return normals;
}

function dot(normals: Float32Array, one: number, other: number): number {
  let sum = 0;
  for (let axis = 0; axis < 3; axis += 1) {
    sum += (normals[3 * one + axis] ?? 0) * (normals[3 * other + axis] ?? 0);
  }
  return sum;
}
