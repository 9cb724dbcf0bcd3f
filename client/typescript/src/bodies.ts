// Rigid bodies of fragments for any physics engine: mass, centre and inertia of the file in double precision, what takes a moving
// body's place with its momentum, and which bonds a blow breaks. Without three.js; client/examples/babylon is its use with Havok.
export { type Blow, brokenBy, components, energyOf, GIVE } from './three/bonds.js';
export { combine, inertiaOf, inherit, massOf, momentumOf, placed, principalAxes, rotate, setMomentum } from './three/mass.js';
export type { Mat3, MassProperties, Momentum, MovingBody, Quat, Vec3 } from './three/mass.js';
