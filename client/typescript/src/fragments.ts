// What an answer holds, read from its GLB: figures, fragments, bonds. Lengths are metres, y is up.
import { type Glb, type GltfNode, type GltfPrimitive, type TypedArray, type Vector3 } from './glb.js';
import { localError } from './problems.js';

/** Columns of equal length; fragments by their ids. */
export interface BondColumns {
  a: number[];
  b: number[];
  /** m² */
  area: number[];
  centroid: Vector3[];
  /** Unit, from a to b. */
  normal: Vector3[];
  /** Newtons of pull that it withstands. */
  strength: number[];
}

/** The object under extras.fracture of the root node, and what comes with Accept: application/json. */
export interface Figures {
  version: number;
  algorithm: number;
  /** The content key of the mesh. */
  mesh: string;
  parameters: Record<string, any>;
  report: { warnings: string[]; [figure: string]: any };
  certificate: {
    fragments: number; volume_in: number; volume_out: number; open_edges: number; unmirrored_caps: number; [figure: string]: any;
  };
  bonds: BondColumns;
  /** Materials of cut faces, by their index in the file. */
  interior_materials: number[];
  /** Ids of the fragments that the last hits made, changed and took away; where `delta` was asked for. */
  delta?: { new: number[]; changed: number[]; gone: number[] };
  /** Of a hierarchy, the coarsest first. */
  levels?: Record<string, any>[];
  [figure: string]: any;
}

/** What two fragments share. */
export interface Bond {
  a: number;
  b: number;
  area: number;
  centroid: Vector3;
  normal: Vector3;
  strength: number;
}

/** A closed convex body around a fragment, or a part of one; in the frame of the fragment's node. */
export interface Hull {
  /** x, y, z of each point. */
  positions: Float32Array;
  /** Three points for each triangle. */
  triangles: Uint16Array | Uint32Array;
}

/** Triangles of one material. */
export interface Primitive {
  /** Index of the file's material. */
  material: number | undefined;
  /** Cut faces. */
  interior: boolean;
  /** By glTF's names: POSITION, NORMAL, TEXCOORD_0, … Shared by the primitives of a fragment. */
  attributes: Record<string, TypedArray>;
  triangles: Uint16Array | Uint32Array;
}

/** Of a rigid body: kilograms, metres, kg·m². In the frame of the fragment's node, which is not turned. */
export interface Motion {
  mass: number;
  centerOfMass: Vector3;
  inertiaDiagonal: Vector3;
  /** The turn from the principal axes into the node's frame: x, y, z, w. */
  inertiaOrientation: [number, number, number, number];
}

const KHR = 'KHR_physics_rigid_bodies', OMI = 'OMI_physics_body';

/** Something that is drawn: a fragment, or a node that passed through whole. */
export class Piece {
  private readPrimitives: Primitive[] | undefined;
  private readTriangles: Uint16Array | Uint32Array | undefined;

  constructor(protected readonly glb: Glb, /** Index in the file. */ readonly node: number,
              protected readonly interior: readonly number[]) {}

  protected get source(): GltfNode {
    return this.glb.json.nodes![this.node]!;
  }
  get name(): string {
    return this.source.name ?? '';
  }
  /** Where the node's origin is, in the frame of the mesh: world position = translation + position. */
  get translation(): Vector3 {
    return this.source.translation ?? [0, 0, 0];
  }
  get primitives(): readonly Primitive[] {
    return (this.readPrimitives ??= this.rawPrimitives.map(primitive => ({
      material: primitive.material,
      interior: primitive.material !== undefined && this.interior.includes(primitive.material),
      attributes: Object.fromEntries(Object.entries(primitive.attributes).map(([name, accessor]) => [name, this.glb.accessor(accessor)])),
      triangles: indicesOf(this.glb, primitive),
    })));
  }
  /** x, y, z of each vertex, from the node's origin. */
  get positions(): Float32Array {
    return (this.primitives[0]?.attributes['POSITION'] ?? new Float32Array()) as Float32Array;
  }
  get normals(): Float32Array | undefined {
    return this.primitives[0]?.attributes['NORMAL'] as Float32Array | undefined;
  }
  get uvs(): Float32Array | undefined {
    return this.primitives[0]?.attributes['TEXCOORD_0'] as Float32Array | undefined;
  }
  /** Three vertices for each triangle, of all materials one after the other. */
  get triangles(): Uint16Array | Uint32Array {
    return (this.readTriangles ??= joined(this.primitives.map(primitive => primitive.triangles)));
  }
  /** The accessors behind the primitives, for who shares buffers. */
  get rawPrimitives(): readonly GltfPrimitive[] {
    return this.glb.json.meshes?.[this.source.mesh ?? -1]?.primitives ?? [];
  }
}

export class Fragment extends Piece {
  private readHulls: Hull[] | undefined;

