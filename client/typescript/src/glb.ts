// A GLB file from the server (glTF 2.0, one buffer, no required extensions): its JSON, and typed arrays that are views of its bytes.
// Interleaved and sparse accessors are copied, but the geometry of fragments has none.
import { localError } from './problems.js';

export interface GltfNode {
  name?: string;
  mesh?: number;
  children?: number[];
  translation?: Vector3;
  rotation?: [number, number, number, number];
  scale?: Vector3;
  matrix?: number[];
  extensions?: Record<string, any>;
  extras?: Record<string, any>;
}
export interface GltfPrimitive {
  attributes: Record<string, number>;
  indices?: number;
  material?: number;
  mode?: number;
  extensions?: Record<string, any>;
}
export interface GltfMesh {
  name?: string;
  primitives: GltfPrimitive[];
  extensions?: Record<string, any>;
}
export interface GltfAccessor {
  bufferView?: number;
  byteOffset?: number;
  componentType: number;
  count: number;
  type: string;
  normalized?: boolean;
  min?: number[];
  max?: number[];
  sparse?: {
    count: number;
    indices: { bufferView: number; byteOffset?: number; componentType: number };
    values: { bufferView: number; byteOffset?: number };
  };
}
export interface GltfBufferView {
  buffer: number;
  byteOffset?: number;
  byteLength: number;
  byteStride?: number;
  target?: number;
}
/** The JSON of a glTF file. Lists only the members that this package reads. */
export interface Gltf {
  asset: { version: string; generator?: string; copyright?: string; extras?: any };
  scene?: number;
  scenes?: { nodes?: number[] }[];
  nodes?: GltfNode[];
  meshes?: GltfMesh[];
  accessors?: GltfAccessor[];
  bufferViews?: GltfBufferView[];
  buffers?: { byteLength: number; uri?: string }[];
  materials?: any[];
  textures?: any[];
  samplers?: any[];
  images?: { name?: string; mimeType?: string; bufferView?: number; uri?: string }[];
  extensions?: Record<string, any>;
  extensionsUsed?: string[];
  [member: string]: any;
}

export type Vector3 = [number, number, number];
export type TypedArray = Float32Array | Uint32Array | Uint16Array | Uint8Array | Int16Array | Int8Array;

const COMPONENTS = {
  5120: Int8Array, 5121: Uint8Array, 5122: Int16Array, 5123: Uint16Array, 5125: Uint32Array, 5126: Float32Array,
} as const;
const WIDTH: Record<string, number> = { SCALAR: 1, VEC2: 2, VEC3: 3, VEC4: 4, MAT2: 4, MAT3: 9, MAT4: 16 };

const MAGIC = 0x46546c67, JSON_CHUNK = 0x4e4f534a, BIN_CHUNK = 0x004e4942;

const digits = (count: number): string => count.toLocaleString('en');
export const bytesPerComponent = (componentType: number): number => componentOf(componentType).BYTES_PER_ELEMENT;
export const widthOf = (accessor: GltfAccessor): number => WIDTH[accessor.type] ?? bad(`the accessor type ${accessor.type} is unknown`);

function bad(why: string): never {
  throw localError('damaged-answer', `The GLB cannot be read: ${why}.`);
}

function componentOf(componentType: number) {
  return COMPONENTS[componentType as keyof typeof COMPONENTS] ?? bad(`the component type ${componentType} is unknown`);
}

export class Glb {
  /** The bytes of the file. */
  readonly bytes: Uint8Array;
  readonly json: Gltf;
  /** The binary chunk. */
  readonly binary: Uint8Array;

  /** Parses a GLB. Throws FractureError (damaged-answer). */
  constructor(bytes: Uint8Array) {
    // Views of floats must start at a multiple of four bytes. A slice of a larger array that starts elsewhere is copied.
    this.bytes = bytes.byteOffset % 4 === 0 ? bytes : bytes.slice();
    const view = new DataView(this.bytes.buffer, this.bytes.byteOffset, this.bytes.byteLength), size = view.byteLength;
    if (size < 20 || view.getUint32(0, true) !== MAGIC) bad('it does not begin with "glTF"');
    if (view.getUint32(4, true) !== 2) bad(`its version is ${view.getUint32(4, true)}, not 2`);
    if (view.getUint32(8, true) !== size)
      bad(`its header announces ${digits(view.getUint32(8, true))} bytes, but the file has ${digits(size)}`);
    const text = view.getUint32(12, true), end = 20 + text;
    if (view.getUint32(16, true) !== JSON_CHUNK || end > size) bad('its first chunk is not its JSON');
    try {
      this.json = JSON.parse(new TextDecoder('utf-8', { fatal: true }).decode(this.bytes.subarray(20, end))) as Gltf;
    } catch (cause) {
      throw localError('damaged-answer', 'The GLB cannot be read: its JSON is damaged.', { cause });
    }
    this.binary = this.bytes.subarray(end, end);
    if (size >= end + 8) {
      const length = view.getUint32(end, true);
      if (view.getUint32(end + 4, true) !== BIN_CHUNK || end + 8 + length > size) bad('its second chunk is not its buffer');
      this.binary = this.bytes.subarray(end + 8, end + 8 + length);
    }
  }

