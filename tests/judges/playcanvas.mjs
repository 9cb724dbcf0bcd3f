// PlayCanvas must load the file with every fragment in the scene: name, id, place, triangles. It runs without a graphics
// card or a browser, on its null device. pictures.mjs decodes the textures.   usage: node playcanvas.mjs FILE.glb …
import { fragmentsOf, installed, judgeAll, parse } from './files.mjs';

const pc = await installed(() => import('playcanvas'));
const canvas = { width: 1, height: 1, clientWidth: 1, clientHeight: 1, addEventListener: () => {}, removeEventListener: () => {},
  getBoundingClientRect: () => ({ width: 1, height: 1 }) };
const app = new pc.AppBase(canvas), device = new pc.NullGraphicsDevice(canvas);
app.init(Object.assign(new pc.AppOptions(), { graphicsDevice: device, componentSystems: [pc.RenderComponentSystem],
  resourceHandlers: [pc.ContainerHandler, pc.RenderHandler, pc.TextureHandler] }));
/** A replacement for an image. */
function noImage(_, done) {
  const asset = new pc.Asset('image', 'texture');
  asset.resource = new pc.Texture(device, { width: 1, height: 1 });
  asset.loaded = true;
  done(null, asset);
}

await judgeAll(async bytes => {
  const complaints = [], { json } = parse(bytes), extras = new Map();
  const kind = bytes[0] === 0x7b ? 'gltf' : 'glb', file = { url: `file.${kind}`, filename: `file.${kind}`, contents: bytes.buffer };
  const asset = new pc.Asset('file', 'container', file, null, { image: { processAsync: noImage },
    node: { postprocess: ({ extras: { fracture } = {} }, entity) => extras.set(entity.name, fracture) } });  // PlayCanvas itself does not keep extras
  await new Promise((resolve, reject) => {
    asset.on('load', resolve).on('error', message => reject(new Error(message)));
    app.assets.add(asset);
    app.assets.load(asset);
  });
  const root = asset.resource.instantiateRenderEntity();
  let triangles = 0;
  for (const node of fragmentsOf(json)) {
    const entity = root.findByName(node.name);
    if (!entity) {
      complaints.push(`${node.name} is missing`);
      continue;
    }
    if (extras.get(node.name)?.id !== node.extras.fracture.id) complaints.push(`${node.name} has lost its id`);
    const { x, y, z } = entity.getPosition(), place = node.translation ?? [0, 0, 0];
    if ([x, y, z].some((value, k) => Math.abs(value - place[k]) > 1e-6 * Math.max(1, Math.abs(place[k])))) complaints.push(`${node.name} stands at ${x} ${y} ${z}`);
    const stated = json.meshes[node.mesh].primitives.map(({ indices }) => json.accessors[indices].count);
    const drawn = entity.render?.meshInstances.map(({ mesh }) => mesh.primitive[0].count) ?? [];
    if (drawn.join() !== stated.join()) complaints.push(`${node.name}: ${drawn} indices for ${stated}`);
    triangles += drawn.reduce((sum, count) => sum + count, 0) / 3;
  }
  if (![...extras.values()].some(fracture => fracture?.bonds)) complaints.push('the root has lost extras.fracture');
  root.destroy();
  asset.unload();
  return { note: `${fragmentsOf(json).length} fragments, ${triangles} triangles`, complaints };
});
