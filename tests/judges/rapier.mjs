// Rapier's rest test: the hulls at their places, without gravity, for one second. No fragment may move faster than
// 1 mm/s: hulls that overlap or touch at spawn are pushed apart by the solver. And no two hulls that may collide overlap by
// more than 0.2 mm per metre of the file's size, by separating axes in double, without an engine. Mass, centre and inertia
// read back equal the file's. The file's collision filters are obeyed: they exclude only fragments that overlap by more
// than that, and each fragment is in one of at most 32 systems.
//   usage: node rapier.mjs FILE.glb …
import { bodiesOf, collide, installed, judgeAll, massComplaints, parse } from './files.mjs';
import { leastGap, needlessFilters, toleranceOf } from './separation.mjs';

const RAPIER = (await installed(() => import('@dimforge/rapier3d-compat'))).default;
await RAPIER.init();

const LIMIT = 1e-3;  // m/s
const STEPS = 60;    // of 1/60 s

const vector = ([x, y, z]) => ({ x, y, z }), array = ({ x, y, z }) => [x, y, z];
const quaternion = ([x, y, z, w]) => ({ x, y, z, w });

/** Simulates the bodies for one second. */
function rest(bodies) {
  const complaints = [], world = new RAPIER.World({ x: 0, y: 0, z: 0 });
  const rigid = bodies.map(body => {
    const { mass, centerOfMass, inertiaDiagonal, inertiaOrientation } = body.motion;
    const made = world.createRigidBody(RAPIER.RigidBodyDesc.dynamic().setTranslation(...body.translation).setCanSleep(false)
      .setAdditionalMassProperties(mass, vector(centerOfMass), vector(inertiaDiagonal), quaternion(inertiaOrientation)));
    for (const { points } of body.hulls) {
      const shape = RAPIER.ColliderDesc.convexHull(points);
      if (!shape) complaints.push(`${body.name}: Rapier makes no hull of ${points.length / 3} points`);
      else world.createCollider(shape.setDensity(0).setActiveHooks(RAPIER.ActiveHooks.FILTER_CONTACT_PAIRS)
        .setFriction(body.material.dynamicFriction).setRestitution(body.material.restitution), made);
    }
    made.recomputeMassPropertiesFromColliders();
    return made;
  });
  const bodyOf = new Map(rigid.map((body, k) => [body.handle, bodies[k]])), filtered = new Set(), events = new RAPIER.EventQueue(true);
  const hooks = {
    filterContactPair: (c1, c2, b1, b2) => {
      const [a, b] = [bodyOf.get(b1), bodyOf.get(b2)];
      if (collide(a, b)) return RAPIER.SolverFlags.COMPUTE_IMPULSE;
      filtered.add([a.name, b.name].sort().join());
      return null;
    },
    filterIntersectionPair: () => true,
  };
  const moving = new Map();
  let fastest = 0;
  for (let step = 0; step < STEPS; ++step) {
    world.step(events, hooks);
    rigid.forEach((body, k) => {
      const speed = Math.hypot(...array(body.linvel()));
      fastest = Math.max(fastest, speed);
      if (!(speed <= LIMIT)) moving.set(k, Math.max(speed, moving.get(k) ?? 0));
    });
  }
  rigid.forEach((body, k) => {
    const { x, y, z, w } = body.principalInertiaLocalFrame(), { hulls } = bodies[k];
    const size = hulls.reduce((most, { points }) => points.reduce((a, c) => Math.max(a, Math.abs(c)), most), 0);
    complaints.push(...massComplaints(bodies[k], { mass: body.mass(), centerOfMass: array(body.localCom()),
      inertiaDiagonal: array(body.principalInertia()), inertiaOrientation: [x, y, z, w] }, size));
  });
  for (const [k, speed] of moving) complaints.push(`${bodies[k].name} of ${bodies[k].motion.mass} kg moves at ${speed} m/s`);
  world.free();
  return { fastest, filtered: filtered.size, complaints };
}

await judgeAll(async bytes => {
  const complaints = [], bodies = bodiesOf(parse(bytes));
  let hulls = 0;
  for (const body of bodies) {
    if (!body.hulls.length) complaints.push(`${body.name} has no collider`);
    for (const { points } of body.hulls) if (points.length > 3 * 255) complaints.push(`${body.name}: a hull of ${points.length / 3} points`);
    hulls += body.hulls.length;
    if (body.filter && body.filter.collisionSystems?.length !== 1) complaints.push(`${body.name} is not in one collision system`);
  }
  const systems = new Set(bodies.flatMap(({ filter }) => filter?.collisionSystems ?? [])), tolerance = toleranceOf(bodies);
  if (systems.size > 32) complaints.push(`${systems.size} collision systems`);
  for (const pair of needlessFilters(bodies, tolerance)) complaints.push(`${pair} have a filter but do not overlap`);
  if (!bodies.length) complaints.push('no rigid bodies');
  const { gap, between, pairs } = leastGap(bodies);
  if (!(gap > -tolerance)) complaints.push(`the hulls of ${between} overlap by ${-gap} m and may collide`);
  const { fastest, filtered, complaints: moved } = rest(bodies);
  complaints.push(...moved);
  return { note: `${bodies.length} bodies, ${hulls} hulls, ${pairs} pairs compared, least gap ${pairs ? gap.toPrecision(2) : '-'} m, ` +
    `${filtered} pairs filtered, fastest ${fastest.toPrecision(2)} m/s`, complaints };
});
