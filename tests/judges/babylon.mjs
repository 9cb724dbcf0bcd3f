// Babylon (NullEngine) must load the file, and Havok must accept its rigid bodies. Mass, centre and inertia read back from
// the engine must equal those of the visible triangles at the stated density. The fragments are dropped on a plane and must
// rest on it: in metres those that Havok can simulate in metres, in centimetres all. Babylon's own packages contain no
// loader of KHR_physics_rigid_bodies, so files.mjs reads the extension.   usage: node babylon.mjs FILE.glb …
import fs from 'node:fs';
import { createRequire } from 'node:module';
import path from 'node:path';
import { accessor, bodiesOf, fragmentsOf, installed, inUnits, judgeAll, massComplaints, parse, tensorOf } from './files.mjs';

const core = file => installed(() => import(`@babylonjs/core/${file}.js`));
const HavokPhysics = (await installed(() => import('@babylonjs/havok'))).default;
await installed(() => import('@babylonjs/loaders/glTF/2.0/index.js'));
const { NullEngine } = await core('Engines/nullEngine'), { Scene } = await core('scene');
const { LoadAssetContainerAsync } = await core('Loading/sceneLoader');
const { Logger } = await core('Misc/logger');
const { Vector3, Quaternion } = await core('Maths/math.vector');
const { Mesh } = await core('Meshes/mesh'), { VertexData } = await core('Meshes/mesh.vertexData');
const { TransformNode } = await core('Meshes/transformNode');
await core('Physics/joinedPhysicsEngineComponent');
await core('Physics/v2/physicsEngineComponent');
const { HavokPlugin } = await core('Physics/v2/Plugins/havokPlugin');
const { PhysicsBody } = await core('Physics/v2/physicsBody');
const { PhysicsShapeConvexHull, PhysicsShapeContainer, PhysicsShapeBox } = await core('Physics/v2/physicsShape');
const { PhysicsMotionType } = await core('Physics/v2/IPhysicsEnginePlugin');
const folder = path.dirname(createRequire(import.meta.url).resolve('@babylonjs/havok'));
const havok = await HavokPhysics({ wasmBinary: fs.readFileSync(path.join(folder, 'HavokPhysics.wasm')) });
Logger.LogLevels = Logger.ErrorLogLevel;

const STEP = 1 / 240, LONGEST = 30;  // s; some fragments are splinters of millimetres
const REST = 0.02;                  // share of the speed after a fall from the height of the whole: at rest if slower for half a second
// Havok lets bodies fall through the plane, at any time step, if their resistance to turning is below about 5e-6 in its units. This was
// tried: splinters alone on the plane fall through, and with inertia made 400 times larger they lie still. Above that limit, bodies may
// jitter or roll in a circle for ever, half in the plane. One of 4e-5 did: a strip of leather. In a heap they also push the others. So
// files with such light bodies are dropped twice (in metres: an edge of 4 to 8 cm at the density of water). The first drop is in metres
// without these bodies. The second is in centimetres, where every fragment must rest, except dust: the only one of all files that still
// falls has 2.6 µg.
const WORLDS = [{ unit: 1, name: 'metres', judged: body => Math.min(...body.motion.inertiaDiagonal) >= 1e-4 },  // kg m²
  { unit: 100, name: 'centimetres', judged: body => body.motion.mass >= 1e-8 }];                                 // kg

/** Volume, centre and inertia tensor (xx yy zz xy xz yz, about the centre) of the triangles, with density 1. */
function measured(glb, node) {
  const { primitives } = glb.json.meshes[node.mesh], p = accessor(glb, primitives[0].attributes.POSITION);
  let volume = 0;
  const first = [0, 0, 0], second = [0, 0, 0, 0, 0, 0], pairs = [[0, 0], [1, 1], [2, 2], [0, 1], [0, 2], [1, 2]];
  for (const primitive of primitives) {
    const indices = accessor(glb, primitive.indices);
    for (let t = 0; t < indices.length; t += 3) {
      const [a, b, c] = [0, 1, 2].map(k => [...p.subarray(3 * indices[t + k], 3 * indices[t + k] + 3)]), sum = [0, 1, 2].map(k => a[k] + b[k] + c[k]);
      const six = a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
      volume += six / 6;
      first.forEach((_, k) => (first[k] += six / 24 * sum[k]));
      pairs.forEach(([i, j], k) => (second[k] += six / 120 * (sum[i] * sum[j] + a[i] * a[j] + b[i] * b[j] + c[i] * c[j])));
    }
  }
  const center = first.map(x => x / volume), moment = pairs.map(([i, j], k) => second[k] - volume * center[i] * center[j]);
  const [xx, yy, zz, xy, xz, yz] = moment;
  const size = p.reduce((most, x) => Math.max(most, Math.abs(x)), 0);
  return { volume, center, size, tensor: [yy + zz, xx + zz, xx + yy, -xy, -xz, -yz] };
}

