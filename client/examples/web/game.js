// A click throws a ball at the pointer. While it flies, the server fractures the stone where the ball will hit it, and the fragments
// replace the stone in the air. Options: ?server=http://… (default: 127.0.0.1:8080), ?fragments=60
import RAPIER from '@dimforge/rapier3d-compat';
import * as THREE from 'three';
import { Client, packGlb } from 'fracture-client';
import { materialsOf, place, swap } from 'fracture-client/three';

const query = new URLSearchParams(location.search), says = document.getElementById('says');
const client = new Client(query.get('server') ?? 'http://127.0.0.1:8080');
const look = { material: 'concrete', max_hulls: 2 }, fragments = Number(query.get('fragments') ?? 200);

// A scene with a floor and light from above, and its physics.
await RAPIER.init();
const world = new RAPIER.World({ x: 0, y: -9.81, z: 0 }), events = new RAPIER.EventQueue(true);
world.createCollider(RAPIER.ColliderDesc.cuboid(30, 0.5, 30).setTranslation(0, -0.5, 0));
const scene = new THREE.Scene(), camera = new THREE.PerspectiveCamera(45, 1, 0.1, 100);
const renderer = new THREE.WebGLRenderer({ antialias: true }), sun = new THREE.DirectionalLight(0xfff2dd, 3);
scene.background = new THREE.Color(0xc9d3dc);
const floor = new THREE.Mesh(new THREE.CircleGeometry(30, 64).rotateX(-Math.PI / 2), new THREE.MeshStandardMaterial({ color: 0xa9b2b8 }));
scene.add(floor, sun, new THREE.HemisphereLight(0xdfeaff, 0x70665a, 1.6));
sun.position.set(4, 9, 5);
sun.castShadow = floor.receiveShadow = renderer.shadowMap.enabled = true;
Object.assign(sun.shadow.camera, { left: -6, right: 6, top: 6, bottom: -6 });
camera.position.set(0, 2.6, 8);
camera.lookAt(0, 2, 0);
document.body.append(renderer.domElement);
renderer.setSize(innerWidth, innerHeight);
camera.aspect = innerWidth / innerHeight;
camera.updateProjectionMatrix();

// The mesh is created here and sent to the server once. Unbroken, it has the mass and hulls of the fragments it will break into.
const { index, attributes: { position, normal } } = new THREE.TorusKnotGeometry(0.9, 0.32, 96, 12), arrays = [position, normal, index];
const binary = new Uint8Array(await new Blob(arrays.map(({ array }) => array)).arrayBuffer());
const views = arrays.map(({ array: { byteLength } }, k) => ({ buffer: 0, byteLength, byteOffset: k * position.array.byteLength }));
const mesh = await client.put(packGlb({
  asset: { version: '2.0' }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }], bufferViews: views, buffers: [{ byteLength: binary.length }],
  meshes: [{ primitives: [{ attributes: { POSITION: 0, NORMAL: 1 }, indices: 2, material: 0 }] }],
  materials: [{ pbrMetallicRoughness: { baseColorFactor: [0.32, 0.38, 0.4, 1], metallicFactor: 0, roughnessFactor: 0.7 } }],
  accessors: arrays.map(({ count }, bufferView) => ({ bufferView, count, componentType: bufferView < 2 ? 5126 : 5123, type: bufferView < 2 ? 'VEC3' : 'SCALAR' })),
}, binary));
const whole = await mesh.fracture({ ...look, sites: 8 });
const setup = { rapier: RAPIER, world, parent: scene, materials: await materialsOf(whole) };
let stone = place(whole, setup, { whole: true, position: [0, 2, 0] });
stone.rigidBodies[0].setGravityScale(0, true);  // it floats until a ball arrives
stone.rigidBodies[0].setAngvel({ x: 0.1, y: 0.7, z: 0 }, true);
const balls = [];
let asked = 0;

async function throwBall({ clientX, clientY }) {
  const pointer = new THREE.Vector2(2 * clientX / innerWidth - 1, 1 - 2 * clientY / innerHeight), ray = new THREE.Raycaster();
  ray.setFromCamera(pointer, camera);
  const { origin, direction } = ray.ray, velocity = direction.clone().multiplyScalar(14), [aim] = ray.intersectObjects(stone.meshes);
  const body = world.createRigidBody(RAPIER.RigidBodyDesc.dynamic().setTranslation(...origin).setLinvel(...velocity).setGravityScale(0).setCcdEnabled(true));
  const shape = new THREE.Mesh(new THREE.SphereGeometry(0.25), new THREE.MeshStandardMaterial({ color: 0xb3262e }));
  world.createCollider(RAPIER.ColliderDesc.ball(0.25).setDensity(4000), body);
  balls.push({ body, shape });
  scene.add(shape);
  if (!aim || asked++) return;
  stone.rigidBodies[0].setGravityScale(1, true);  // tossed up, so that it is back in place when the ball arrives
  stone.rigidBodies[0].setLinvel({ x: 0, y: 9.81 / 2 * aim.distance / 14, z: 0 }, true);
  const impact = stone.pointOf(aim.object.userData.fragment, aim.point.toArray());
  const answer = await mesh.fracture({ ...look, fragments, impacts: [impact] }, { realtime: true });
  performance.mark('answer');
  stone = swap(stone, answer, setup, { bonded: true });  // it stays together until the ball arrives
  performance.measure('swap', 'answer');
  stone.meshes.forEach(fragment => (fragment.castShadow = fragment.receiveShadow = true));
  says.textContent = `${answer.fragments.length} fragments, in ${Math.round(answer.head.timing.work)} ms`;
}
addEventListener('pointerdown', event => throwBall(event).catch(error => (says.textContent = error.detail ?? error)));

says.textContent = 'Click the stone.';
renderer.setAnimationLoop(() => {
  world.step(events);
  events.drainContactForceEvents(contact => stone.onContact(contact));
  stone.breakBonds();
  stone.update();
  for (const { body, shape } of balls) shape.position.copy(body.translation());
  renderer.render(scene, camera);
});
Object.defineProperty(globalThis, 'stone', { get: () => stone });  // for the console
