// Fragments as three.js meshes. They share the file's buffers: one per attribute and one for the indices. Nothing is copied, and 200
// fragments need 3 uploads to the graphics card instead of 600.
//
//   POSITION   | fragment 0 | fragment 1 | fragment 2 | …     an attribute with an offset for each fragment
//   indices16  | fragment 0 | fragment 1 | fragment 2 | …     one attribute, with groups for each fragment
import {
  Box3, BufferAttribute, BufferGeometry, InterleavedBuffer, InterleavedBufferAttribute, type Material, Mesh, Sphere, Vector3,
} from 'three';
import type { Answer } from '../answer.js';
import { Fragment, type Piece } from '../fragments.js';
import { bytesPerComponent, type Glb, widthOf } from '../glb.js';
import { localError } from '../problems.js';
import { defaultMaterial } from './materials.js';

const NAMES: Record<string, string> = {
  POSITION: 'position', NORMAL: 'normal', TANGENT: 'tangent', COLOR_0: 'color',
  TEXCOORD_0: 'uv', TEXCOORD_1: 'uv1', TEXCOORD_2: 'uv2', TEXCOORD_3: 'uv3',
};

/** A part of a shared buffer. */
class SharedAttribute extends InterleavedBufferAttribute {
  constructor(buffer: InterleavedBuffer, width: number, firstVertex: number, private readonly vertices: number) {
    super(buffer, width, firstVertex * width);
  }
  override get count(): number {
    return this.vertices;
  }
}

class SharedBuffers {
  private readonly buffers = new Map<number, InterleavedBuffer>();
  private readonly indices = new Map<number, BufferAttribute>();
  constructor(private readonly glb: Glb) {}

  attribute(index: number): SharedAttribute {
    const accessor = this.glb.accessorAt(index), width = widthOf(accessor), view = accessor.bufferView;
    if (view === undefined || accessor.componentType !== 5126 || accessor.sparse)
      throw localError('bad-argument', `Accessor ${index} is not a dense array of floats, as meshesOf() requires. Use an unchanged ` +
        'GLB from the server.', { parameter: 'answer' });
    let buffer = this.buffers.get(view);
    if (!buffer) {
      const bytes = this.glb.view(view);
      buffer = new InterleavedBuffer(new Float32Array(bytes.buffer as ArrayBuffer, bytes.byteOffset, bytes.byteLength >> 2), width);
      this.buffers.set(view, buffer);
    }
    return new SharedAttribute(buffer, width, (accessor.byteOffset ?? 0) / (4 * width), accessor.count);
  }

  /** Returns a view's indices, which all have the same width, and the range that belongs to this accessor. */
  index(index: number): { attribute: BufferAttribute; start: number; count: number } {
    const accessor = this.glb.accessorAt(index), size = bytesPerComponent(accessor.componentType), view = accessor.bufferView!;
    let attribute = this.indices.get(view);
    if (!attribute) {
      const bytes = this.glb.view(view), Type = size === 2 ? Uint16Array : Uint32Array;
      attribute = new BufferAttribute(new Type(bytes.buffer as ArrayBuffer, bytes.byteOffset, Math.floor(bytes.byteLength / size)), 1);
      this.indices.set(view, attribute);
    }
    return { attribute, start: (accessor.byteOffset ?? 0) / size, count: accessor.count };
  }
}

/** Returns one three.js mesh per fragment, at its position in the mesh's frame. `userData.fragment` is the fragment's id. If a
 * fragment carries sheets, its mesh has a child mesh that contains them and has the same id. The geometries share buffers: dispose of
 * all or none, and copy a geometry (toNonIndexed) before you edit it. `pieces`: the parts to return instead of all fragments, such as
 * answer.passedThrough. Throws FractureError (bad-argument) for a modified GLB. */
export function meshesOf(answer: Answer, materials: readonly Material[], pieces: readonly Piece[] = answer.fragments): Mesh[] {
  const buffers = new SharedBuffers(answer.document);
  const flat = new Map<Material, Material>();  // for surfaces without normals, because glTF shades their triangles flat
  let plain: Material | undefined;
  const materialOf = (index: number | undefined, normals: boolean): Material => {
    const material = materials[index ?? -1] ?? (plain ??= defaultMaterial());
    if (normals || !('flatShading' in material)) return material;
    if (!flat.has(material)) flat.set(material, Object.assign(material.clone(), { flatShading: true }));
    return flat.get(material)!;
  };
  const meshOf = (piece: Piece): Mesh => {
    const geometry = new BufferGeometry(), used: Material[] = [];
    let first = Infinity, end = 0;
    piece.rawPrimitives.forEach((primitive, k) => {
      if (k === 0)
        for (const [name, accessor] of Object.entries(primitive.attributes))
          if (NAMES[name]) geometry.setAttribute(NAMES[name], buffers.attribute(accessor));
      const { attribute, start, count } = buffers.index(primitive.indices!);
      geometry.setIndex(attribute);
      geometry.addGroup(start, count, used.length);
      used.push(materialOf(primitive.material, 'NORMAL' in primitive.attributes));
      first = Math.min(first, start);
      end = Math.max(end, start + count);
    });
    geometry.setDrawRange(first, end - first);
    const { min, max } = answer.document.accessorAt(piece.rawPrimitives[0]!.attributes['POSITION']!);
    geometry.boundingBox = new Box3(new Vector3(...(min as [number, number, number])), new Vector3(...(max as [number, number, number])));
    geometry.boundingSphere = geometry.boundingBox.getBoundingSphere(new Sphere());
    const mesh = new Mesh(geometry, used);
    mesh.name = piece.name;
    mesh.position.set(...piece.translation);
    if (piece.turn) {
      mesh.quaternion.set(...piece.turn.rotation);
      mesh.scale.setScalar(piece.turn.scale);
    }
    return mesh;
  };
  return pieces.map(piece => {
    const mesh = meshOf(piece);
    if (!(piece instanceof Fragment)) return mesh;
    mesh.userData['fragment'] = piece.id;
    if (piece.sheet) {
      const sheet = meshOf(piece.sheet);
      sheet.userData['fragment'] = piece.id;
      mesh.add(sheet);
    }
    return mesh;
  });
}
