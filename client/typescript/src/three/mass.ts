// Mass, centre and inertia of rigid bodies in double precision, their sums, and the momentum of a set of bodies. Units: kg, m, s.
// Game physics engines compute in floats, so values that must agree exactly are computed here.
import type { Motion } from '../fragments.js';

export type Vec3 = [number, number, number];
/** A unit quaternion: x, y, z, w. */
export type Quat = [number, number, number, number];
/** A 3 × 3 matrix in row-major order. As an inertia, it is symmetric. */
export type Mat3 = [number, number, number, number, number, number, number, number, number];

export const add = (a: Vec3, b: Vec3): Vec3 => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
export const sub = (a: Vec3, b: Vec3): Vec3 => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
export const scale = (s: number, a: Vec3): Vec3 => [s * a[0], s * a[1], s * a[2]];
export const dot = (a: Vec3, b: Vec3): number => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const cross = (a: Vec3, b: Vec3): Vec3 => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
export const length = (a: Vec3): number => Math.hypot(...a);

export const conjugate = ([x, y, z, w]: Quat): Quat => [-x, -y, -z, w];
export const multiply = ([ax, ay, az, aw]: Quat, [bx, by, bz, bw]: Quat): Quat => [
  aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx,
  aw * bz + ax * by - ay * bx + az * bw, aw * bw - ax * bx - ay * by - az * bz,
];
export function matrixOf(q: Quat): Mat3 {
  const size = Math.hypot(...q), [x, y, z, w] = q.map(c => c / size) as Quat;
  return [
    1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w),
    2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w),
    2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y),
  ];
}
export const apply = (m: Mat3, v: Vec3): Vec3 => [
  m[0] * v[0] + m[1] * v[1] + m[2] * v[2], m[3] * v[0] + m[4] * v[1] + m[5] * v[2], m[6] * v[0] + m[7] * v[1] + m[8] * v[2],
];
export const rotate = (q: Quat, v: Vec3): Vec3 => apply(matrixOf(q), v);
const transposed = (m: Mat3): Mat3 => [m[0], m[3], m[6], m[1], m[4], m[7], m[2], m[5], m[8]];
function product(a: Mat3, b: Mat3): Mat3 {
  const m: number[] = [];
  for (let row = 0; row < 3; ++row)
    for (let column = 0; column < 3; ++column)
      m.push(a[3 * row]! * b[column]! + a[3 * row + 1]! * b[3 + column]! + a[3 * row + 2]! * b[6 + column]!);
  return m as Mat3;
}
/** Returns the inertia R diag(moments) Rᵀ, where R is the rotation `axes`. */
export function inertiaOf(moments: Vec3, axes: Quat): Mat3 {
  const r = matrixOf(axes);
  return product(product(r, [moments[0], 0, 0, 0, moments[1], 0, 0, 0, moments[2]]), transposed(r));
}
export const turned = (inertia: Mat3, by: Quat): Mat3 => product(product(matrixOf(by), inertia), transposed(matrixOf(by)));
const sum = (a: Mat3, b: Mat3): Mat3 => a.map((value, k) => value + b[k]!) as Mat3;

/** A body's mass properties, in any frame. */
export interface MassProperties {
  /** kg */
  mass: number;
  /** m */
  center: Vec3;
  /** kg·m², about the centre. */
  inertia: Mat3;
}

/** Returns a fragment's mass properties in the mesh's frame. `translation`: the translation of its node. */
export function massOf(motion: Motion, translation: Vec3): MassProperties {
  const inertia = inertiaOf(motion.inertiaDiagonal, motion.inertiaOrientation);
  return { mass: motion.mass, center: add(translation, motion.centerOfMass), inertia };
}

/** Returns the same mass properties in world space. The mesh's frame is at `at` and has the rotation `turn`. */
export function placed({ mass, center, inertia }: MassProperties, at: Vec3, turn: Quat): MassProperties {
  return { mass, center: add(at, rotate(turn, center)), inertia: turned(inertia, turn) };
}

/** Returns the inertia (kg·m²) of a point mass at this offset from the centre (m). */
export function pointInertia(mass: number, [x, y, z]: Vec3): Mat3 {
  return [
    mass * (y * y + z * z), -mass * x * y, -mass * x * z, -mass * x * y, mass * (x * x + z * z), -mass * y * z,
    -mass * x * z, -mass * y * z, mass * (x * x + y * y),
  ];
}