/** The largest distance of a stored position from the exact one: half a step of the lattice and of the local floats. */
const rounding = ({ json }, size) =>
  Math.max(...json.nodes.map(n => n.extras?.fracture).find(f => f?.lattice).lattice.step) + size * 2 ** -23;

/** Whether a body can have this inertia: the second moments (half the trace minus the tensor) must be positive. */
function possible([xx, yy, zz, xy, xz, yz]) {
  const half = (xx + yy + zz) / 2, [a, b, c] = [half - xx, half - yy, half - zz];
  const minors = [a, b, c, a * b - xy * xy, a * c - xz * xz, b * c - yz * yz,
    a * (b * c - yz * yz) - xy * (xy * c - yz * xz) + -xz * (xy * yz - b * xz)];
  return minors.every(m => m > 0);
}

function hullShape({ points, triangles }, scene) {
  const mesh = new Mesh('hull', scene), data = new VertexData();
  data.positions = points;
  data.indices = triangles;
  data.applyToMesh(mesh);
  const shape = new PhysicsShapeConvexHull(mesh, scene);
  mesh.dispose();
  return shape;
}

/** Reads back the masses of the bodies, given in the world's units. Drops the judged bodies on a plane until they rest. */
function drop(bodies, inMetres, { unit, name, judged }, scene) {
  const complaints = [], gravity = 9.81 * unit;
  scene.enablePhysics(new Vector3(0, -gravity, 0), new HavokPlugin(false, havok));
  let low = Infinity, high = -Infinity, wide = 0;
  const made = bodies.map((body, k) => {
    const at = new TransformNode(body.name, scene);
    at.position = Vector3.FromArray(body.translation);
    const rigid = new PhysicsBody(at, PhysicsMotionType.DYNAMIC, false, scene), hulls = body.hulls.map(hull => hullShape(hull, scene));
    const shape = hulls.length === 1 ? hulls[0] : new PhysicsShapeContainer(scene);
    if (hulls.length !== 1) hulls.forEach(hull => shape.addChild(hull));
    for (const { points } of body.hulls) {
      for (let v = 0; v < points.length; v += 3) {
        low = Math.min(low, points[v + 1] + body.translation[1]);
        high = Math.max(high, points[v + 1] + body.translation[1]);
        wide = Math.max(wide, Math.abs(points[v] + body.translation[0]), Math.abs(points[v + 2] + body.translation[2]));
      }
    }
    if (body.filter) {  // Havok has 32 bits, one for each system
      const bits = systems => (systems ?? []).reduce((mask, system) => mask | 1 << Number(system), 0);
      for (const part of new Set([...hulls, shape])) {
        part.filterMembershipMask = bits(body.filter.collisionSystems);
        part.filterCollideMask = ~bits(body.filter.notCollideWithSystems);
      }
    }
    for (const part of hulls) part.material = { friction: body.material.dynamicFriction, restitution: body.material.restitution };
    rigid.shape = shape;
    const { mass, centerOfMass, inertiaDiagonal, inertiaOrientation } = body.motion;
    rigid.setMassProperties({ mass, centerOfMass: Vector3.FromArray(centerOfMass), inertia: Vector3.FromArray(inertiaDiagonal),
      inertiaOrientation: Quaternion.FromArray(inertiaOrientation) });
    rigid.setAngularDamping(2);  // without it round pieces roll for minutes
    rigid.setLinearDamping(0.2);
    const read = rigid.getMassProperties();
    complaints.push(...massComplaints(body, { mass: read.mass, centerOfMass: read.centerOfMass.asArray(),
      inertiaDiagonal: read.inertia.asArray(), inertiaOrientation: read.inertiaOrientation.asArray() }, inMetres[k].size * unit));
    if (!judged(inMetres[k])) rigid.dispose();
    return rigid;
  });

  const tall = high - low, ground = new TransformNode('ground', scene);
  const still = new PhysicsBody(ground, PhysicsMotionType.STATIC, false, scene), reach = 20 * (wide + tall);
  still.shape = new PhysicsShapeBox(new Vector3(0, low - 0.1 * tall - 0.5 * tall, 0), Quaternion.Identity(), new Vector3(reach, tall, reach), scene);
  still.shape.material = { friction: 0.6, restitution: 0.1 };
  const floor = low - 0.1 * tall, velocity = new Vector3(), rest = REST * Math.sqrt(gravity * tall);
  const heavy = made.filter((_, k) => judged(inMetres[k]));
  const speed = body => (body.getLinearVelocityToRef(velocity), velocity.length());
  let seconds = 0, quiet = 0;
  for (; seconds < LONGEST && quiet < 0.5; seconds += STEP) {
    scene.getPhysicsEngine()._step(STEP);
    quiet = heavy.every(body => speed(body) < rest) && seconds > 0.5 ? quiet + STEP : 0;
  }
  for (const body of heavy) {
    const { y } = body.transformNode.position;
    if (quiet < 0.5 && !(speed(body) < rest)) complaints.push(`${body.transformNode.name} still moves at ${speed(body)} ${name} a second after ${LONGEST} s`);
    if (!(y > floor - 0.02 * tall)) complaints.push(`${body.transformNode.name} lies at ${y} ${name}, under the plane at ${floor}`);
  }
  scene.disablePhysicsEngine();
  const light = made.length - heavy.length;
  return { note: `in ${name} ${heavy.length} bodies at rest after ${seconds.toFixed(1)} s${light ? ` (${light} too light to judge)` : ''}`, complaints };
}

