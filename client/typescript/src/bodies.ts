// Functions for rigid bodies in any physics engine, without three.js. They compute mass, centre and inertia in double precision, the
// motion of fragments that replace a moving body, and the bonds that a blow breaks. client/examples/babylon uses them with Havok.
export { type Blow, brokenBy, components, energyOf, GIVE } from './three/bonds.js';
export { combine, inertiaOf, inherit, massOf, momentumOf, placed, principalAxes, rotate, setMomentum } from './three/mass.js';
export type { Mat3, MassProperties, Momentum, MovingBody, Quat, Vec3 } from './three/mass.js';
