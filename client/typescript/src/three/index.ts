// Fragments in a game that uses three.js and Rapier.
//
//     const setup = { rapier, world, parent: scene, materials };
//     const intact = place(await mesh.fracture({ sites: 1 }), setup, { position: [0, 2, 0] });
//     …
//     const pieces = swap(intact, await mesh.fracture({ material: 'stone', impacts: [point] }), setup);
//     …
//     pieces.update();  // each frame
import type { Object3D } from 'three';
import type { Answer } from '../answer.js';
import type { Blow } from './bonds.js';
import type { Vec3 } from './mass.js';
import { type PieceOptions, Pieces, type Pose, type World } from './pieces.js';
import type { RapierBody } from './rapier.js';

/** Your own body and its drawn object. `origin`: the origin of the body's frame, in the mesh's frame (m). Default: [0, 0, 0]. */
export interface OwnBody {
  body: RapierBody;
  object3D: Object3D;
  origin?: Vec3;
}

/** Puts an answer into the world. `whole`: as a single unbroken body with the mass and inertia of all fragments, even if they have no
 * bonds. Throws FractureError (bad-argument) for an answer without rigid bodies. */
export function place(answer: Answer, world: World, how: Pose & PieceOptions & { whole?: boolean } = {}): Pieces {
  const { whole = false, position = [0, 0, 0], rotation = [0, 0, 0, 1], ...options } = how;
  const pieces = new Pieces(answer, world, options);
  pieces.start({ position, rotation }, whole);
  return pieces;
}

/** Replaces a moving body with the fragments of an answer for the same mesh. Call it between two steps. The body and its drawn object
 * are removed. Momentum is conserved unless a fragment is anchored; `pieces.swaps` records it. `impact`: with `bonded`, the blow that
 * breaks the first bonds. Throws FractureError (bad-argument). */
export function swap(object: Pieces | OwnBody, answer: Answer, world: World, how: PieceOptions & { impact?: Blow } = {}): Pieces {
  const { impact, ...options } = how;
  const pieces = new Pieces(answer, world, options);
  if (object instanceof Pieces) {
    const { rigid, origin } = object.only();
    pieces.startAs(rigid, origin, impact);
    object.release();
  } else {
    pieces.startAs(object.body, object.origin ?? [0, 0, 0], impact);
    object.object3D.removeFromParent();
  }
  return pieces;
}

export { type Blow, brokenBy, energyOf, GIVE } from './bonds.js';
export { combine, momentumOf, principalAxes, setMomentum } from './mass.js';
export type { MassProperties, Momentum, MovingBody, Quat, Vec3 } from './mass.js';
export { materialsOf } from './materials.js';
export { meshesOf } from './meshes.js';
export { type PieceOptions, Pieces, type Pose, type SwapRecord, type World } from './pieces.js';
export { type ContactForce, movingBody, type Rapier, type RapierBody, type RapierCollider, type RapierWorld } from './rapier.js';
