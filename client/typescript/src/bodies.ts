// Rigid bodies for any physics engine, without three.js: mass, centre and inertia in double precision, fragments that replace a
// moving body and keep its momentum, and the bonds that a blow breaks. client/examples/babylon uses it with Havok.
export { type Blow, brokenBy, components, energyOf, GIVE } from './three/bonds.js';
export { combine, inertiaOf, inherit, massOf, momentumOf, placed, principalAxes, rotate, setMomentum } from './three/mass.js';
export type { Mat3, MassProperties, Momentum, MovingBody, Quat, Vec3 } from './three/mass.js';
