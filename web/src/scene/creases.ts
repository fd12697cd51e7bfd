/** Sharp and open edges of a surface, which lines make plain. */

/** Angle between two triangles, in radians, from which their edge is sharp. */
const SHARP = (35 * Math.PI) / 180;

/**
 * Both ends of each edge where the surface bends sharply, ends, or has more than two triangles: six numbers an edge.
 * O(triangles) in time and memory.
 */
export function creases(positions: Float32Array, indices: Uint32Array): Float32Array<ArrayBuffer> {
  const vertices = positions.length / 3;
  const normals = triangleNormals(positions, indices);
  const limit = Math.cos(SHARP);
  // The first triangle of every edge whose second one has not come yet.
  const open = new Map<number, number>();
  const ends: number[] = [];
  const draw = (edge: number): void => {
    for (const end of [Math.floor(edge / vertices), edge % vertices]) {
      ends.push(...positions.subarray(3 * end, 3 * end + 3));
    }
  };
  for (let triangle = 0; 3 * triangle < indices.length; triangle += 1) {
    for (let corner = 0; corner < 3; corner += 1) {
      const a = indices[3 * triangle + corner] ?? 0;
      const b = indices[3 * triangle + ((corner + 1) % 3)] ?? 0;
      const edge = Math.min(a, b) * vertices + Math.max(a, b);
      const other = open.get(edge);
      if (other === undefined) {
        open.set(edge, triangle);
      } else {
        open.delete(edge);
        if (dot(normals, triangle, other) < limit) {
          draw(edge);
        }
      }
    }
  }
  for (const edge of open.keys()) {
    draw(edge);
  }
  return new Float32Array(ends);
}

/** Unit normals, three numbers a triangle; zero where it has no area. */
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