  /** Returns the bytes of a bufferView. */
  view(index: number): Uint8Array {
    const view = this.json.bufferViews?.[index] ?? bad(`bufferView ${index} does not exist`), at = view.byteOffset ?? 0;
    if (at + view.byteLength > this.binary.length) bad(`bufferView ${index} extends past the end of the buffer`);
    return this.binary.subarray(at, at + view.byteLength);
  }

  accessorAt(index: number): GltfAccessor {
    return this.json.accessors?.[index] ?? bad(`accessor ${index} does not exist`);
  }

  /** Returns the numbers in an accessor. The type determines how many numbers an element has (VEC3: three). */
  accessor(index: number): TypedArray {
    const accessor = this.accessorAt(index), Type = componentOf(accessor.componentType), width = widthOf(accessor);
    const length = accessor.count * width;
    let values: TypedArray;
    if (accessor.bufferView === undefined) {
      values = new Type(length);
    } else {
      const view = this.view(accessor.bufferView), at = view.byteOffset + (accessor.byteOffset ?? 0);
      const element = width * Type.BYTES_PER_ELEMENT, stride = this.json.bufferViews![accessor.bufferView]!.byteStride ?? element;
      const last = accessor.count > 0 ? (accessor.count - 1) * stride + element : 0;
      if ((accessor.byteOffset ?? 0) + last > view.byteLength) bad(`accessor ${index} extends past the end of its bufferView`);
      if (at % Type.BYTES_PER_ELEMENT !== 0) bad(`accessor ${index} is not aligned`);
      if (stride === element) {
        values = new Type(view.buffer as ArrayBuffer, at, length);
      } else {
        values = new Type(length);
        for (let k = 0; k < accessor.count; ++k) values.set(new Type(view.buffer as ArrayBuffer, at + k * stride, width), k * width);
      }
    }
    const { sparse } = accessor;
    if (!sparse) return values;
    const read = (part: { bufferView: number; byteOffset?: number }, Of: typeof Type, count: number) => {
      const view = this.view(part.bufferView), at = part.byteOffset ?? 0;
      if (at + count * Of.BYTES_PER_ELEMENT > view.byteLength)
        bad(`the sparse values of accessor ${index} extend past the end of their bufferView`);
      return new Of(view.buffer as ArrayBuffer, view.byteOffset + at, count);
    };
    const places = read(sparse.indices, componentOf(sparse.indices.componentType), sparse.count);
    const others = read(sparse.values, Type, sparse.count * width), copy = values.slice();
    places.forEach((place: number, k: number) => copy.set(others.subarray(k * width, (k + 1) * width), place * width));
    return copy;
  }

  /** Returns the bytes of an image in the file; undefined for an external image. */
  image(index: number): { bytes: Uint8Array; type: string } | undefined {
    const image = this.json.images?.[index];
    if (image?.bufferView === undefined) return undefined;
    return { bytes: this.view(image.bufferView), type: image.mimeType ?? 'image/png' };
  }
}

/** Returns the bytes of a GLB with this JSON and this buffer. */
export function packGlb(json: Gltf, binary: Uint8Array): Uint8Array {
  const text = new TextEncoder().encode(JSON.stringify(json)), aligned = (size: number) => Math.ceil(size / 4) * 4;
  const textSize = aligned(text.length), binarySize = aligned(binary.length);
  const bytes = new Uint8Array(20 + textSize + (binarySize > 0 ? 8 + binarySize : 0)), view = new DataView(bytes.buffer);
  [MAGIC, 2, bytes.length, textSize, JSON_CHUNK].forEach((word, k) => view.setUint32(4 * k, word, true));
  bytes.set(text, 20);
  bytes.fill(0x20, 20 + text.length, 20 + textSize);
  if (binarySize === 0) return bytes;
  view.setUint32(20 + textSize, binarySize, true);
  view.setUint32(24 + textSize, BIN_CHUNK, true);
  bytes.set(binary, 28 + textSize);
  return bytes;
}
