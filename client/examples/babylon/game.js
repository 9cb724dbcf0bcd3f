// The same game as ../web, with Babylon and Havok. A click throws a ball at the pointer. While it flies, the server breaks the ring where
// the ball will hit it, and the fragments replace the ring in the air. Options: ?server=http://…, ?fragments=60
import { Color3, Color4, CreateBox, CreateSphere, CreateTorusVertexData, DirectionalLight, Engine, FreeCamera, HavokPlugin, HemisphericLight,
  Material, Matrix, Mesh, MultiMaterial, PhysicsAggregate, PhysicsBody, PhysicsMotionType, PhysicsShapeContainer, PhysicsShapeConvexHull,
  PhysicsShapeType, Quaternion, Scene, StandardMaterial, SubMesh, TransformNode, Vector3, VertexData } from '@babylonjs/core';
import HavokPhysics from '@babylonjs/havok';
import havokBinary from '@babylonjs/havok/lib/esm/HavokPhysics.wasm';
import { Client } from 'fracture-client';
import { combine, inherit, massOf, momentumOf, placed, principalAxes } from 'fracture-client/bodies';

const query = new URLSearchParams(location.search), says = document.getElementById('says'), fragments = Number(query.get('fragments') ?? 60);
const client = new Client(query.get('server') ?? 'http://127.0.0.1:8080'), look = { material: 'concrete', rough_amplitude: 0, max_hulls: 1 };
const scene = new Scene(new Engine(document.getElementById('view'), true)), swaps = [];
scene.useRightHandedSystem = true;  // as in glTF
scene.clearColor = new Color4(0.79, 0.83, 0.86, 1);
scene.enablePhysics(new Vector3(0, -9.81, 0), new HavokPlugin(false, await HavokPhysics({ wasmBinary: havokBinary })));
new HemisphericLight('sky', new Vector3(0, 1, 0), scene).intensity = 0.6;
new DirectionalLight('sun', new Vector3(-0.4, -0.9, -0.5), scene);
new FreeCamera('eye', new Vector3(0, 2.6, 8), scene).setTarget(new Vector3(0, 2, 0));
const colored = hex => Object.assign(new StandardMaterial(hex, scene), { diffuseColor: Color3.FromHexString(hex), specularColor: Color3.Black() });
const skins = new MultiMaterial('fragment', scene), red = colored('#b3262e');
skins.subMaterials = [colored('#7b8890'), colored('#b0a793')];  // outside, cut faces; corners in glTF's order
for (const skin of skins.subMaterials) skin.sideOrientation = Material.CounterClockWiseSideOrientation;
const floor = Object.assign(CreateBox('floor', { width: 60, depth: 60 }, scene), { position: new Vector3(0, -0.5, 0), material: colored('#7d868c') });
new PhysicsAggregate(floor, PhysicsShapeType.BOX, { mass: 0 }, scene);

function meshOf(name, parent, data) {
  const mesh = new Mesh(name, scene, parent);
  Object.assign(new VertexData(), data).applyToMesh(mesh);
  return mesh;
}
/** Fragments as a single body whose frame is the mesh's frame, at this position in the world. */
function bodyOf(parts, at, turn) {
  const node = new TransformNode('body', scene), shape = new PhysicsShapeContainer(scene);
  [node.position, node.rotationQuaternion] = [Vector3.FromArray(at), Quaternion.FromArray(turn)];
  for (const { id, translation, positions, normals, triangles: indices, primitives, hulls, surface, collisionFilter: filter } of parts) {
    const mesh = meshOf(`fragment ${id}`, node, { positions, normals, indices });
    Object.assign(mesh, { position: Vector3.FromArray(translation), material: skins, subMeshes: [] });
    let from = 0;
    for (const { interior, triangles: { length: n } } of primitives) from += new SubMesh(+interior, 0, positions.length / 3, from, n, mesh).indexCount;
    for (const { positions, triangles: indices } of hulls) {
      const drawn = meshOf('hull', null, { positions, indices }), hull = new PhysicsShapeConvexHull(drawn, scene);
      drawn.dispose();
      hull.material = { friction: surface.friction, restitution: surface.restitution };
      // Fragments that overlap must not collide. Havok has 32 groups, one for each system.
      if (filter) {
        hull.filterMembershipMask = 1 << filter.system;
        hull.filterCollideMask = ~filter.excluded.reduce((mask, system) => mask | 1 << system, 0);
      }
      shape.addChild(hull, mesh.position);
    }
  }
  const body = new PhysicsBody(node, PhysicsMotionType.DYNAMIC, false, scene);
  const own = combine(parts.map(({ motion, translation }) => massOf(motion, translation))), { moments, axes } = principalAxes(own.inertia);
  body.shape = shape;
  const [centerOfMass, inertia] = [own.center, moments].map(values => Vector3.FromArray(values));
  body.setMassProperties({ mass: own.mass, centerOfMass, inertia, inertiaOrientation: Quaternion.FromArray(axes) });
  return { node, body, own };
}
const poseOf = ({ node }) => [node.position.asArray(), node.rotationQuaternion.asArray()];
const moving = thing => ({ ...placed(thing.own, ...poseOf(thing)),
  velocity: thing.body.getLinearVelocity().asArray(), spin: thing.body.getAngularVelocity().asArray() });
