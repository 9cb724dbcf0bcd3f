// Fragments as bodies of Rapier and meshes of three.js, from answers of fracture-server (FRACTURE_TEST_SERVER).
import assert from 'node:assert/strict';
import { before, describe, test } from 'node:test';
import { built, Client, dependency, noServer, realServer, refusal, torusFile } from './support.mjs';

const { default: RAPIER } = await dependency('@dimforge/rapier3d-compat');
const THREE = await dependency('three');
// The same three.js that the package finds, so that only one is loaded.
const { materialsOf, meshesOf, momentumOf, movingBody, place, swap } = await built('three/index.js');

/** Rapier computes in float32: sums over a hundred bodies keep about seven digits. */
const WITHIN = 1e-6;
const off = (a, b) => Math.hypot(...a.map((value, k) => value - b[k])) / Math.hypot(...b);

describe('the helper for three.js', { skip: noServer }, () => {
  let mesh, whole, answer, anchored;
  before(async () => {
    await RAPIER.init();
    mesh = await new Client((await realServer()).url).put(torusFile);
    [whole, answer, anchored] = await Promise.all([
      mesh.fracture({ material: 'concrete', sites: 1 }), mesh.fracture({ material: 'concrete', fragments: 60, rough_amplitude: 0 }),
      mesh.fracture({ material: 'concrete', fragments: 20, anchor_plane: [[0, -0.35, 0], [0, 1, 0]] })]);
  });

  async function setting(gravity = -9.81) {
    const world = new RAPIER.World({ x: 0, y: gravity, z: 0 });
    world.timestep = 1 / 120;
    return { rapier: RAPIER, world, parent: new THREE.Scene(), materials: await materialsOf(answer) };
  }
  /** Makes a torus that flies and turns. */
  function flying(setup) {
    const intact = place(whole, setup, { whole: true, position: [1, 20, 3], rotation: [0.1, 0.2, 0.3, Math.sqrt(1 - 0.14)] });
    const [body] = intact.rigidBodies;
    body.setLinvel({ x: 7, y: 3, z: -2 }, true);
    body.setAngvel({ x: 1, y: -2, z: 0.5 }, true);
    for (let k = 0; k < 5; ++k) setup.world.step();
    return intact;
  }
  function holds({ before, after, held }) {
    assert.equal(held, false);
    assert.ok(off(after.linear, before.linear) < WITHIN, `linear ${after.linear}, was ${before.linear}`);
    assert.ok(off(after.angular, before.angular) < WITHIN, `angular ${after.angular}, was ${before.angular}`);
  }

  test('bodies have the mass, centre and inertia of the file', async () => {
    const setup = await setting(), pieces = place(answer, setup);
    assert.equal(pieces.rigidBodies.length, answer.fragments.length);
    for (const { id, motion, translation, centerOfMass } of answer.fragments) {
      const body = pieces.bodyOf(id), { x, y, z } = body.principalInertia(), at = body.translation(), com = body.worldCom();
      assert.ok(Math.abs(body.mass() - motion.mass) < 1e-6 * motion.mass);
      assert.ok(off([x, y, z].sort((a, b) => a - b), [...motion.inertiaDiagonal].sort((a, b) => a - b)) < 1e-4);
      assert.ok(Math.hypot(at.x - translation[0], at.y - translation[1], at.z - translation[2]) < 1e-6);
      assert.ok(Math.hypot(com.x - centerOfMass[0], com.y - centerOfMass[1], com.z - centerOfMass[2]) < 1e-5);
      assert.deepEqual(pieces.fragmentsIn(body), [id]);
    }
    assert.equal(setup.world.colliders.len(), answer.fragments.reduce((sum, { hulls }) => sum + hulls.length, 0));
  });

  test('a swap in flight keeps linear and angular momentum, and every point its velocity', async () => {
    const setup = await setting(), intact = flying(setup), [body] = intact.rigidBodies, { velocity, spin, center } = movingBody(body);
    const pieces = swap(intact, answer, setup);
    assert.deepEqual([pieces.swaps.length, pieces.rigidBodies.length, setup.world.bodies.len()], [1, answer.fragments.length, answer.fragments.length]);
    holds(pieces.swaps[0]);
    for (const rigid of pieces.rigidBodies) {
      const { center: at, velocity: v, spin: w } = movingBody(rigid), r = at.map((c, k) => c - center[k]);
      const field = [spin[1] * r[2] - spin[2] * r[1], spin[2] * r[0] - spin[0] * r[2], spin[0] * r[1] - spin[1] * r[0]].map((c, k) => c + velocity[k]);
      assert.ok(off(v, field) < 1e-3 && off(w, spin) < 1e-3, `${v}, ${field}`);
    }
    // In a step without contacts, nothing is thrown apart.
    const { linear, mass } = pieces.momentum();
    setup.world.step();
    const later = pieces.momentum().linear;
    assert.ok(Math.hypot(later[0] - linear[0], later[1] - linear[1] + mass * 9.81 / 120, later[2] - linear[2]) < 1e-5 * Math.hypot(...linear));
  });

  test('a body of one\'s own is replaced, whatever it weighs', async () => {
    const setup = await setting(), object3D = new THREE.Object3D();
    setup.parent.add(object3D);
    const body = setup.world.createRigidBody(RAPIER.RigidBodyDesc.dynamic().setTranslation(0, 5, 0).setLinvel(2, 0, 1).setAngvel({ x: 0, y: 3, z: 1 }));
    setup.world.createCollider(RAPIER.ColliderDesc.cuboid(1.4, 0.4, 1.4).setDensity(700), body);
    setup.world.step();
    const pieces = swap({ body, object3D, origin: [0, 0.1, 0] }, answer, setup), [made] = pieces.swaps;
    assert.ok(Math.abs(made.after.mass - made.before.mass) > 0.1 * made.before.mass);
    holds(made);
    assert.deepEqual(setup.parent.children, [pieces.object3D]);
    // The object's origin was 0.1 m above that of the mesh, so the mesh is that much lower.
    assert.ok(Math.abs(pieces.momentum().center[1] - (5 - 0.1)) < 0.02, `${pieces.momentum().center}`);
  });

  test('bonds hold until a blow breaks them; parts move on as they did', async () => {
    const setup = await setting(), pieces = swap(flying(setup), answer, setup, { bonded: true });
    assert.deepEqual([pieces.rigidBodies.length, pieces.bondsLeft], [1, answer.bonds.length]);
    holds(pieces.swaps[0]);
    assert.equal(pieces.strike([1.4, 0, 0], 0.001), 0);
    let broken = 0;
    const cost = answer.bonds.reduce((sum, { strength }) => sum + 0.5 * strength * 1e-4, 0);
    for (const point of [[1.4, 0, 0], [0, 0, 1.4], [-1.4, 0, 0]]) broken += pieces.strike(point, cost / 5);
    assert.ok(pieces.rigidBodies.length > 3, `${pieces.rigidBodies.length} parts`);
    assert.equal(pieces.bondsLeft, answer.bonds.length - broken);
    assert.ok(pieces.swaps.length > 1);
    pieces.swaps.forEach(holds);
    const members = pieces.rigidBodies.flatMap(body => pieces.fragmentsIn(body));
    assert.deepEqual(members.sort(), answer.fragments.map(({ id }) => id).sort());
  });

  test('a ball that hits breaks bonds, one that lies on it does not', async () => {
    const setup = await setting(), { world } = setup, events = new RAPIER.EventQueue(true);
    world.createCollider(RAPIER.ColliderDesc.cuboid(10, 0.5, 10).setTranslation(0, -0.95, 0));
    const pieces = place(answer, setup, { bonded: true });
    const ball = at => {
      const body = world.createRigidBody(RAPIER.RigidBodyDesc.dynamic().setTranslation(...at).setCcdEnabled(true));
      world.createCollider(RAPIER.ColliderDesc.ball(0.2).setDensity(5000), body);
      return body;
    };
    const steps = count => {
      let broken = 0;
      for (let k = 0; k < count; ++k) {
        world.step(events);
        events.drainContactForceEvents(event => pieces.onContact(event));
        broken += pieces.breakBonds();
      }
      return broken;
    };
    ball([1, 0.62, 0]);
    assert.equal(steps(60), 0);
    assert.equal(pieces.rigidBodies.length, 1);
    ball([-1, 1.2, 0]).setLinvel({ x: 0, y: -40, z: 0 }, true);
    assert.ok(steps(30) > 0);
    assert.ok(pieces.rigidBodies.length > 1, `${pieces.rigidBodies.length}`);
    pieces.update();
    for (const object of pieces.meshes) assert.ok(Number.isFinite(object.position.lengthSq()) && object.position.y > -1);
  });

  test('what is anchored stays', async () => {
    const setup = await setting(), pieces = place(anchored, setup), held = anchored.fragments.filter(({ anchored: yes }) => yes);
    assert.ok(held.length > 0 && held.length < anchored.fragments.length);
    for (const { id } of held) assert.ok(!pieces.bodyOf(id).isDynamic());
    assert.equal(swap(flying(setup), anchored, setup).swaps[0].held, true);
  });

  test('a point of the world is one of the mesh, wherever the fragment flew', async () => {
    const setup = await setting(), pieces = swap(flying(setup), answer, setup), { id, centerOfMass } = answer.fragments[5];
    for (let k = 0; k < 60; ++k) setup.world.step();
    const { x, y, z } = pieces.bodyOf(id).worldCom();
    assert.ok(off(pieces.pointOf(id, [x, y, z]), centerOfMass) < 1e-4);
    assert.equal((await refusal((async () => pieces.pointOf(1, [0, 0, 0]))())).parameter, 'id');
  });

  test('meshes share their buffers, and those are the file\'s', async () => {
    const meshes = meshesOf(answer, await materialsOf(answer)), buffers = new Set(), indices = new Set();
    meshes.forEach(({ geometry, position, userData }, k) => {
      const fragment = answer.fragments[k], { position: points } = geometry.attributes;
      assert.equal(userData.fragment, fragment.id);
      assert.deepEqual(position.toArray(), fragment.translation);
      assert.equal(points.count, fragment.positions.length / 3);
      for (const v of [0, points.count - 1])
        assert.deepEqual([points.getX(v), points.getY(v), points.getZ(v)], [...fragment.positions.subarray(3 * v, 3 * v + 3)]);
      const { start, count } = geometry.drawRange;
      assert.deepEqual([...geometry.index.array.subarray(start, start + count)], [...fragment.triangles]);
      assert.equal(geometry.groups.reduce((sum, group) => sum + group.count, 0), fragment.triangles.length);
      for (const attribute of Object.values(geometry.attributes)) buffers.add(attribute.data);
      indices.add(geometry.index);
      assert.ok(geometry.boundingSphere.radius > 0);
    });
    assert.ok(buffers.size <= 3 && indices.size === 1, `${buffers.size} ${indices.size}`);
    for (const { array } of buffers) assert.equal(array.buffer, answer.glb.buffer);
    // A ray hits it at its position.
    const scene = new THREE.Scene().add(...meshes);
    scene.updateMatrixWorld(true);
    const [hit] = new THREE.Raycaster(new THREE.Vector3(5, 0.01, 0.02), new THREE.Vector3(-1, 0, 0)).intersectObjects(meshes);
    assert.ok(Math.abs(hit.point.x - 1.4) < 0.03, `${hit.point.x}`);
  });

  test('nothing is left of what was removed', async () => {
    const setup = await setting(), pieces = swap(flying(setup), answer, setup);
    pieces.remove();
    assert.deepEqual([setup.world.bodies.len(), setup.world.colliders.len(), setup.parent.children.length, pieces.rigidBodies.length], [0, 0, 0, 0]);
  });

  test('what has no rigid bodies is refused', async () => {
    const setup = await setting(), none = await mesh.fracture({ sites: 4, physics: 'none' });
    assert.equal((await refusal((async () => place(none, setup))())).parameter, 'physics');
    assert.equal((await refusal((async () => swap(place(answer, setup), answer, setup))())).parameter, 'object');
    assert.deepEqual(momentumOf([]).linear, [0, 0, 0]);
  });
});
