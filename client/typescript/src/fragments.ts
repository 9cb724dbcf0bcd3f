// The content of an answer, read from its GLB: data, fragments and bonds. Lengths are in metres; y is up.
import { type Glb, type GltfNode, type GltfPrimitive, type TypedArray, type Vector3 } from './glb.js';
import type { CollisionFilter } from './filters.js';
import { uncutIndices } from './groups.js';
import { localError } from './problems.js';
import { turnOf, type Turn } from './turn.js';

/** The bonds as columns of equal length. */
export interface BondColumns {
  /** Ids of the two fragments. */
  a: number[];
  b: number[];
  /** m² */
  area: number[];
  /** m, in the frame of the root node (see Answer.offset). */
  centroid: Vector3[];
  /** From a to b, unit length. */
  normal: Vector3[];
  /** N: the tension at which the bond breaks. */
  strength: number[];
}

/** Overlaps of collision hulls. */
export interface Rest {
  /** Pairs of fragments that overlap by more than the tolerance. */
  pairs: number;
  /** Fragments with a trimmed hull. */
  trimmed: number;
  /** Pairs that collision filters exclude. */
  filtered: number;
  /** Pairs that overlap and may collide; 0 with physics=khr. */
  left: number;
  /** m: deepest overlap of two fragments that may collide. */
  deepest: number;
  /** m */
  tolerance: number;
  /** The smallest fraction of its volume that any trimmed hull kept. */
  least_share: number;
  /** Collision systems, at most 32. */
  systems: number;
}

/** Something in the source that the answer does not contain. */
export interface Dropped {
  /** The kind: light, camera, animation, extension, … */
  what: string;
  /** The name or the place in the source; may be empty. The last entry of a long list has a reason such as `12 more are not listed`. */
  name: string;
  reason: string;
}

/** The object under extras.fracture of the root node. With Accept: application/json, the server sends only this object. */
export interface Figures {
  version: number;
  algorithm: number;
  /** The digest of the mesh. */
  mesh: string;
  parameters: Record<string, any>;
  report: { warnings: string[]; notes?: string[]; dropped?: Dropped[]; [figure: string]: any };
  certificate: {
    fragments: number; volume_in: number; volume_out: number; open_edges: number; unmirrored_caps: number;
    /** The overlaps of the collision hulls when the bodies start; null without collision hulls. */
    rest?: Rest | null;
    [figure: string]: any;
  };
  bonds: BondColumns;
  /** Bonds between fragments (ids in `a`) and nodes that were left uncut (their extras.whole.node in `node`). The normal points to the
   * node. */
  whole_bonds?: Omit<BondColumns, 'b'> & { node: number[] };
  /** Pairs of fragments that overlap, by id. Collision filters exclude them. In a delta: only pairs with a new or changed fragment. */
  filtered?: { a: number[]; b: number[] };
  /** Indices of the materials of cut faces. */
  interior_materials: number[];
  /** Ids of the fragments that the last hits created, changed and removed. Present only if the request set `delta`. */
  delta?: { new: number[]; changed: number[]; gone: number[] };
  /** The levels of the hierarchy, coarsest first. */
  levels?: Record<string, any>[];
  [figure: string]: any;
}

/** Two fragments that are held together by shared cut faces, by contacts between their parts, or by both. */
export interface Bond {
  /** Ids of the two fragments. */
  a: number;
  b: number;
  /** m² */
  area: number;
  /** m, in the frame of the root node (see Answer.offset). */
  centroid: Vector3;
  /** From a to b, unit length. */
  normal: Vector3;
  /** N: the tension at which the bond breaks. */
  strength: number;
}

/** A closed convex body around a fragment or part of it, in metres, relative to the fragment's `translation`. */
export interface Hull {
  /** x, y, z of each point. */
  positions: Float32Array;
  /** Indices of the points, three per triangle. */
  triangles: Uint16Array | Uint32Array;
}

/** The triangles of a fragment that share a material. */
export interface Primitive {
  /** Index of the material in the file. */
  material: number | undefined;
  /** True for cut faces. */
  interior: boolean;
  /** Arrays by their glTF names: POSITION, NORMAL, TEXCOORD_0, … All primitives of a fragment share them. */
  attributes: Record<string, TypedArray>;
  /** Indices of the vertices, three for each triangle. */
  triangles: Uint16Array | Uint32Array;
}

/** The motion properties of a rigid body. Positions are relative to the fragment's `translation`; directions use the mesh's axes. */
export interface Motion {
  /** kg */
  mass: number;
  /** m */
  centerOfMass: Vector3;
  /** kg·m², about the centre of mass. */
  inertiaDiagonal: Vector3;
  /** The rotation from the principal axes to the mesh's axes: x, y, z, w. */
  inertiaOrientation: [number, number, number, number];
}

const KHR = 'KHR_physics_rigid_bodies', OMI = 'OMI_physics_body';

