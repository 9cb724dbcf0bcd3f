// A mesh as stored in its file, and the edges that belong to only one triangle.
import { BufferAttribute, BufferGeometry, DoubleSide, Group, LineBasicMaterial, LineSegments, Mesh, MeshStandardMaterial, Vector3 } from 'three';
import { RED } from './overlays';

export function rawMesh(points: Float32Array): { group: Group; bounds: { min: Vector3; max: Vector3 } } {
  const geometry = new BufferGeometry().setAttribute('position', new BufferAttribute(points, 3)), group = new Group();
  geometry.computeBoundingBox();
  group.add(new Mesh(geometry, new MeshStandardMaterial({ color: 0xb9b4ab, roughness: 0.85, flatShading: true, side: DoubleSide })));
  const edges = openEdges(points);
  if (edges.length > 0) {
    const lines = new LineSegments(new BufferGeometry().setAttribute('position', new BufferAttribute(edges, 3)),
      new LineBasicMaterial({ color: RED, depthTest: false, transparent: true }));
    lines.renderOrder = 10;
    group.add(lines);
  }
  return { group, bounds: geometry.boundingBox! };
}

function openEdges(points: Float32Array): Float32Array {
  const key = (v: number) => `${points[3 * v]},${points[3 * v + 1]},${points[3 * v + 2]}`, once = new Map<string, [number, number]>();
  for (let t = 0; t < points.length / 3; t += 3)
    for (let k = 0; k < 3; ++k) {
      const a = t + k, b = t + (k + 1) % 3, there = `${key(a)} ${key(b)}`, back = `${key(b)} ${key(a)}`;
      if (!once.delete(back)) once.set(there, [a, b]);
    }
  return new Float32Array([...once.values()].flatMap(([a, b]) => [...points.subarray(3 * a, 3 * a + 3), ...points.subarray(3 * b, 3 * b + 3)]));
}
