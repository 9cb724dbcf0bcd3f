/** Computes missing vertex normals as the area-weighted mean of the triangles' normals. Used if other vertices of the same answer
 * have normals. */
export function normalsOf(positions: ArrayLike<number>, triangles: ArrayLike<number>): Float32Array {
  const normals = new Float32Array(positions.length);
  for (let t = 0; t < triangles.length; t += 3) {
    const [a, b, c] = [3 * triangles[t]!, 3 * triangles[t + 1]!, 3 * triangles[t + 2]!];
    const e = [0, 1, 2].map(k => positions[b + k]! - positions[a + k]!), f = [0, 1, 2].map(k => positions[c + k]! - positions[a + k]!);
    const normal = [e[1]! * f[2]! - e[2]! * f[1]!, e[2]! * f[0]! - e[0]! * f[2]!, e[0]! * f[1]! - e[1]! * f[0]!];
    for (const corner of [a, b, c]) for (let k = 0; k < 3; ++k) normals[corner + k]! += normal[k]!;
  }
  for (let k = 0; k < normals.length; k += 3) {
    const size = Math.hypot(normals[k]!, normals[k + 1]!, normals[k + 2]!) || 1;
    for (let axis = 0; axis < 3; ++axis) normals[k + axis]! /= size;
  }
  return normals;
}
