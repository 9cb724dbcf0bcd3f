// Copies meshes from several files into one buffer. Each attribute, each index width, and the merged vertices of EXT_mesh_manifold have
// their own bufferView, in order of first use. Images follow.
import { bytesPerComponent, type Glb, type Gltf, type GltfAccessor, type GltfMesh, widthOf } from './glb.js';

interface View {
  blocks: Uint8Array[];
  size: number;
  stride: number | undefined;
  target: number | undefined;
}

const aligned = (size: number) => Math.ceil(size / 4) * 4;

export class MeshCopier {
  private readonly views = new Map<string, View>();
  private readonly accessors: GltfAccessor[] = [];

  /** Copies a mesh. The result uses accessors of the new file. */
  copy(glb: Glb, mesh: GltfMesh): GltfMesh {
    // An accessor's use determines its view.
    const role = new Map<number, string>();
    for (const { attributes, indices } of mesh.primitives) {
      for (const [name, accessor] of Object.entries(attributes)) role.set(accessor, name);
      if (indices !== undefined) role.set(indices, `indices ${glb.accessorAt(indices).componentType}`);
    }
    const manifold = mesh.extensions?.['EXT_mesh_manifold'];
    if (manifold) {
      const { indices } = manifold.manifoldPrimitive;
      if (!role.has(indices)) role.set(indices, `indices ${glb.accessorAt(indices).componentType}`);
      for (const merged of [manifold.mergeIndices, manifold.mergeValues]) if (merged !== undefined) role.set(merged, 'merges');
    }
    const order = [...role.keys()].sort((a, b) => a - b);
    const number = new Map(order.map((accessor, k) => [accessor, this.accessors.length + k]));
    // All bytes of the mesh in one view are contiguous, and stay so.
    const spans = new Map<number, { from: number; to: number; role: string }>();
    const span = (view: number, at: number, size: number, name: string) => {
      const known = spans.get(view) ?? { from: at, to: at, role: name };
      spans.set(view, { from: Math.min(known.from, at), to: Math.max(known.to, at + size), role: known.role });
    };
    for (const index of order) {
      const accessor = glb.accessorAt(index), size = bytesPerComponent(accessor.componentType) * widthOf(accessor);
      if (accessor.bufferView !== undefined) span(accessor.bufferView, accessor.byteOffset ?? 0, accessor.count * size, role.get(index)!);
      if (!accessor.sparse) continue;
      const { count, indices, values } = accessor.sparse;
      span(indices.bufferView, indices.byteOffset ?? 0, count * bytesPerComponent(indices.componentType), 'merges');
      span(values.bufferView, values.byteOffset ?? 0, count * size, 'merges');
    }
    const moved = new Map<number, { view: number; by: number }>();
    for (const [view, { from, to, role: name }] of spans) moved.set(view, this.append(glb, view, from, to, name));
    const place = <Part extends { bufferView?: number; byteOffset?: number }>(part: Part, keepZero = false): Part => {
      if (part.bufferView === undefined) return part;
      const { view, by } = moved.get(part.bufferView)!, { byteOffset = 0, ...rest } = part;
      const at = byteOffset + by;
      return { ...rest, bufferView: view, ...(at > 0 || keepZero ? { byteOffset: at } : {}) } as Part;
    };
    for (const index of order) {
      const accessor = place(glb.accessorAt(index));
      const { sparse } = accessor;
      if (sparse) accessor.sparse = { ...sparse, indices: place(sparse.indices, true), values: place(sparse.values, true) };
      this.accessors.push(accessor);
    }
    const at = (accessor: number) => number.get(accessor)!;
    const copy: GltfMesh = {
      ...mesh,
      primitives: mesh.primitives.map(primitive => ({
        ...primitive, attributes: Object.fromEntries(Object.entries(primitive.attributes).map(([name, accessor]) => [name, at(accessor)])),
        ...(primitive.indices === undefined ? {} : { indices: at(primitive.indices) }),
      })),
    };
    if (manifold) {
      const { manifoldPrimitive: { attributes, indices, ...rest }, mergeIndices, mergeValues } = manifold;
      copy.extensions = { ...mesh.extensions, EXT_mesh_manifold: {
        ...manifold, manifoldPrimitive: { ...rest, attributes: { POSITION: at(attributes.POSITION) }, indices: at(indices) },
        ...(mergeIndices === undefined ? {} : { mergeIndices: at(mergeIndices), mergeValues: at(mergeValues) }),
      } };
    }
    return copy;
  }

  /** Writes the accessors, the bufferViews and the buffer length into `json`, copies the images of `glb`, and returns the buffer. */
  finish(glb: Glb, json: Gltf): Uint8Array {
    if (json.images) json.images = json.images.map((image, k) => {
      const bytes = glb.image(k)?.bytes;
      if (!bytes) return image;
      this.views.set(`image ${k}`, { blocks: [bytes], size: bytes.length, stride: undefined, target: undefined });
      return { ...image, bufferView: this.views.size - 1 };
    });
    const size = [...this.views.values()].reduce((sum, view) => sum + aligned(view.size), 0), binary = new Uint8Array(size);
    json.accessors = this.accessors;
    json.bufferViews = [];
    json.buffers = [{ byteLength: size }];
    let offset = 0;
    for (const { blocks, size: length, stride, target } of this.views.values()) {
      json.bufferViews.push({
        buffer: 0, ...(offset > 0 ? { byteOffset: offset } : {}), byteLength: length,
        ...(stride === undefined ? {} : { byteStride: stride }), ...(target === undefined ? {} : { target }),
      });
      let at = offset;
      for (const block of blocks) {
        at = aligned(at);
        binary.set(block, at);
        at += block.length;
      }
      offset += aligned(length);
    }
    return binary;
  }

  private append(glb: Glb, index: number, from: number, to: number, role: string): { view: number; by: number } {
    const { byteStride, target } = glb.json.bufferViews![index]!;
    let view = this.views.get(role);
    if (!view) this.views.set(role, (view = { blocks: [], size: 0, stride: byteStride, target }));
    const at = aligned(view.size);
    view.blocks.push(glb.view(index).subarray(from, to));
    view.size = at + to - from;
    return { view: [...this.views.keys()].indexOf(role), by: at - from };
  }
}