await judgeAll(async (bytes, file) => {
  const complaints = [], glb = parse(bytes), nodes = fragmentsOf(glb.json);
  const engine = new NullEngine(), scene = new Scene(engine);
  scene.useRightHandedSystem = true;
  const data = bytes[0] === 0x7b ? `data:${new TextDecoder().decode(bytes)}` : bytes;
  const container = await LoadAssetContainerAsync(data, scene, { pluginExtension: bytes[0] === 0x7b ? '.gltf' : '.glb',
    pluginOptions: { gltf: { skipMaterials: true } } });
  container.addAllToScene();
  const loaded = new Map(container.getNodes().map(node => [node.name, node]));
  for (const node of nodes) {
    const object = loaded.get(node.name);
    if (!object) complaints.push(`${node.name} is missing`);
    else if (object.metadata?.gltf?.extras?.fracture?.id !== node.extras.fracture.id) complaints.push(`${node.name} has lost its id`);
  }

  const described = bodiesOf(glb);
  if (!described.length) complaints.push('no rigid bodies');
  let inverted = 0;
  for (const body of described) {  // compares the file's figures with those of the triangles, whose positions are rounded
    const { mass, centerOfMass, inertiaDiagonal, inertiaOrientation } = body.motion, density = body.fracture.mass / body.fracture.volume;
    const ours = measured(glb, nodes.find(n => n.extras.fracture.id === body.fracture.id)), { size } = ours;
    const off = (what, a, b, tolerance) => Math.abs(a - b) <= tolerance || complaints.push(`${body.name}: ${what} ${a}, not ${b}`);
    const trace = inertiaDiagonal[0] + inertiaDiagonal[1] + inertiaDiagonal[2], slack = rounding(glb, size) * body.fracture.area;  // m³
    off('mass', mass, ours.volume * density, 1e-9 * mass + density * slack);
    for (let k = 0; k < 3; ++k) off('centre', centerOfMass[k], ours.center[k], 1e-9 * size + 2 * size * slack / ours.volume);
    const tensor = tensorOf(inertiaDiagonal, inertiaOrientation);
    if (!(inertiaDiagonal.every(m => m > 0 && m <= trace / 2 * (1 + 1e-6)))) complaints.push(`${body.name}: no body has moments ${inertiaDiagonal}`);
    if (possible(ours.tensor)) for (let k = 0; k < 6; ++k) off('inertia', tensor[k], ours.tensor[k] * density, 1e-9 * trace + 2 * density * size * size * slack);
    else ++inverted;  // surfaces that cross themselves: parts of negative volume
    body.size = size;
  }
  const notes = [];
  for (const world of WORLDS) {
    const { note, complaints: more } = drop(inUnits(described, world.unit), described, world, scene);
    complaints.push(...more);
    notes.push(note);
    if (described.every(world.judged)) break;
  }
  scene.dispose();
  engine.dispose();
  if (inverted) notes.push(`${inverted} with an impossible tensor of their own`);
  return { note: notes.join('; '), complaints };
});
