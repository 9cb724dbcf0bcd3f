// Generates sample shapes as GLB, so that the server does not need any sample files.
import { type Gltf, packGlb } from 'fracture-client';

/** Triangles, with separate vertices where the surface has a sharp edge. */
export class Surface {
  readonly positions: number[] = [];
  readonly normals: number[] = [];
  readonly uvs: number[] = [];
  readonly triangles: number[] = [];

  vertex(position: readonly number[], normal: readonly number[], u: number, v: number): number {
    this.positions.push(...position);
    const size = Math.hypot(...normal) || 1;
    this.normals.push(...normal.map(value => value / size));
    this.uvs.push(u, v);
    return this.positions.length / 3 - 1;
  }

  /** Adds a quadrilateral. Its corners are counter-clockwise when seen from outside. */
  quad(a: number, b: number, c: number, d: number): void {
    this.triangles.push(a, b, c, a, c, d);
  }

  /** Adds a box around `middle`. */
  box([x, y, z]: readonly [number, number, number], [w, h, d]: readonly [number, number, number]): this {
    const faces = [[0, 1, 2], [1, 2, 0], [2, 0, 1]] as const, half = [w / 2, h / 2, d / 2], middle = [x, y, z];
    for (const [axis, u, v] of faces)
      for (const sign of [1, -1]) {
        const corner = (su: number, sv: number) => {
          const at = [...middle], normal = [0, 0, 0];
          at[axis]! += sign * half[axis]!;
          at[u]! += su * half[u]!;
          at[v]! += sv * half[v]!;
          normal[axis] = sign;
          return this.vertex(at, normal, (su + 1) / 2, (sv + 1) / 2);
        };
        const corners = [corner(-1, -1), corner(sign, -sign), corner(1, 1), corner(-sign, sign)] as const;
        this.quad(...corners);
      }
    return this;
  }

  /** Adds the surface of a profile rotated about y. The profile is a list of (radius, height), upwards along the outside. `closed`:
   * the last point is joined to the first (a torus, a vase with an inside); otherwise both ends must lie on the axis. */
  lathe(profile: readonly (readonly [number, number])[], around: number, closed = false): this {
    const rows = closed ? profile.length + 1 : profile.length, at: number[][] = [];
    const point = (k: number) => profile[(k + profile.length) % profile.length]!;
    for (let row = 0; row < rows; ++row) {
      const [r, y] = point(row), [ra, ya] = closed || row > 0 ? point(row - 1) : point(row);
      const [rb, yb] = closed || row < rows - 1 ? point(row + 1) : point(row);
      const nr = yb - ya, ny = -(rb - ra);
      at.push(Array.from({ length: around + 1 }, (_, k) => {
        const angle = 2 * Math.PI * (k % around) / around, c = Math.cos(angle), s = Math.sin(angle);
        return this.vertex([r * c, y, -r * s], [nr * c, ny, -nr * s], k / around, row / (rows - 1));
      }));
    }
    for (let row = 0; row + 1 < rows; ++row)
      for (let k = 0; k < around; ++k) {
        const [a, b, c, d] = [at[row]![k]!, at[row]![k + 1]!, at[row + 1]![k + 1]!, at[row + 1]![k]!];
        if (point(row)[0] > 0) this.triangles.push(a, b, d);
        if (point(row + 1)[0] > 0) this.triangles.push(b, c, d);
      }
    return this;
  }
}

export interface Look {
  /** Linear RGBA. The surface is translucent if alpha is below 1. */
  color: readonly [number, number, number, number];
  roughness: number;
  metallic?: number;
}

/** Returns a GLB with a single mesh and a single material. */
export function glbOf(surface: Surface, name: string, { color, roughness, metallic = 0 }: Look): Uint8Array {
  const parts = [
    new Float32Array(surface.positions), new Float32Array(surface.normals), new Float32Array(surface.uvs), new Uint32Array(surface.triangles),
  ];
  const binary = new Uint8Array(parts.reduce((sum, part) => sum + part.byteLength, 0));
  let offset = 0;
  const bufferViews = parts.map((part, k) => {
    const view = { buffer: 0, byteOffset: offset, byteLength: part.byteLength, target: k === 3 ? 34963 : 34962 };
    binary.set(new Uint8Array(part.buffer), offset);
    offset += part.byteLength;
    return view;
  });
  const count = surface.positions.length / 3, bounds = (of: (...values: number[]) => number, start: number) => [0, 1, 2].map(axis => {
    let value = start;
    for (let k = axis; k < parts[0]!.length; k += 3) value = of(value, parts[0]![k]!);
    return value;
  });
  const json: Gltf = {
    asset: { version: '2.0', generator: 'fracture' }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0, name }],
    meshes: [{ name, primitives: [{ attributes: { POSITION: 0, NORMAL: 1, TEXCOORD_0: 2 }, indices: 3, material: 0 }] }],
    materials: [{
      name, pbrMetallicRoughness: { baseColorFactor: color, metallicFactor: metallic, roughnessFactor: roughness },
      ...(color[3] < 1 ? { alphaMode: 'BLEND' } : {}),
    }],
    accessors: [
      { bufferView: 0, componentType: 5126, count, type: 'VEC3', min: bounds(Math.min, Infinity), max: bounds(Math.max, -Infinity) },
      { bufferView: 1, componentType: 5126, count, type: 'VEC3' }, { bufferView: 2, componentType: 5126, count, type: 'VEC2' },
      { bufferView: 3, componentType: 5125, count: surface.triangles.length, type: 'SCALAR' },
    ],
    bufferViews, buffers: [{ byteLength: binary.byteLength }],
  };
  return packGlb(json, binary);
}
