// Overlays on the mesh: open edges and filled holes, the location of a problem, bonds as a graph, the sphere of a hit, and a person
// for scale.
import type { Answer } from 'fracture-client';
import {
  BufferAttribute, BufferGeometry, CanvasTexture, CapsuleGeometry, Color, CylinderGeometry, DoubleSide, Group, InstancedMesh, LineBasicMaterial, LineSegments,
  type Material, Matrix4, Mesh, MeshBasicMaterial, MeshStandardMaterial, Object3D, Quaternion, SphereGeometry, Sprite, SpriteMaterial,
  Vector3,
} from 'three';
import type { Batch } from './batch';

export const RED = 0xe5484d, AMBER = 0xe8a33d;

export function disposeOf(object: Object3D): void {
  object.removeFromParent();
  object.traverse(child => {
    const { geometry, material } = child as Mesh;
    geometry?.dispose();
    for (const one of Array.isArray(material) ? material : material ? [material] : []) (one as Material).dispose();
  });
}

/** Draws the repairs of the whole mesh: the faces with which the server closed it (in the cut material), and the edges around them,
 * which were open. Lines show through the mesh, so that a hole at the back is visible too. */
export function repairsOf(whole: Answer): Group {
  const group = new Group(), edges: number[] = [], fills: number[] = [];
  for (const { primitives, positions, translation: [x, y, z] } of whole.fragments) {
    const key = (v: number) => `${positions[3 * v]},${positions[3 * v + 1]},${positions[3 * v + 2]}`;
    const at = (v: number) => [positions[3 * v]! + x, positions[3 * v + 1]! + y, positions[3 * v + 2]! + z];
    const once = new Map<string, [number, number]>();
    for (const { interior, triangles } of primitives) {
      if (!interior) continue;
      for (let t = 0; t < triangles.length; t += 3)
        for (let k = 0; k < 3; ++k) {
          const a = triangles[t + k]!, b = triangles[t + (k + 1) % 3]!, back = `${key(b)} ${key(a)}`;
          fills.push(...at(a));
          if (!once.delete(back)) once.set(`${key(a)} ${key(b)}`, [a, b]);
        }
    }
    for (const [a, b] of once.values()) edges.push(...at(a), ...at(b));
  }
  if (fills.length > 0) {
    const geometry = new BufferGeometry().setAttribute('position', new BufferAttribute(new Float32Array(fills), 3));
    const material = new MeshBasicMaterial({
      color: AMBER, side: DoubleSide, transparent: true, opacity: 0.75, polygonOffset: true, polygonOffsetFactor: -2, polygonOffsetUnits: -2,
    });
    group.add(new Mesh(geometry, material));
  }
  if (edges.length > 0) {
    const geometry = new BufferGeometry().setAttribute('position', new BufferAttribute(new Float32Array(edges), 3));
    const seen = new LineSegments(geometry, new LineBasicMaterial({ color: RED, depthTest: false, transparent: true }));
    seen.renderOrder = 10;
    group.add(seen);
  }
  return group;
}

/** Draws dots at points, large enough to be visible. */
export function markers(points: readonly (readonly number[])[], radius: number, color: number): Group {
  const group = new Group();
  for (const [x = 0, y = 0, z = 0] of points) {
    const dot = new Mesh(new SphereGeometry(radius, 16, 12), new MeshBasicMaterial({ color, depthTest: false, transparent: true, opacity: 0.9 }));
    dot.position.set(x, y, z);
    dot.renderOrder = 11;
    group.add(dot);
  }
  return group;
}

/** Bonds as bars between the centres of fragments, thicker for a larger area. They follow the poses. */
export class BondGraph {
  readonly group = new Group();
  private readonly bars: InstancedMesh;
  private readonly ends: { a: number; b: number; thick: number }[];
  private readonly middles: Vector3[];

