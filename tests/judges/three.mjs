// three.js GLTFLoader must load the file with every fragment in the scene: name, id, triangles, place, materials.
// pictures.mjs decodes the textures in a browser.   usage: node three.mjs FILE.glb …
import { fragmentsOf, installed, judgeAll, parse } from './files.mjs';

// The parts of a browser that the loader expects.
globalThis.self = globalThis;
globalThis.ProgressEvent ??= class extends Event {};
const THREE = await installed(() => import('three'));
const { GLTFLoader } = await installed(() => import('three/addons/loaders/GLTFLoader.js'));

await judgeAll(async bytes => {
  const complaints = [], { json } = parse(bytes), loader = new GLTFLoader();
  loader.register(() => ({ name: 'skip_textures', loadTexture: () => Promise.resolve(new THREE.Texture()) }));
  const warn = console.warn, seen = [];
  console.warn = (...message) => seen.push(message.join(' '));
  const data = bytes[0] === 0x7b ? new TextDecoder().decode(bytes) : bytes.buffer;
  const gltf = await new Promise((resolve, reject) => loader.parse(data, '', resolve, reject));
  console.warn = warn;
  for (const message of seen) complaints.push(`three.js warns: ${message}`);
  gltf.scene.updateMatrixWorld(true);

  const loaded = new Map();
  gltf.scene.traverse(object => object.userData.fracture?.id !== undefined && loaded.set(object.userData.fracture.id, object));
  let triangles = 0;
  for (const node of fragmentsOf(json)) {
    const object = loaded.get(node.extras.fracture.id);
    if (!object) {
      complaints.push(`${node.name} is missing`);
      continue;
    }
    if (object.name !== node.name) complaints.push(`${node.name} is called ${object.name}`);
    const place = object.getWorldPosition(new THREE.Vector3()).toArray();
    if (place.some((x, k) => x !== (node.translation?.[k] ?? 0))) complaints.push(`${node.name} stands at ${place}`);
    // A mesh of several primitives becomes a group of meshes. Colliders and hulls are separate children.
    const primitives = object.isMesh ? [object] : object.children.filter(c => c.isMesh && !json.nodes.some(n => n.name === c.name));
    const stated = json.meshes[node.mesh].primitives;
    if (primitives.length !== stated.length) complaints.push(`${node.name}: ${primitives.length} primitives`);
    primitives.forEach((mesh, k) => {
      const count = json.accessors[stated[k].indices].count;
      triangles += mesh.geometry.index.count / 3;
      if (mesh.geometry.index.count !== count) complaints.push(`${node.name}: ${mesh.geometry.index.count} indices for ${count}`);
      const name = json.materials[stated[k].material]?.name ?? '';
      if (mesh.material.name !== name) complaints.push(`${node.name}: material ${mesh.material.name} for ${name}`);
    });
  }
  if (!gltf.scene.children[0]?.userData.fracture?.bonds) complaints.push('the root has lost extras.fracture');
  return { note: `${loaded.size} fragments, ${triangles} triangles`, complaints };
});