  private get figures(): Record<string, any> {
    return this.source.extras!['fracture'];
  }
  /** What names it in bonds, deltas and parameters; the same in every answer that has it. */
  get id(): number {
    return this.figures['id'];
  }
  /** m³ */
  get volume(): number {
    return this.figures['volume'];
  }
  /** kg */
  get mass(): number {
    return this.figures['mass'];
  }
  /** m² of all faces, and of those that are the outside of the mesh. */
  get area(): number {
    return this.figures['area'];
  }
  get exteriorArea(): number {
    return this.figures['exterior_area'];
  }
  /** In the frame of the mesh. */
  get centerOfMass(): Vector3 {
    return this.figures['center_of_mass'];
  }
  /** It is held in its place. */
  get anchored(): boolean {
    return this.figures['anchored'];
  }
  /** Which connected part of the mesh it is of. */
  get part(): number {
    return this.figures['part'];
  }
  get level(): number {
    return this.figures['level'];
  }
  /** The id of its cluster, where there are levels. */
  get parent(): number | null {
    return this.figures['parent'];
  }
  get sites(): readonly number[] {
    return this.figures['sites'];
  }
  /** With physics=khr; with omi without inertia. */
  get motion(): Motion | undefined {
    return this.body?.['motion'];
  }
  /** Fragments with the same number overlap from the start, and must not be held apart. */
  get collisionSystem(): number | undefined {
    return this.colliders.find(collider => collider['collisionFilter'] !== undefined)?.['collisionFilter'];
  }
  /** How it rubs and bounces; with physics=khr. */
  get surface(): { friction: number; restitution: number } {
    const number = this.colliders[0]?.['physicsMaterial'] as number | undefined;
    const material = this.glb.json.extensions?.[KHR]?.physicsMaterials?.[number ?? -1] ?? {};
    return { friction: material.dynamicFriction ?? 0.6, restitution: material.restitution ?? 0 };
  }
  /** None with physics=none. */
  get hulls(): readonly Hull[] {
    return (this.readHulls ??= this.colliders.flatMap(collider => {
      const shape = collider['shape'] as number | undefined;
      const mesh = collider['geometry']?.mesh ?? this.glb.json.extensions?.['OMI_physics_shape']?.shapes[shape ?? -1]?.convex?.mesh;
      return (this.glb.json.meshes?.[mesh]?.primitives ?? []).map(primitive => ({
        positions: this.glb.accessor(primitive.attributes['POSITION']!) as Float32Array, triangles: indicesOf(this.glb, primitive),
      }));
    }));
  }

  private get body(): Record<string, any> | undefined {
    return this.source.extensions?.[KHR] ?? this.source.extensions?.[OMI];
  }
  /** One on the node itself, several on its children. */
  private get colliders(): Record<string, any>[] {
    const nodes = [this.source, ...(this.source.children ?? []).map(child => this.glb.json.nodes![child]!)];
    return nodes.flatMap(node => {
      const collider = (node.extensions?.[KHR] ?? node.extensions?.[OMI])?.collider;
      return collider ? [collider] : [];
    });
  }
}

function indicesOf(glb: Glb, primitive: GltfPrimitive): Uint16Array | Uint32Array {
  if (primitive.indices !== undefined) return glb.accessor(primitive.indices) as Uint16Array | Uint32Array;
  return Uint32Array.from({ length: glb.accessorAt(primitive.attributes['POSITION']!).count }, (_, k) => k);
}

/** One view over arrays that stand behind one another, as the service writes them; else a copy. */
function joined(parts: (Uint16Array | Uint32Array)[]): Uint16Array | Uint32Array {
  const [first] = parts;
  if (!first) return new Uint16Array();
  let end = first.byteOffset;
  const adjacent = parts.every(part => {
    const here = part.buffer === first.buffer && part.byteOffset === end && part.BYTES_PER_ELEMENT === first.BYTES_PER_ELEMENT;
    end += part.byteLength;
    return here;
  });
  const Type = first.constructor as Uint16ArrayConstructor;
  if (adjacent) return new Type(first.buffer as ArrayBuffer, first.byteOffset, (end - first.byteOffset) / first.BYTES_PER_ELEMENT);
  return Uint32Array.from(parts.flatMap(part => [...part]));
}

/** Throws FractureError (damaged-answer) for a file that is not from the service. */
export function figuresOf(glb: Glb): Figures {
  const { nodes, scenes, scene } = glb.json, root = nodes?.[scenes?.[scene ?? 0]?.nodes?.[0] ?? 0];
  const figures = root?.extras?.['fracture'] as Figures | undefined;
  if (!figures?.parameters || !figures.certificate || !figures.bonds)
    throw localError('damaged-answer', 'This GLB has no extras.fracture on its root: it is no answer of the service.');
  return figures;
}

export function fragmentsOf(glb: Glb, figures: Figures): Fragment[] {
  return (glb.json.nodes ?? []).flatMap((node, k) =>
    (node.extras?.['fracture']?.id === undefined ? [] : [new Fragment(glb, k, figures.interior_materials)]));
}

/** Nodes of the mesh that were not to be fractured (`nodes`, `materials`). */
export function passedThrough(glb: Glb, figures: Figures): Piece[] {
  const nodes = glb.json.nodes ?? [], root = nodes[glb.json.scenes?.[glb.json.scene ?? 0]?.nodes?.[0] ?? 0];
  return (root?.children ?? []).filter(k => nodes[k]!.mesh !== undefined && !nodes[k]!.extras?.['fracture'])
    .map(k => new Piece(glb, k, figures.interior_materials));
}

export function bondsOf({ bonds: { a, b, area, centroid, normal, strength } }: Figures): Bond[] {
  return a.map((id, k) => ({ a: id, b: b[k]!, area: area[k]!, centroid: centroid[k]!, normal: normal[k]!, strength: strength[k]! }));
}
