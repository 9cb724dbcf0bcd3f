// Runs in the browser. Loads the source and the fragments of each pair with three.js and renders both from four sides. Posts the pictures
// and the counts back to pictures.mjs.
import * as THREE from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { DRACOLoader } from 'three/addons/loaders/DRACOLoader.js';
import { MeshoptDecoder } from 'three/addons/libs/meshopt_decoder.module.js';
import { RoomEnvironment } from 'three/addons/environments/RoomEnvironment.js';

const SIZE = 512;
const SIDES = { front: [0, 0, 1], right: [1, 0, 0], back: [0, 0, -1], left: [-1, 0, 0] };
// For each side, another side of the source. The comparison must find the two different.
const CONTROL = { front: 'right', right: 'front', back: 'left', left: 'back' };
const renderer = new THREE.WebGLRenderer({ antialias: false, preserveDrawingBuffer: true });
renderer.setSize(SIZE, SIZE);
const room = new THREE.PMREMGenerator(renderer).fromScene(new RoomEnvironment()).texture;

const loader = new GLTFLoader().setMeshoptDecoder(MeshoptDecoder)
  .setDRACOLoader(new DRACOLoader().setDecoderPath('/three/examples/jsm/libs/draco/'));

const post = (path, body) => fetch(path, { method: 'POST', body });

/** The loaded asset and its textures: their number in the file, and the sizes of the decoded ones. */
async function load(url) {
  const gltf = await loader.loadAsync(url), { parser } = gltf;
  const textures = await Promise.all((parser.json.textures ?? []).map((_, k) => parser.getDependency('texture', k)));
  // Skins stay in the pose of the joints' nodes, without animation. That is the pose that the importer bakes.
  const decoded = textures.filter(t => t?.image?.width > 0).map(t => `${t.image.width}x${t.image.height}`);
  const used = new Set();
  gltf.scene.traverse(object => object.isMesh && used.add(object.material.name));
  return { scene: gltf.scene, counts: { textures: textures.length, decoded, images: (parser.json.images ?? []).length,
    materials: (parser.json.materials ?? []).length,
    interiors: (parser.json.nodes ?? []).flatMap(node => node.extras?.fracture?.interior_materials ?? []).length, used: [...used].sort() } };
}

function render(object, box, side) {
  const scene = new THREE.Scene(), radius = box.getSize(new THREE.Vector3()).length() / 2;
  scene.environment = room;
  scene.add(object);
  const center = box.getCenter(new THREE.Vector3());
  const camera = new THREE.OrthographicCamera(-radius, radius, radius, -radius, 0.1 * radius, 4 * radius);
  camera.position.copy(center).addScaledVector(new THREE.Vector3(...SIDES[side]), 2 * radius);
  camera.lookAt(center);
  renderer.setClearColor(0x000000, 0);
  renderer.render(scene, camera);
  const gl = renderer.getContext(), pixels = new Uint8Array(4 * SIZE * SIZE);
  gl.readPixels(0, 0, SIZE, SIZE, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  return pixels;
}

const picture = () => new Promise(resolve => renderer.domElement.toBlob(resolve));

/** The mean absolute difference of each channel (0 to 1), over the whole picture and over the pixels that either object covers. */
function compare(a, b) {
  const sum = [0, 0, 0, 0];
  let covered = 0, far = 0;
  for (let p = 0; p < a.length; p += 4) {
    covered += a[p + 3] > 0 || b[p + 3] > 0;
    far += [0, 1, 2].some(k => Math.abs(a[p + k] - b[p + k]) > 25);
    for (let k = 0; k < 4; ++k) sum[k] += Math.abs(a[p + k] - b[p + k]) / 255;
  }
  return { picture: sum.map(s => s / (SIZE * SIZE)), object: sum.map(s => s / covered), covered: covered / (SIZE * SIZE), far: far / covered };
}

try {
  const pairs = await (await fetch('/pairs.json')).json();
  for (const { name, source, ours, pictures } of pairs) {
    const before = await load(source), after = await load(ours), sides = {};
    if (pictures) {
      before.scene.updateMatrixWorld(true);
      after.scene.updateMatrixWorld(true);
      // The source's visible extent in its pose. The fragments must have the same extent.
      const box = new THREE.Box3().setFromObject(before.scene, true), other = new THREE.Box3().setFromObject(after.scene, true);
      sides.boxes = { source: [box.min.toArray(), box.max.toArray()], ours: [other.min.toArray(), other.max.toArray()] };
      for (const side of Object.keys(SIDES)) {
        const a = render(before.scene, box, side);
        await post(`/picture/${name}_${side}_source.png`, await picture());
        const b = render(after.scene, box, side);
        await post(`/picture/${name}_${side}_fragments.png`, await picture());
        sides[side] = { ...compare(a, b), control: compare(render(before.scene, box, CONTROL[side]), b).object };
      }
    }
    await post('/result', JSON.stringify({ name, sides, source: before.counts, ours: after.counts }));
  }
  await post('/done', '');
} catch (error) {
  await post('/failed', String(error.stack ?? error));
}
