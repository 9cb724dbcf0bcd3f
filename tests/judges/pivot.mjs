// pivot=source: in the engine, the fragments have to be where the engine has the source, whose nodes are moved, turned and
// scaled. The unbroken mesh (intact=true) has to be there too, in a scene of its own.   usage: node pivot.mjs SAMPLES FOLDER
import fs from 'node:fs';
import path from 'node:path';
import { installed } from './files.mjs';

globalThis.self = globalThis;
globalThis.ProgressEvent ??= class extends Event {};
const THREE = await installed(() => import('three'));
const { GLTFLoader } = await installed(() => import('three/addons/loaders/GLTFLoader.js'));
await installed(() => import('@babylonjs/loaders/glTF/2.0/index.js'));
const core = file => installed(() => import(`@babylonjs/core/${file}.js`));
const { NullEngine } = await core('Engines/nullEngine'), { Scene } = await core('scene');
const { LoadAssetContainerAsync } = await core('Loading/sceneLoader');
const { Vector3 } = await core('Maths/math.vector');

/** World positions of all vertices that three.js has in a scene of the file. */
async function three(bytes, scene) {
  const gltf = await new Promise((resolve, reject) => new GLTFLoader().parse(bytes.buffer, '', resolve, reject)), points = [];
  gltf.scenes[scene].updateMatrixWorld(true);
  gltf.scenes[scene].traverse(object => {
    const positions = object.geometry?.attributes.position;
    for (let k = 0; k < (positions?.count ?? 0); ++k)
      points.push(new THREE.Vector3().fromBufferAttribute(positions, k).applyMatrix4(object.matrixWorld).toArray());
  });
  return points;
}

/** World positions of all vertices that Babylon shows, which is the default scene. */
async function babylon(bytes) {
  const engine = new NullEngine(), scene = new Scene(engine), points = [];
  scene.useRightHandedSystem = true;
  const container = await LoadAssetContainerAsync(bytes, scene, { pluginExtension: '.glb', pluginOptions: { gltf: { skipMaterials: true } } });
  container.addAllToScene();
  for (const mesh of container.meshes) {
    const positions = mesh.getVerticesData('position') ?? [], world = mesh.computeWorldMatrix(true);
    for (let k = 0; k < positions.length; k += 3)
      points.push(Vector3.TransformCoordinates(new Vector3(...positions.slice(k, k + 3)), world).asArray());
  }
  const hasIntact = container.getNodes().some(node => node.name === 'Intact');
  engine.dispose();
  return { points, hasIntact };
}

const folder = process.argv[3], read = name => Uint8Array.from(fs.readFileSync(path.join(folder, name)));
const source = read('source.glb'), fragments = read('fragments.glb');
let bad = 0;
const complain = text => (console.log(`BAD  ${text}`), ++bad);

/** Each of `wanted` is in `found`, and nothing in `found` is outside the box of `wanted`. */
function compare(name, wanted, found) {
  const size = Math.max(...[0, 1, 2].map(a => Math.max(...wanted.map(p => p[a])) - Math.min(...wanted.map(p => p[a])))), near = 1e-6 * size;
  const far = wanted.filter(p => !found.some(q => q.every((x, a) => Math.abs(x - p[a]) <= near)));
  const beyond = found.filter(q => q.some((x, a) => x < Math.min(...wanted.map(p => p[a])) - near || x > Math.max(...wanted.map(p => p[a])) + near));
  if (!wanted.length || far.length || beyond.length) complain(`${name}: ${far.length} of ${wanted.length} corners are missing, ${beyond.length} of ${found.length} points are outside`);
  else console.log(`good ${name}: ${wanted.length} corners among ${found.length} points`);
}

compare('three.js, fragments', await three(source, 0), await three(fragments, 0));
compare('three.js, intact', await three(source, 0), await three(fragments, 1));
const shown = await babylon(fragments);
compare('Babylon, fragments', (await babylon(source)).points, shown.points);
if (shown.hasIntact) complain('Babylon shows the unbroken mesh next to the fragments');
process.exit(bad ? 1 : 0);
