// manifold-3d's own reader of EXT_mesh_manifold (lib/gltf-io.js, on glTF-Transform) must find the extension on every
// fragment. The Manifold kernel must accept every mesh as that reader returns it. No vertices are welded here.
//   usage: node manifold_reader.mjs FILE.glb …
import { fragmentsOf, installed, judgeAll, parse } from './files.mjs';

const { WebIO } = await installed(() => import('@gltf-transform/core'));
const { readMesh, setupIO } = await installed(() => import('manifold-3d/lib/gltf-io.js'));
const manifold = await (await installed(() => import('manifold-3d'))).default();
manifold.setup();

await judgeAll(async bytes => {
  const complaints = [], io = setupIO(new WebIO());
  const document = bytes[0] === 0x7b ? await io.readJSON({ json: JSON.parse(new TextDecoder().decode(bytes)), resources: {} })
                                     : await io.readBinary(bytes);
  let merges = 0;
  const fragments = document.getRoot().listNodes().filter(n => n.getExtras().fracture?.id !== undefined);
  if (!fragments.length || fragments.length !== fragmentsOf(parse(bytes).json).length) complaints.push(`${fragments.length} fragments`);
  for (const node of fragments) {
    if (!node.getMesh().getExtension('EXT_mesh_manifold')) {
      complaints.push(`${node.getName()}: no EXT_mesh_manifold`);
      continue;
    }
    const { mesh } = readMesh(node.getMesh(), ['POSITION']);
    merges += mesh.mergeFromVert.length;
    // A reader that only follows the accessors gets the merged corners themselves.
    const merged = node.getMesh().getExtension('EXT_mesh_manifold').getIndices().getArray(), to = new Map();
    mesh.mergeFromVert.forEach((from, k) => to.set(from, mesh.mergeToVert[k]));
    if (merged.length !== mesh.triVerts.length || mesh.triVerts.some((v, k) => (to.get(v) ?? v) !== merged[k]))
      complaints.push(`${node.getName()}: the manifold primitive is not the primitives with the merges applied`);
    try {
      const solid = new manifold.Manifold(new manifold.Mesh(mesh));
      const status = solid.status();
      if (String(status?.value ?? status) !== 'NoError') complaints.push(`${node.getName()}: Manifold says ${status?.value ?? status}`);
      solid.delete();
    } catch (error) {
      complaints.push(`${node.getName()}: Manifold says ${error.code ?? error.message}`);
    }
  }
  return { note: `${fragments.length} fragments, ${merges} merged vertices`, complaints };
});
