// The rotation and uniform scale of the node of an unbroken instance (parameter instances=keep).
import type { Motion } from './fragments.js';
import type { GltfNode, TypedArray, Vector3 } from './glb.js';

type Quaternion = [number, number, number, number];

const rotate = ([x, y, z, w]: Quaternion, [a, b, c]: Vector3): Vector3 => {
  const u = 2 * (y * c - z * b), v = 2 * (z * a - x * c), t = 2 * (x * b - y * a);
  return [a + w * u + y * t - z * v, b + w * v + z * u - x * t, c + w * t + x * v - y * u];
};

export class Turn {
  constructor(readonly rotation: Quaternion, readonly scale: number) {}

  /** Returns a rotated copy of positions, normals or tangents. Positions are also scaled. Other attributes do not change. */
  attribute(name: string, values: TypedArray): TypedArray {
    const width = name === 'TANGENT' ? 4 : 3, scale = name === 'POSITION' ? this.scale : 1;
    if (!['POSITION', 'NORMAL', 'TANGENT'].includes(name)) return values;
    const turned = Float32Array.from(values);
    for (let k = 0; k < turned.length; k += width)
      turned.set(rotate(this.rotation, [scale * turned[k]!, scale * turned[k + 1]!, scale * turned[k + 2]!]), k);
    return turned;
  }
  motion(motion: Motion): Motion {
    const center = motion.centerOfMass.map(value => this.scale * value) as Vector3;
    const turned = { ...motion, centerOfMass: rotate(this.rotation, center) };
    if (motion.inertiaOrientation) turned.inertiaOrientation = product(this.rotation, motion.inertiaOrientation);
    return turned;
  }
}

/** Rotates by `b` first, then by `a`. */
export const product = ([x, y, z, w]: Quaternion, [a, b, c, d]: Quaternion): Quaternion =>
  [w * a + x * d + y * c - z * b, w * b - x * c + y * d + z * a, w * c + x * b - y * a + z * d, w * d - x * a - y * b - z * c];

export function turnOf({ rotation, scale }: GltfNode): Turn | undefined {
  return rotation || scale ? new Turn(rotation ?? [0, 0, 0, 1], scale?.[0] ?? 1) : undefined;
}