/** Returns the mass properties of all parts as a single rigid body (Huygens–Steiner). Without parts, the mass is 0. */
export function combine(parts: readonly MassProperties[]): MassProperties {
  let mass = 0, moment: Vec3 = [0, 0, 0];
  for (const part of parts) {
    mass += part.mass;
    moment = add(moment, scale(part.mass, part.center));
  }
  const center = mass > 0 ? scale(1 / mass, moment) : moment;
  let inertia: Mat3 = [0, 0, 0, 0, 0, 0, 0, 0, 0];
  for (const part of parts) inertia = sum(inertia, sum(part.inertia, pointInertia(part.mass, sub(part.center, center))));
  return { mass, center, inertia };
}

/** Returns the principal moments and axes, so that inertia = R diag(moments) Rᵀ. Uses Jacobi rotations, and is exact except for the
 * rounding error of doubles. */
export function principalAxes(inertia: Mat3): { moments: Vec3; axes: Quat } {
  let m = inertia, axes: Quat = [0, 0, 0, 1];
  for (let sweep = 0; sweep < 30; ++sweep) {
    const off: [number, number, number][] = [[0, 1, m[1]], [0, 2, m[2]], [1, 2, m[5]]];
    const [p, q, value] = off.reduce((a, b) => (Math.abs(b[2]) > Math.abs(a[2]) ? b : a));
    if (Math.abs(value) <= 1e-16 * (Math.abs(m[0]) + Math.abs(m[4]) + Math.abs(m[8]))) break;
    const angle = 0.5 * Math.atan2(2 * value, m[4 * p]! - m[4 * q]!);
    const axis: Vec3 = [0, 0, 0], third = 3 - p - q;
    axis[third] = (q - p === 2 ? -1 : 1) * Math.sin(angle / 2);  // rotates p towards q; from x to z, this is negative about y
    axes = multiply(axes, [...axis, Math.cos(angle / 2)]);
    m = product(product(transposed(matrixOf(axes)), inertia), matrixOf(axes));
  }
  const size = Math.hypot(...axes);
  return { moments: [m[0], m[4], m[8]], axes: axes.map(c => c / size) as Quat };
}

/** A rigid body in the world; centre and inertia use the world's axes. */
export interface MovingBody extends MassProperties {
  /** m/s, of the centre. */
  velocity: Vec3;
  /** rad/s */
  spin: Vec3;
}

export interface Momentum {
  mass: number;
  /** kg·m/s */
  linear: Vec3;
  /** kg·m²/s, about `center`. */
  angular: Vec3;
  /** m */
  center: Vec3;
}

/** Returns the total momentum of all bodies, about their common centre of mass or another point. */
export function momentumOf(bodies: readonly MovingBody[], about?: Vec3): Momentum {
  const { mass, center: own } = combine(bodies), center = about ?? own;
  let linear: Vec3 = [0, 0, 0], angular: Vec3 = [0, 0, 0];
  for (const body of bodies) {
    const carried = scale(body.mass, body.velocity);
    linear = add(linear, carried);
    angular = add(angular, add(apply(body.inertia, body.spin), cross(sub(body.center, center), carried)));
  }
  return { mass, linear, angular, center };
}

/** Adds the same rigid motion to all bodies, so that together they have the wanted momentum. Bodies without mass are unchanged. */
export function setMomentum(bodies: MovingBody[], wanted: Momentum): void {
  const { mass, center, inertia } = combine(bodies);
  if (!(mass > 0)) return;
  const now = momentumOf(bodies, wanted.center);
  const push = scale(1 / mass, sub(wanted.linear, now.linear));
  // The push acts at the common centre, but the wanted momentum may refer to another point.
  const turn = sub(sub(wanted.angular, now.angular), cross(sub(center, wanted.center), scale(mass, push)));
  const { moments, axes } = principalAxes(inertia), along = rotate(conjugate(axes), turn);
  const least = 1e-12 * Math.max(...moments);  // no spin about an axis without inertia, as in a needle
  const spin = rotate(axes, along.map((value, k) => (moments[k]! > least ? value / moments[k]! : 0)) as Vec3);
  for (const body of bodies) {
    body.velocity = add(body.velocity, add(push, cross(spin, sub(body.center, center))));
    body.spin = add(body.spin, spin);
  }
}

/** Replaces a moving body with parts. Each part gets the velocity v + ω × r at its centre. Then all parts get a common rigid motion,
 * so that their total linear and angular momentum equal those of the body even if the masses differ. Everything is in world space. */
export function inherit(body: MovingBody, parts: readonly MassProperties[]): MovingBody[] {
  const made = parts.map(part => ({
    ...part, velocity: add(body.velocity, cross(body.spin, sub(part.center, body.center))), spin: [...body.spin] as Vec3,
  }));
  setMomentum(made, momentumOf([body]));
  return made;
}
