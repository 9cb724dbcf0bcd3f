// GLB files that the page makes of an answer: single fragments alone, and fragments with the names that the user gave them.
import { type Glb, type Gltf, type GltfBufferView, type GltfMesh, type GltfNode, packGlb, type TypedArray } from 'fracture-client';

export type Names = ReadonlyMap<number, string>;

const idOf = (node: GltfNode): number | undefined => node.extras?.['fracture']?.id as number | undefined;

/** Returns the file with the user's names, by fragment id. Everything else stays as it is. */
export function renamed(source: Glb, names: Names): Uint8Array {
  const nodes = source.json.nodes ?? [];
  if (!nodes.some(node => names.has(idOf(node) ?? NaN))) return source.bytes;
  const json: Gltf = { ...source.json, nodes: nodes.map(node => named(node, names)) };
  return packGlb(json, source.binary);
}
function named(node: GltfNode, names: Names): GltfNode {
  const name = names.get(idOf(node) ?? NaN);
  return name === undefined ? node : { ...node, name };
}

/** Numbers the old indices that are used, in the order in which they are first used. */
class Renumbered {
  readonly used: number[] = [];
  private readonly at = new Map<number, number>();
  of = (old: number): number => {
    const known = this.at.get(old);
    if (known !== undefined) return known;
    this.at.set(old, this.used.length);
    return this.used.push(old) - 1;
  };
}

const ATTRIBUTES = 34962;

/** The buffer of the new file. Each view begins at a multiple of four bytes, and so does each element of a vertex attribute. */
class Buffer {
  readonly views: GltfBufferView[] = [];
  private readonly parts: Uint8Array[] = [];
  private size = 0;

  /** Returns the number of the new view. `count`: the number of elements, if these are the numbers of an accessor. */
  add(values: TypedArray, count = 1, target?: number): number {
    const own = new Uint8Array(values.buffer as ArrayBuffer, values.byteOffset, values.byteLength), element = own.length / Math.max(1, count), stride = 4 * Math.ceil(element / 4);
    const padded = target === ATTRIBUTES && stride !== element, bytes = padded ? new Uint8Array(stride * count) : own;
    if (padded) for (let k = 0; k < count; ++k) bytes.set(own.subarray(k * element, (k + 1) * element), k * stride);
    this.parts.push(bytes);
    const view = { buffer: 0, byteOffset: this.size, byteLength: bytes.length, ...(padded ? { byteStride: stride } : {}), ...(target === undefined ? {} : { target }) };
    this.size += 4 * Math.ceil(bytes.length / 4);
    return this.views.push(view) - 1;
  }
  bytes(): Uint8Array {
    const out = new Uint8Array(this.size);
    this.parts.forEach((part, k) => out.set(part, this.views[k]!.byteOffset));
    return out;
  }
}

const PHYSICS = 'KHR_physics_rigid_bodies';

/** Returns a file with only these fragments. They keep their positions, materials and collision hulls. The file has no bonds and no
 * certificate, because those describe all fragments. */
