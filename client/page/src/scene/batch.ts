// An answer as it is drawn: one geometry for all fragments, and one mesh per material. Vertices are in their fragment's frame;
// Poses contains the fragment's position.
import type { Answer, Fragment, Piece } from 'fracture-client';
import { BufferAttribute, BufferGeometry, Group, type Material, Mesh, MeshDepthMaterial, MeshStandardMaterial, Sphere, Vector3 } from 'three';
import { normalsOf } from './normals';
import { plain } from './plain';
import { Poses } from './poses';

const NAMES: Record<string, [string, number]> = {
  POSITION: ['position', 3], NORMAL: ['normal', 3], TANGENT: ['tangent', 4], COLOR_0: ['color', 4],
  TEXCOORD_0: ['uv', 2], TEXCOORD_1: ['uv1', 2],
};

/** The triangles of one fragment and material: a range of the index. */
export interface Range {
  start: number;
  count: number;
  interior: boolean;
}

export interface DrawnPiece {
  /** The fragment's id; undefined for a node that was passed through uncut. */
  id: number | undefined;
  origin: [number, number, number];
  bounds: Sphere;
  ranges: Range[];
  triangles: number;
}

/** The material for surfaces without one. glTF's default material would look like a mirror; clay shows more. */
const CLAY = { color: 0xb9b4ab, roughness: 0.8, metalness: 0 };

export class Batch {
  readonly group = new Group();
  readonly pieces: DrawnPiece[] = [];
  readonly poses: Poses;
  readonly positions: Float32Array;
  readonly index: Uint32Array;
  readonly indexOf = new Map<number, number>();
  readonly exterior: Mesh[] = [];
  readonly interior: Mesh[] = [];
  private readonly geometries: BufferGeometry[] = [];
  private readonly own: Material[] = [];