/**
 * A drawable part of the answer: a fragment, or a mesh node that was left uncut. With instances=keep, the node of an unbroken instance
 * rotates and scales a mesh that other nodes share. The vertices, hulls and motion here are already rotated and scaled.
 */
export class Piece {
  private readPrimitives: Primitive[] | undefined;
  private readTriangles: Uint16Array | Uint32Array | undefined;
  private readTurn: [Turn | undefined] | undefined;

  constructor(protected readonly glb: Glb, /** Index of its node in the file. */ readonly node: number,
              protected readonly interior: readonly number[]) {}

  protected get source(): GltfNode {
    return this.glb.json.nodes![this.node]!;
  }
  get name(): string {
    return this.source.name ?? '';
  }
  /** The node's origin in the frame of the root node (m). A vertex is at translation + position. */
  get translation(): Vector3 {
    return this.source.translation ?? [0, 0, 0];
  }
  /** The rotation and scale of an unbroken instance's node; undefined for all others. They are not applied to rawPrimitives. */
  get turn(): Turn | undefined {
    return (this.readTurn ??= [turnOf(this.source)])[0];
  }
  get primitives(): readonly Primitive[] {
    if (this.readPrimitives) return this.readPrimitives;
    const turned = new Map<number, TypedArray>();  // primitives share accessors
    const read = (name: string, accessor: number): TypedArray => {
      const turn = this.turn, raw = this.glb.accessor(accessor);
      if (!turn) return raw;
      if (!turned.has(accessor)) turned.set(accessor, turn.attribute(name, raw));
      return turned.get(accessor)!;
    };
    return (this.readPrimitives = this.rawPrimitives.map(primitive => ({
      material: primitive.material,
      interior: primitive.material !== undefined && this.interior.includes(primitive.material),
      attributes: Object.fromEntries(Object.entries(primitive.attributes).map(([name, accessor]) => [name, read(name, accessor)])),
      triangles: indicesOf(this.glb, primitive),
    })));
  }
  /** x, y, z of each vertex (m), relative to the node's origin. */
  get positions(): Float32Array {
    return (this.primitives[0]?.attributes['POSITION'] ?? new Float32Array()) as Float32Array;
  }
  get normals(): Float32Array | undefined {
    return this.primitives[0]?.attributes['NORMAL'] as Float32Array | undefined;
  }
  get uvs(): Float32Array | undefined {
    return this.primitives[0]?.attributes['TEXCOORD_0'] as Float32Array | undefined;
  }
  /** Indices of the vertices, three per triangle, grouped by material. */
  get triangles(): Uint16Array | Uint32Array {
    return (this.readTriangles ??= joined(this.primitives.map(primitive => primitive.triangles)));
  }
  /** The file's primitives, with the indices of their accessors, for code that shares buffers. */
  get rawPrimitives(): readonly GltfPrimitive[] {
    return this.glb.json.meshes?.[this.source.mesh ?? -1]?.primitives ?? [];
  }
}

export class Fragment extends Piece {
  private readHulls: Hull[] | undefined;

  private get figures(): Record<string, any> {
    return this.source.extras!['fracture'];
  }
  /** The fragment's id in bonds, deltas and parameters. Every answer that contains this fragment uses the same id. */
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
  /** m², of all faces. */
  get area(): number {
    return this.figures['area'];
  }
  /** m², of the faces that belonged to the mesh's surface. */
  get exteriorArea(): number {
    return this.figures['exterior_area'];
  }
  /** m, in the frame of the root node (see Answer.offset). */
  get centerOfMass(): Vector3 {
    return this.figures['center_of_mass'];
  }
  /** True if an anchor holds the fragment, so that it does not fall. */
  get anchored(): boolean {
    return this.figures['anchored'];
  }
  /** The number of the connected part of the mesh to which the fragment's first piece belongs. */
  get part(): number {
    return this.figures['part'];
  }
  /** The numbers of all parts of the mesh that the fragment has pieces of, ascending. */
  get parts(): readonly number[] {
    return this.figures['parts'] ?? [this.part];
  }
  /** The fragment's level in the hierarchy. 0 without a hierarchy. */
  get level(): number {
    return this.figures['level'];
  }
  /** The id of the fragment's cluster; null without levels. */
  get parent(): number | null {
    return this.figures['parent'];
  }
  /** The numbers of the cells that make up the fragment. */
  get sites(): readonly number[] {
    return this.figures['sites'];
  }
  /** Undefined with physics=none. With physics=omi, the motion has no inertia. */
  get motion(): Motion | undefined {
    const motion = this.body?.['motion'] as Motion | undefined;
    return motion && this.turn ? this.turn.motion(motion) : motion;
  }
  /** Keeps the fragment from colliding with fragments that it overlaps. Undefined if it collides with all fragments. A delta has the
   * systems of the whole answer after the hit. */
  get collisionFilter(): CollisionFilter | undefined {
    const number = this.colliders.find(collider => collider['collisionFilter'] !== undefined)?.['collisionFilter'] as number | undefined;
    const filter = this.glb.json.extensions?.[KHR]?.collisionFilters?.[number ?? -1];
    return filter && { system: Number(filter.collisionSystems[0]), excluded: (filter.notCollideWithSystems ?? []).map(Number) };
  }
  /** Friction and restitution of the surface. With physics=khr, they come from the file; otherwise they are 0.6 and 0. */
  get surface(): { friction: number; restitution: number } {
    const number = this.colliders[0]?.['physicsMaterial'] as number | undefined;
    const material = this.glb.json.extensions?.[KHR]?.physicsMaterials?.[number ?? -1] ?? {};
    return { friction: material.dynamicFriction ?? 0.6, restitution: material.restitution ?? 0 };
  }
  /** The collision hulls; empty with physics=none. */
  get hulls(): readonly Hull[] {
    return (this.readHulls ??= this.colliders.flatMap(collider => {
      const shape = collider['shape'] as number | undefined;
      const mesh = collider['geometry']?.mesh ?? this.glb.json.extensions?.['OMI_physics_shape']?.shapes[shape ?? -1]?.convex?.mesh;
      return (this.glb.json.meshes?.[mesh]?.primitives ?? []).map(primitive => ({
        positions: this.hullPoints(primitive.attributes['POSITION']!), triangles: indicesOf(this.glb, primitive),
      }));
    }));
  }

