// Rapier's rest test: the hulls at their places, without gravity, for one second. No fragment may move faster than
// 1 mm/s: hulls that overlap or touch at spawn are pushed apart by the solver. The file's collision filters are obeyed,
// and may concern only fragments of one cell.   usage: node rapier.mjs FILE.glb …
import { bodiesOf, collide, installed, judgeAll, parse } from './files.mjs';

const RAPIER = (await installed(() => import('@dimforge/rapier3d-compat'))).default;
await RAPIER.init();

const LIMIT = 1e-3;  // m/s
const STEPS = 60;    // of 1/60 s

await judgeAll(async bytes => {
  const complaints = [], bodies = bodiesOf(parse(bytes)), world = new RAPIER.World({ x: 0, y: 0, z: 0 });
  let hulls = 0, fastest = 0;
  const rigid = bodies.map(body => {
    const [x, y, z] = body.translation, [qx, qy, qz, qw] = body.motion.inertiaOrientation, at = body.motion.centerOfMass;
    const vec = ([vx, vy, vz]) => ({ x: vx, y: vy, z: vz });
    const made = world.createRigidBody(RAPIER.RigidBodyDesc.dynamic().setTranslation(x, y, z).setCanSleep(false)
      .setAdditionalMassProperties(body.motion.mass, vec(at), vec(body.motion.inertiaDiagonal), { x: qx, y: qy, z: qz, w: qw }));
    if (!body.hulls.length) complaints.push(`${body.name} has no collider`);
    for (const { points } of body.hulls) {
      if (points.length > 3 * 255) complaints.push(`${body.name}: a hull of ${points.length / 3} points`);
      const shape = RAPIER.ColliderDesc.convexHull(points);
      if (!shape) complaints.push(`${body.name}: Rapier makes no hull of ${points.length / 3} points`);
      else world.createCollider(shape.setDensity(0).setActiveHooks(RAPIER.ActiveHooks.FILTER_CONTACT_PAIRS).setFriction(body.material.dynamicFriction).setRestitution(body.material.restitution), made);
      ++hulls;
    }
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
  for (const a of bodies)
    if (a.filter && !bodies.some(b => b !== a && b.fracture.sites.some(site => a.fracture.sites.includes(site))))
      complaints.push(`${a.name} has a filter but no other piece of its cell`);
  const moving = new Map();
  for (let step = 0; step < STEPS; ++step) {
    world.step(events, hooks);
    rigid.forEach((body, k) => {
      const { x, y, z } = body.linvel(), speed = Math.hypot(x, y, z);
      fastest = Math.max(fastest, speed);
      if (!(speed <= LIMIT)) moving.set(bodies[k].name, Math.max(speed, moving.get(bodies[k].name) ?? 0));
    });
  }
  for (const [name, speed] of moving) complaints.push(`${name} moves at ${speed} m/s`);
  if (!bodies.length) complaints.push('no rigid bodies');
  world.free();
  return { note: `${bodies.length} bodies, ${hulls} hulls, ${filtered.size} pairs filtered, fastest ${fastest} m/s`, complaints };
});
