// Reads the raw triangles of a file that the server refused, so that the page can show where the problem is. Reads the common
// parts of OBJ, STL, PLY, OFF and GLB. Other formats have no preview.
import { Glb, type GltfNode } from 'fracture-client';
import { Matrix4, Quaternion, Vector3 } from 'three';

/** Returns the corners of the triangles, three numbers each; undefined if the file cannot be read here. */
export function trianglesOf(name: string, bytes: Uint8Array): Float32Array | undefined {
  const ending = /\.([^./]+)$/.exec(name)?.[1]?.toLowerCase();
  try {
    const found = ending === 'glb' ? glb(bytes) : ending === 'stl' ? stl(bytes) : ending === 'obj' ? obj(textOf(bytes))
      : ending === 'off' ? off(textOf(bytes)) : ending === 'ply' ? ply(bytes) : undefined;
    return found && found.length >= 9 && found.every(Number.isFinite) ? found : undefined;
  } catch {
    return undefined;
  }
}

const textOf = (bytes: Uint8Array) => new TextDecoder().decode(bytes);

/** Splits polygons into fans of triangles. Returns the corners of the triangles. */
function corners(points: readonly (readonly number[])[], faces: Iterable<readonly number[]>): Float32Array {
  const out: number[] = [];
  for (const face of faces) for (let k = 2; k < face.length; ++k) for (const v of [face[0]!, face[k - 1]!, face[k]!]) out.push(...points[v]!);
  return new Float32Array(out);
}

function obj(text: string): Float32Array {
  const points: number[][] = [], faces: number[][] = [];
  for (const line of text.replace(/\\\r?\n/g, ' ').split('\n')) {
    const [kind, ...words] = line.trim().split(/\s+/);
    if (kind === 'v') points.push(words.slice(0, 3).map(Number));
    if (kind === 'f') faces.push(words.map(word => parseInt(word, 10)).map(k => (k < 0 ? points.length + k : k - 1)));
  }
  return corners(points, faces);
}

function stl(bytes: Uint8Array): Float32Array {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength), count = bytes.length >= 84 ? view.getUint32(80, true) : 0;
  if (bytes.length !== 84 + 50 * count)
    return new Float32Array([...textOf(bytes).matchAll(/vertex\s+(\S+)\s+(\S+)\s+(\S+)/g)].flatMap(([, x, y, z]) => [Number(x), Number(y), Number(z)]));
  const out = new Float32Array(9 * count);
  for (let t = 0; t < count; ++t) for (let k = 0; k < 9; ++k) out[9 * t + k] = view.getFloat32(84 + 50 * t + 12 + 4 * k, true);
  return out;
}

function off(text: string): Float32Array {
  const lines = text.split('\n').map(line => line.replace(/#.*/, '').trim()).filter(Boolean);
  const numbers = lines[0]!.replace(/^[A-Z]*OFF\s*/, '') === '' ? 1 : 0, [vertices = 0, faces = 0] = lines[numbers]!.replace(/^[A-Z]*OFF\s*/, '').split(/\s+/).map(Number);
  const rows = lines.slice(numbers + 1).map(line => line.split(/\s+/).map(Number)), points = rows.slice(0, vertices).map(row => row.slice(0, 3));
  return corners(points, rows.slice(vertices, vertices + faces).map(([count = 0, ...face]) => face.slice(0, count)));
}

const SIZES: Record<string, [keyof DataView, number]> = {
  char: ['getInt8', 1], int8: ['getInt8', 1], uchar: ['getUint8', 1], uint8: ['getUint8', 1], short: ['getInt16', 2], int16: ['getInt16', 2],
  ushort: ['getUint16', 2], uint16: ['getUint16', 2], int: ['getInt32', 4], int32: ['getInt32', 4], uint: ['getUint32', 4], uint32: ['getUint32', 4],
  float: ['getFloat32', 4], float32: ['getFloat32', 4], double: ['getFloat64', 8], float64: ['getFloat64', 8],
};

function ply(bytes: Uint8Array): Float32Array {
  const start = textOf(bytes.subarray(0, 1 << 16)), end = /end_header\r?\n/.exec(start)!, header = start.slice(0, end.index).split(/\r?\n/);
  const binary = !header.some(line => line.startsWith('format ascii')), little = header.some(line => line.includes('little_endian'));
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  let at = new TextEncoder().encode(start.slice(0, end.index + end[0].length)).length;
  const words = binary ? [] : textOf(bytes.subarray(at)).split(/\s+/).filter(Boolean).map(Number);
  let word = 0;
  const next = (type: string): number => {
    if (!binary) return words[word++]!;
    const [read, size] = SIZES[type]!, value = (view[read] as (at: number, little: boolean) => number).call(view, at, little);
    at += size;
    return value;
  };
  const points: number[][] = [], faces: number[][] = [];
  let element = '', count = 0, properties: string[][] = [];
  const readElement = () => {
    for (let k = 0; k < count; ++k) {
      const row: Record<string, number> = {};
      for (const [first, ...rest] of properties) {
        if (first === 'list') {
          const list = Array.from({ length: next(rest[0]!) }, () => next(rest[1]!));
          if (element === 'face' && /^vertex_ind/.test(rest[2]!)) faces.push(list);
        } else row[rest[0]!] = next(first!);
      }
      if (element === 'vertex') points.push([row['x']!, row['y']!, row['z']!]);
    }
  };
  for (const line of header) {
    const [kind, ...rest] = line.split(/\s+/);
    if (kind === 'element') {
      readElement();
      [element, count, properties] = [rest[0]!, Number(rest[1]), []];
    } else if (kind === 'property') properties.push(rest);
  }
  readElement();
  return corners(points, faces);
}

function glb(bytes: Uint8Array): Float32Array {
  const file = new Glb(bytes), { nodes = [], scenes = [], scene = 0, meshes = [] } = file.json, out: number[] = [], point = new Vector3();
  const walk = (node: GltfNode | undefined, parent: Matrix4, depth: number) => {
    if (!node || depth > 64) return;
    const own = node.matrix ? new Matrix4().fromArray(node.matrix)
      : new Matrix4().compose(new Vector3(...node.translation ?? [0, 0, 0]), new Quaternion(...node.rotation ?? [0, 0, 0, 1]), new Vector3(...node.scale ?? [1, 1, 1]));
    const world = parent.clone().multiply(own);
    for (const { attributes, indices, mode = 4 } of meshes[node.mesh ?? -1]?.primitives ?? []) {
      if (mode !== 4) continue;
      const positions = file.accessor(attributes['POSITION']!);
      const index = indices === undefined ? Array.from({ length: positions.length / 3 }, (_, k) => k) : file.accessor(indices);
      for (const v of index) out.push(...point.fromArray(positions, 3 * v).applyMatrix4(world).toArray());
    }
    for (const child of node.children ?? []) walk(nodes[child], world, depth + 1);
  };
  for (const root of scenes[scene]?.nodes ?? []) walk(nodes[root], new Matrix4(), 0);
  return new Float32Array(out);
}

const METRES: Record<string, number> = { m: 1, cm: 0.01, mm: 0.001, inch: 0.0254, km: 1000 };

/** Converts points to the server's frame: metres, y up. */
export function framed(points: Float32Array, unit: unknown, up: unknown): Float32Array {
  const scale = METRES[String(unit)] ?? 1;
  for (let k = 0; k < points.length; k += 3) {
    const [x, y, z] = [points[k]!, points[k + 1]!, points[k + 2]!];
    points.set(up === 'z' ? [scale * x, scale * z, -scale * y] : [scale * x, scale * y, scale * z], k);
  }
  return points;
}