/** Replaces a body with the fragments of an answer, which continue its motion. */
function swap(old, { fragments: made }) {
  const was = moving(old), before = momentumOf([was]), parts = made.map(fragment => bodyOf([fragment], ...poseOf(old)));
  inherit(was, parts.map(part => placed(part.own, ...poseOf(part)))).forEach(({ velocity, spin }, k) => {
    parts[k].body.setLinearVelocity(Vector3.FromArray(velocity));
    parts[k].body.setAngularVelocity(Vector3.FromArray(spin));
  });
  swaps.push({ before, after: momentumOf(parts.map(moving), before.center), bodies: parts.length });
  old.body.dispose();
  old.node.dispose();
  return parts;
}

// The mesh is created here and sent to the server once. Unbroken, it has the mass and hulls of the fragments it will break into.
const { positions: p, indices: t } = CreateTorusVertexData({ diameter: 2.2, thickness: 0.8, tessellation: 48 }), text = [];
for (let k = 0; k < p.length; k += 3) text.push(`v ${p[k]} ${p[k + 2]} ${-p[k + 1]}`);
for (let k = 0; k < t.length; k += 3) text.push(`f ${t[k] + 1} ${t[k + 2] + 1} ${t[k + 1] + 1}`);
const mesh = await client.put({ name: 'ring.obj', data: new Blob([text.join('\n')]) }, { ask: false });
const whole = await mesh.fracture({ ...look, sites: 8 });
let stone = [bodyOf(whole.fragments, [0, 2, 0], [0, 0, 0, 1])], asked = false;
stone[0].body.setGravityFactor(0);  // it floats until a ball arrives
stone[0].body.setAngularVelocity(new Vector3(0.1, 0.5, 0));

async function throwBall({ clientX, clientY }) {
  const { origin, direction } = scene.createPickingRay(clientX, clientY, Matrix.Identity(), scene.activeCamera);
  const ball = Object.assign(CreateSphere('ball', { diameter: 0.5 }, scene), { position: origin.clone(), material: red });
  new PhysicsAggregate(ball, PhysicsShapeType.SPHERE, { mass: 260 }, scene).body.setLinearVelocity(direction.scale(14));
  const { hit, pickedPoint, distance } = scene.pick(clientX, clientY, ({ name }) => name.startsWith('fragment'));
  if (!hit || asked) return;
  asked = true;
  stone[0].body.setGravityFactor(1);  // tossed up, so that it is back in place when the ball arrives
  stone[0].body.setLinearVelocity(new Vector3(0, 9.81 / 2 * distance / 14, 0));
  const impact = Vector3.TransformCoordinates(pickedPoint, Matrix.Invert(stone[0].node.computeWorldMatrix(true))).asArray();
  const answer = await mesh.fracture({ ...look, fragments, impacts: [impact] }, { realtime: true });
  stone = swap(stone[0], answer);
  says.textContent = `${answer.fragments.length} fragments, in ${Math.round(answer.head.timing.work)} ms`;
}
addEventListener('pointerdown', event => throwBall(event).catch(error => (says.textContent = error.detail ?? error)));
says.textContent = 'Click the ring.';
scene.getEngine().runRenderLoop(() => scene.render());
Object.assign(globalThis, { swaps, state: () => stone.map(moving) });  // for the console