  /** Builds the meshes. `materials` are shared by all answers of a mesh, so this class does not dispose of them. */
  constructor(readonly answer: Answer, materials: readonly Material[], software: boolean) {
    const drawn: readonly Piece[] = [...answer.fragments, ...answer.passedThrough];
    this.poses = new Poses(drawn.length);
    // Each piece, and the sheets that it carries; both have the number of the piece.
    const surfaces = drawn.flatMap((piece, owner) => {
      const sheet = (piece as Partial<Fragment>).sheet;
      return sheet ? [{ piece, owner }, { piece: sheet, owner }] : [{ piece, owner }];
    });
    const vertices = surfaces.reduce((sum, { piece }) => sum + piece.positions.length / 3, 0);
    const indices = surfaces.reduce((sum, { piece }) => sum + piece.primitives.reduce((all, { triangles }) => all + triangles.length, 0), 0);
    const present = new Set(surfaces.flatMap(({ piece }) => Object.keys(piece.primitives[0]?.attributes ?? {})));
    const arrays = new Map(Object.entries(NAMES).filter(([name]) => present.has(name))
      .map(([name, [, width]]) => [name, new Float32Array(vertices * width).fill(name === 'COLOR_0' ? 1 : 0)]));
    this.positions = arrays.get('POSITION') ?? new Float32Array();
    const owner = new Float32Array(vertices), withoutNormals = !present.has('NORMAL');
    this.index = new Uint32Array(indices);

    // Index ranges are grouped by material, so that each material is one draw call.
    const byMaterial = new Map<number, { piece: number; first: number; triangles: ArrayLike<number>; interior: boolean }[]>();
    let first = 0;
    surfaces.forEach(({ piece, owner: k }) => {
      const count = piece.positions.length / 3, { primitives } = piece;
      for (const [name, values] of Object.entries(primitives[0]?.attributes ?? {})) put(arrays.get(name), NAMES[name]?.[1], values, first, count);
      if (!withoutNormals && !primitives[0]?.attributes['NORMAL']) arrays.get('NORMAL')!.set(normalsOf(piece.positions, piece.triangles), 3 * first);
      owner.fill(k, first, first + count);
      for (const { material = -1, triangles, interior } of primitives) {
        const list = byMaterial.get(material) ?? [];
        list.push({ piece: k, first, triangles, interior });
        byMaterial.set(material, list);
      }
      first += count;
      if (this.pieces.length > k) return;  // its sheets
      const id = 'id' in piece ? piece.id as number : undefined;
      if (id !== undefined) this.indexOf.set(id, k);
      this.pieces.push({ id, origin: [...piece.translation], bounds: sphereOf(piece.positions), ranges: [], triangles: 0 });
      this.poses.place(k, ...piece.translation);
    });

    const attributes = new Map([...arrays].map(([name, array]) => [NAMES[name]![0], new BufferAttribute(array, NAMES[name]![1])]));
    attributes.set('piece', new BufferAttribute(owner, 1));
    const whole = new BufferAttribute(this.index, 1), depth = this.poses.apply(new MeshDepthMaterial());
    this.own.push(depth);
    let at = 0, clay: Material | undefined;
    for (const [number, list] of byMaterial) {
      const start = at, interior = list[0]!.interior;
      for (const { piece, first: vertex, triangles } of list) {
        const drawnPiece = this.pieces[piece]!;
        drawnPiece.ranges.push({ start: at, count: triangles.length, interior });
        drawnPiece.triangles += triangles.length / 3;
        for (let k = 0; k < triangles.length; ++k) this.index[at + k] = triangles[k]! + vertex;
        at += triangles.length;
      }
      const geometry = new BufferGeometry();
      for (const [name, attribute] of attributes) geometry.setAttribute(name, attribute);
      geometry.setIndex(whole).setDrawRange(start, at - start);
      geometry.boundingSphere = new Sphere(new Vector3(), Infinity);
      let material = materials[number];
      if (!material) {
        clay ??= new MeshStandardMaterial({ ...CLAY, flatShading: withoutNormals, vertexColors: present.has('COLOR_0') });
        this.own.push(material = software ? plain(clay) : clay);
      }
      const mesh = new Mesh(geometry, this.poses.apply(material));
      mesh.frustumCulled = false;
      mesh.castShadow = !material.transparent;
      mesh.receiveShadow = !material.transparent;
      mesh.customDepthMaterial = depth;
      // The outside comes first, so that the cuts it hides are not shaded.
      mesh.renderOrder = material.transparent ? 1 : interior ? 0.5 : 0;
      (interior ? this.interior : this.exterior).push(mesh);
      this.geometries.push(geometry);
      this.group.add(mesh);
    }
  }

  /** Returns a box around all assembled pieces. */
  bounds(): { min: Vector3; max: Vector3 } {
    const min = new Vector3(Infinity, Infinity, Infinity), max = min.clone().negate();
    this.pieces.forEach(({ origin: [x, y, z], ranges }) => {
      for (const { start, count } of ranges)
        for (let k = start; k < start + count; ++k) {
          const v = 3 * this.index[k]!, at = new Vector3(x + this.positions[v]!, y + this.positions[v + 1]!, z + this.positions[v + 2]!);
          min.min(at);
          max.max(at);
        }
    });
    return { min, max };
  }

  dispose(): void {
    for (const geometry of this.geometries) geometry.dispose();
    for (const material of this.own) material.dispose();
    this.poses.dispose();
    this.group.removeFromParent();
  }
}

function put(into: Float32Array | undefined, width: number | undefined, values: ArrayLike<number>, first: number, count: number): void {
  if (!into || !width) return;
  const own = values.length / count;  // colours have three or four components
  if (own === width) into.set(values as Float32Array, width * first);
  else for (let k = 0; k < count; ++k) for (let c = 0; c < Math.min(own, width); ++c) into[width * (first + k) + c] = values[own * k + c]!;
}

function sphereOf(positions: Float32Array): Sphere {
  const sphere = new Sphere(), at = new Vector3();
  const min = new Vector3(Infinity, Infinity, Infinity), max = min.clone().negate();
  for (let k = 0; k < positions.length; k += 3) {
    at.fromArray(positions, k);
    min.min(at);
    max.max(at);
  }
  if (positions.length === 0) return sphere;
  sphere.center.addVectors(min, max).multiplyScalar(0.5);
  sphere.radius = sphere.center.distanceTo(max);
  return sphere;
}