  /** The sheets that the fragment carries (panes, leaves, decals), in the frame of the fragment's node. Undefined for most fragments. */
  get sheet(): Piece | undefined {
    const node = sheetNodeOf(this.glb, this.source);
    return node === undefined ? undefined : new Piece(this.glb, node, this.interior);
  }

  private hullPoints(accessor: number): Float32Array {
    const raw = this.glb.accessor(accessor);
    return (this.turn ? this.turn.attribute('POSITION', raw) : raw) as Float32Array;
  }
  private get body(): Record<string, any> | undefined {
    return this.source.extensions?.[KHR] ?? this.source.extensions?.[OMI];
  }
  /** A single hull is on the node itself; several hulls are on its child nodes. */
  private get colliders(): Record<string, any>[] {
    const nodes = [this.source, ...(this.source.children ?? []).map(child => this.glb.json.nodes![child]!)];
    return nodes.flatMap(node => {
      const collider = (node.extensions?.[KHR] ?? node.extensions?.[OMI])?.collider;
      return collider ? [collider] : [];
    });
  }
}

/** Returns the index of the child node that contains a fragment's sheets. The other children are for physics. */
export function sheetNodeOf(glb: Glb, { children }: GltfNode): number | undefined {
  return children?.find(child => {
    const { mesh, name } = glb.json.nodes![child]!;
    return mesh !== undefined && !name?.startsWith('UCX_');
  });
}

function indicesOf(glb: Glb, primitive: GltfPrimitive): Uint16Array | Uint32Array {
  if (primitive.indices !== undefined) return glb.accessor(primitive.indices) as Uint16Array | Uint32Array;
  return Uint32Array.from({ length: glb.accessorAt(primitive.attributes['POSITION']!).count }, (_, k) => k);
}

/** Returns all indices as one array: a view if they are contiguous in memory, as in the server's files, otherwise a copy. */
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

/** Returns the root node: the first node of the default scene. */
export function rootOf(glb: Glb): GltfNode | undefined {
  const { nodes, scenes, scene } = glb.json;
  return nodes?.[scenes?.[scene ?? 0]?.nodes?.[0] ?? 0];
}

/** Returns the data of an answer. Throws FractureError (damaged-answer) for a file that is not from a fracture server. */
export function figuresOf(glb: Glb): Figures {
  const figures = rootOf(glb)?.extras?.['fracture'] as Figures | undefined;
  if (!figures?.parameters || !figures.certificate || !figures.bonds)
    throw localError('damaged-answer', 'The root node of this GLB has no extras.fracture, so the file is not from a fracture server.');
  return figures;
}

export function fragmentsOf(glb: Glb, figures: Figures): Fragment[] {
  return (glb.json.nodes ?? []).flatMap((node, k) =>
    (node.extras?.['fracture']?.id === undefined ? [] : [new Fragment(glb, k, figures.interior_materials)]));
}

/** Returns the mesh nodes that the parameter `nodes` or `materials` left uncut. */
export function passedThrough(glb: Glb, figures: Figures): Piece[] {
  return uncutIndices(glb).filter(k => glb.json.nodes![k]!.mesh !== undefined).map(k => new Piece(glb, k, figures.interior_materials));
}

export function bondsOf({ bonds: { a, b, area, centroid, normal, strength } }: Figures): Bond[] {
  return a.map((id, k) => ({ a: id, b: b[k]!, area: area[k]!, centroid: centroid[k]!, normal: normal[k]!, strength: strength[k]! }));
}
