// The parts of Rapier that this package uses. The caller passes in the module; any 3D Rapier package works.
import type { Fragment } from '../fragments.js';
import { inertiaOf, type MovingBody, multiply, type Quat, type Vec3 } from './mass.js';

interface Xyz {
  x: number;
  y: number;
  z: number;
}
interface Xyzw extends Xyz {
  w: number;
}
export interface RapierBody {
  readonly handle: number;
  translation(): Xyz;
  rotation(): Xyzw;
  linvel(): Xyz;
  angvel(): Xyz;
  setLinvel(velocity: Xyz, wakeUp: boolean): void;
  setAngvel(velocity: Xyz, wakeUp: boolean): void;
  mass(): number;
  worldCom(): Xyz;
  principalInertia(): Xyz;
  principalInertiaLocalFrame(): Xyzw;
  recomputeMassPropertiesFromColliders(): void;
  isDynamic(): boolean;
  isSleeping(): boolean;
}
export interface RapierCollider {
  readonly handle: number;
  parent(): RapierBody | null;
}
export interface RapierWorld {
  gravity: Xyz;
  timestep: number;
  createRigidBody(description: any): any;
  createCollider(description: any, parent?: any): any;
  removeRigidBody(body: any): void;
  getCollider(handle: number): any;
}
/** The module: import RAPIER from '@dimforge/rapier3d-compat'. */
export interface Rapier {
  RigidBodyDesc: any;
  ColliderDesc: any;
  ActiveEvents: any;
}
/** An event of EventQueue.drainContactForceEvents(). */
export interface ContactForce {
  collider1(): number;
  collider2(): number;
  totalForceMagnitude(): number;
}

export const xyz = ([x, y, z]: Vec3): Xyz => ({ x, y, z });
export const xyzw = ([x, y, z, w]: Quat): Xyzw => ({ x, y, z, w });
export const vec = ({ x, y, z }: Xyz): Vec3 => [x, y, z];
export const quat = ({ x, y, z, w }: Xyzw): Quat => [x, y, z, w];

/** Returns the current motion of a Rapier body, in double precision. */
export function movingBody(body: RapierBody): MovingBody {
  const axes = multiply(quat(body.rotation()), quat(body.principalInertiaLocalFrame()));
  return {
    mass: body.mass(), center: vec(body.worldCom()), inertia: inertiaOf(vec(body.principalInertia()), axes),
    velocity: vec(body.linvel()), spin: vec(body.angvel()),
  };
}

/** Sets the velocities of a body, rounded to floats. */
export function setMotion(body: RapierBody, { velocity, spin }: Pick<MovingBody, 'velocity' | 'spin'>): void {
  body.setLinvel(xyz(velocity), true);
  body.setAngvel(xyz(spin), true);
}

/** Returns collider descriptions for a fragment, in the frame of a body in which the fragment is at `offset`. Colliders have no
 * mass, because mass and inertia belong to the body. `threshold`: force (N) above which contacts are reported. */
export function colliders({ ColliderDesc, ActiveEvents }: Rapier, fragment: Fragment, offset: Vec3, threshold: number | undefined): any[] {
  const { hulls, surface: { friction, restitution }, collisionFilter } = fragment;
  return hulls.flatMap(({ positions, triangles }) => {
    // Rapier recomputes the hull from the points and merges almost coplanar faces. This halves the time of a step.
    const shape = ColliderDesc.convexHull(positions) ?? ColliderDesc.convexMesh(positions, Uint32Array.from(triangles));
    if (!shape) return [];
    shape.setTranslation(...offset).setDensity(0).setFriction(friction).setRestitution(restitution);
    // Rapier has 16 groups. From system 16 on, systems share the groups 1 to 15: then a few more pairs do not collide.
    if (collisionFilter) {
      const group = (system: number) => 1 << (system === 0 ? 0 : 1 + (system - 1) % 15);
      const excluded = collisionFilter.excluded.reduce((groups, system) => groups | group(system), 0);
      shape.setCollisionGroups((group(collisionFilter.system) << 16 | 0xffff & ~excluded) >>> 0);
    }
    if (threshold !== undefined) shape.setActiveEvents(ActiveEvents.CONTACT_FORCE_EVENTS).setContactForceEventThreshold(threshold);
    return [shape];
  });
}