  constructor(private readonly batch: Batch, size: number) {
    const { answer } = batch, most = answer.bonds.reduce((sum, { area }) => Math.max(sum, area), 0) || 1;
    this.ends = answer.bonds.map(({ a, b, area }) =>
      ({ a: batch.indexOf.get(a)!, b: batch.indexOf.get(b)!, thick: size * (0.0012 + 0.006 * Math.sqrt(area / most)) }));
    this.middles = answer.fragments.map(({ centerOfMass: [x, y, z], translation }) => new Vector3(x - translation[0], y - translation[1], z - translation[2]));
    this.bars = new InstancedMesh(new CylinderGeometry(1, 1, 1, 5, 1, true), new MeshBasicMaterial({ depthTest: false, transparent: true, opacity: 0.85 }),
      Math.max(1, this.ends.length));
    this.bars.count = this.ends.length;
    this.bars.renderOrder = 5;
    this.bars.frustumCulled = false;
    const strongest = answer.bonds.reduce((sum, { strength }) => Math.max(sum, strength), 0) || 1, weak = new Color(AMBER), strong = new Color(0x5aa2ff);
    answer.bonds.forEach(({ strength }, k) => this.bars.setColorAt(k, weak.clone().lerp(strong, Math.sqrt(strength / strongest))));
    this.group.add(this.bars);
    this.update();
  }

  update(): void {
    const matrix = new Matrix4(), from = new Vector3(), to = new Vector3(), turn = new Quaternion(), up = new Vector3(0, 1, 0), scale = new Vector3();
    const middle = (k: number, into: Vector3) => {
      const { at, turn: [x, y, z, w] } = this.batch.poses.get(k);
      return into.copy(this.middles[k]!).applyQuaternion(turn.set(x, y, z, w)).add(scale.set(...at));
    };
    this.ends.forEach(({ a, b, thick }, k) => {
      middle(a, from);
      middle(b, to);
      const length = from.distanceTo(to);
      turn.setFromUnitVectors(up, to.clone().sub(from).divideScalar(length || 1));
      const drawn = this.batch.poses.visible(a) && this.batch.poses.visible(b) ? thick : 0;
      matrix.compose(from.add(to).multiplyScalar(0.5), turn, scale.set(drawn, drawn && length, drawn));
      this.bars.setMatrixAt(k, matrix);
    });
    this.bars.instanceMatrix.needsUpdate = true;
  }
}

/** Returns the sphere that shows a hit's reach, at the pointer or at an existing hit. */
export function hitSphere(color: Color): Mesh {
  const sphere = new Mesh(new SphereGeometry(1, 32, 20), new MeshBasicMaterial({ color, transparent: true, opacity: 0.16, depthWrite: false }));
  const core = new Mesh(new SphereGeometry(0.06, 12, 8), new MeshBasicMaterial({ color, depthTest: false, transparent: true }));
  core.renderOrder = 12;
  sphere.add(core);
  sphere.visible = false;
  return sphere;
}

let circle: CanvasTexture | undefined;
/** Returns a marker of constant size on the screen, drawn in front of everything. */
export function ring(at: Vector3, color: Color): Sprite {
  if (!circle) {
    const canvas = document.createElement('canvas'), context = canvas.getContext('2d')!;
    canvas.width = canvas.height = 64;
    context.lineWidth = 5;
    context.strokeStyle = '#fff';
    context.arc(32, 32, 27, 0, 2 * Math.PI);
    context.stroke();
    circle = new CanvasTexture(canvas);
  }
  const sprite = new Sprite(new SpriteMaterial({ map: circle, color, depthTest: false, sizeAttenuation: false }));
  sprite.position.copy(at);
  sprite.scale.setScalar(0.055);
  sprite.renderOrder = 20;
  return sprite;
}

/** Draws a person, 1.75 metres tall. */
export function person(): Group {
  const group = new Group(), material = new MeshStandardMaterial({ color: 0x8a93a0, roughness: 1, transparent: true, opacity: 0.5 });
  const part = (radius: number, length: number, x: number, y: number, lean = 0) => {
    const mesh = new Mesh(new CapsuleGeometry(radius, length, 6, 12), material);
    mesh.position.set(x, y, 0);
    mesh.rotation.z = lean;
    group.add(mesh);
  };
  part(0.11, 0.04, 0, 1.62);
  part(0.17, 0.36, 0, 1.2);
  part(0.075, 0.7, -0.095, 0.44);
  part(0.075, 0.7, 0.095, 0.44);
  part(0.05, 0.56, -0.25, 1.1, -0.12);
  part(0.05, 0.56, 0.25, 1.1, 0.12);
  return group;
}
