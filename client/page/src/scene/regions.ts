// Draws the points, regions and directions that are set.
import { ArrowHelper, Box3, Box3Helper, type Color, DoubleSide, Group, LineBasicMaterial, LineSegments, Mesh, MeshBasicMaterial, PlaneGeometry, SphereGeometry, Vector3, WireframeGeometry } from 'three';
import { type PlaceKind, radiusOf } from '../state/places';
import type { Settings } from '../state/request';
import { type Extent, footOf, rows, TIP, vectorOf } from './gizmos';

export function regionsOf(settings: Settings, places: ReadonlyMap<string, PlaceKind>, color: Color, { middle, size }: Extent): Group {
  const group = new Group();
  const plane = (at: Vector3, unit: Vector3, opacity: number) => {
    const mesh = new Mesh(new PlaneGeometry(1.3 * size, 1.3 * size), new MeshBasicMaterial({ color, transparent: true, opacity, side: DoubleSide, depthWrite: false }));
    mesh.position.copy(at);
    mesh.lookAt(at.clone().add(unit));
    group.add(mesh);
  };
  const arrow = (from: Vector3, unit: Vector3, length: number) => group.add(new ArrowHelper(unit, from, length, color, 0.16 * length, 0.08 * length));
  for (const [name, kind] of places) {
    const value = settings[name];
    if (value === undefined) continue;
    if (kind === 'sphere') {
      const at = vectorOf(value), radius = settings[radiusOf(name)];
      if (!at || typeof radius !== 'number') continue;
      const lines = new LineSegments(new WireframeGeometry(new SphereGeometry(radius, 24, 14)), new LineBasicMaterial({ color, transparent: true, opacity: 0.5 }));
      lines.position.copy(at);
      group.add(lines);
    } else if (kind === 'box') {
      const [low, high] = rows(value);
      if (low && high) group.add(new Box3Helper(new Box3(low, high), color));
    } else if (kind === 'plane') {
      const [at, normal] = rows(value);
      if (!at || !normal || normal.lengthSq() === 0) continue;
      const unit = normal.normalize(), foot = footOf(at, unit, middle);
      plane(foot, unit, 0.18);
      arrow(foot, unit, 0.3 * size);
    } else {
      for (const along of kind === 'direction' ? [vectorOf(value)] : rows(value)) {
        if (!along || along.lengthSq() === 0) continue;
        const unit = along.normalize();
        if (kind === 'normals') plane(middle, unit, 0.12);
        arrow(middle.clone().addScaledVector(unit, kind === 'normals' ? 0 : 0.3 * size), unit, kind === 'normals' ? TIP * size : (TIP - 0.3) * size);
      }
    }
  }
  // Lines show through the mesh, because most of them are inside it.
  group.traverse(object => {
    if (object instanceof Mesh && object.geometry instanceof PlaneGeometry) return;
    object.renderOrder = 15;
    const { material } = object as LineSegments;
    if (material) Object.assign(material, { depthTest: false, transparent: true });
  });
  return group;
}