export function piecesAlone(source: Glb, ids: ReadonlySet<number>, names: Names): Uint8Array {
  const { json } = source, meshes = new Renumbered(), accessors = new Renumbered(), materials = new Renumbered();
  const textures = new Renumbered(), images = new Renumbered(), nodes: GltfNode[] = [];
  const chosen = (json.nodes ?? []).flatMap((node, k) => (ids.has(idOf(node) ?? NaN) ? [k] : []));

  const add = (old: number): number => {
    const { children, extensions, mesh, ...rest } = named(json.nodes![old]!, names), at = nodes.push({}) - 1, physics = extensions?.[PHYSICS];
    const { collider } = physics ?? {};
    const body = physics && (collider ? { ...physics, collider: { ...collider, geometry: { ...collider.geometry, mesh: meshes.of(collider.geometry.mesh) } } } : physics);
    nodes[at] = {
      ...rest, ...(mesh === undefined ? {} : { mesh: meshes.of(mesh) }), ...(children ? { children: children.map(add) } : {}),
      ...(body ? { extensions: { [PHYSICS]: body } } : {}),
    };
    return at;
  };
  const translation = json.nodes?.find(node => node.extras?.['fracture']?.certificate)?.translation;  // of meshes far from their origin
  const root = nodes.push({ name: 'Fracture', ...(translation ? { translation } : {}) }) - 1;
  nodes[root]!.children = chosen.map(add);

  const primitive = ({ attributes, indices, material, ...rest }: any): any => ({
    ...rest, ...(attributes ? { attributes: mapped(attributes, accessors.of) } : {}),
    ...(indices === undefined ? {} : { indices: accessors.of(indices) }), ...(material === undefined ? {} : { material: materials.of(material) }),
  });
  // EXT_mesh_manifold describes how primitives share buffers, which are separate here.
  const mesh = ({ primitives, extensions, ...rest }: GltfMesh): GltfMesh => ({ ...rest, primitives: primitives.map(primitive) });
  const buffer = new Buffer();
  const keptMeshes = drained(meshes, at => mesh(json.meshes![at]!));
  // The fragments of an answer share bufferViews, so the numbers of each accessor are copied.
  const keptAccessors = drained(accessors, at => {
    const { bufferView, byteOffset, sparse, ...rest } = json.accessors![at]!;
    return { ...rest, bufferView: buffer.add(source.accessor(at), rest.count, bufferView === undefined ? undefined : json.bufferViews![bufferView]!.target) };
  });
  const keptMaterials = drained(materials, at => withTextures(json.materials![at], textures.of));
  const keptTextures = drained(textures, at => withImages(json.textures![at], images.of));
  const keptImages = drained(images, at => {
    const { bufferView, ...rest } = json.images![at]!;
    return { ...rest, ...(bufferView === undefined ? {} : { bufferView: buffer.add(source.view(bufferView)) }) };
  });

  const binary = buffer.bytes();
  const { [PHYSICS]: physics } = json.extensions ?? {}, used = JSON.stringify([nodes, keptMeshes, keptMaterials, keptTextures]);
  const list = (name: string, entries: unknown[]) => (entries.length > 0 ? { [name]: entries } : {});
  return packGlb({
    asset: json.asset, scene: 0, scenes: [{ nodes: [root] }], nodes,
    ...list('extensionsUsed', (json.extensionsUsed ?? []).filter(name => used.includes(`"${name}"`))),
    ...(physics && used.includes(PHYSICS) ? { extensions: { [PHYSICS]: physics } } : {}),
    ...list('meshes', keptMeshes), ...list('accessors', keptAccessors), ...list('materials', keptMaterials), ...list('textures', keptTextures),
    ...list('images', keptImages), ...(keptTextures.length > 0 ? list('samplers', json.samplers ?? []) : {}), ...list('bufferViews', buffer.views), buffers: [{ byteLength: binary.length }],
  } as Gltf, binary);
}

/** Converts every used entry. Converting one may use further entries of other lists. */
function drained<T>(numbers: Renumbered, convert: (old: number) => T): T[] {
  const out: T[] = [];
  for (let k = 0; k < numbers.used.length; ++k) out.push(convert(numbers.used[k]!));
  return out;
}
const mapped = (values: Record<string, number>, to: (old: number) => number): Record<string, number> =>
  Object.fromEntries(Object.entries(values).map(([name, value]) => [name, to(value)]));

/** Renumbers the textures in a material: members such as baseColorTexture, also in extensions. */
function withTextures(value: any, to: (old: number) => number): any {
  if (typeof value !== 'object' || value === null) return value;
  if (Array.isArray(value)) return value.map(each => withTextures(each, to));
  return Object.fromEntries(Object.entries(value).map(([name, member]: [string, any]) =>
    [name, /texture$/i.test(name) && typeof member?.index === 'number' ? { ...member, index: to(member.index) } : withTextures(member, to)]));
}
/** Renumbers the images of a texture, also in extensions such as EXT_texture_webp. */
function withImages(value: any, to: (old: number) => number): any {
  if (typeof value !== 'object' || value === null) return value;
  return Object.fromEntries(Object.entries(value).map(([name, member]: [string, any]) => [name, name === 'source' && typeof member === 'number' ? to(member) : withImages(member, to)]));
}
