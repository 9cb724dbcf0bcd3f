// Judges files of this project with programs written elsewhere.   usage: node judge.mjs FILE.glb …
// 1. The Khronos validator must report no error and no warning.
// 2. Manifold must accept every fragment (vertices merged if their positions are identical, no other change). Its volume is
//    not compared, because it repairs surfaces that cross themselves. The volume of the stored triangles must equal the
//    stated one, up to the rounding of positions (half a step of the lattice, and of the local floats) times the area.
// 3. Each interior triangle must have its mirror image, bit for bit in world space, in another fragment. The exception: the
//    report says that holes of the source were filled (those faces have interior material without a partner).
// 4. Fragment ids and node names must be unique, and bonds must name existing fragments.
import { createRequire } from 'node:module';
import { accessor, fragmentsOf, installed, judgeAll, parse } from './files.mjs';

const validator = await installed(() => createRequire(import.meta.url)('gltf-validator'));
const manifold = await (await installed(() => import('manifold-3d'))).default();
manifold.setup();

/** Maps each vertex to the first vertex at the identical position. */
function weld(positions) {
  const first = new Map();
  return Uint32Array.from({ length: positions.length / 3 }, (_, i) => {
    const key = `${positions[3 * i]},${positions[3 * i + 1]},${positions[3 * i + 2]}`;
    if (!first.has(key)) first.set(key, i);
    return first.get(key);
  });
}

/** Returns Manifold's answer: 'NoError' or the name of the error. */
function askManifold(positions, triangles) {
  const to = weld(positions), merged = [...to.keys()].filter(i => to[i] !== i);
  const mesh = new manifold.Mesh({ numProp: 3, vertProperties: positions, triVerts: triangles,
    mergeFromVert: Uint32Array.from(merged), mergeToVert: Uint32Array.from(merged, i => to[i]) });
  let solid;
  try {
    solid = new manifold.Manifold(mesh);
    const status = solid.status();
    return String(status?.value ?? status);
  } catch (error) {
    return error.code ?? error.message ?? String(error);
  } finally {
    solid?.delete?.();
  }
}

/** The signed volume by the divergence theorem, about the first vertex. */
function signedVolume(p, triangles) {
  const at = i => [p[3 * i] - p[0], p[3 * i + 1] - p[1], p[3 * i + 2] - p[2]];
  let sum = 0;
  for (let t = 0; t < triangles.length; t += 3) {
    const [a, b, c] = [at(triangles[t]), at(triangles[t + 1]), at(triangles[t + 2])];
    sum += a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
  }
  return sum / 6;
}

await judgeAll(async bytes => {
  const complaints = [];
  const { issues } = await validator.validateBytes(bytes, { maxIssues: 0 });
  for (const m of issues.messages.filter(m => m.severity < 2).slice(0, 5)) complaints.push(`${m.code} at ${m.pointer}: ${m.message}`);
  if (issues.numErrors || issues.numWarnings) complaints.push(`validator: ${issues.numErrors} errors, ${issues.numWarnings} warnings`);

  const glb = parse(bytes), { json } = glb, fragments = fragmentsOf(json);
  const root = json.nodes.map(n => n.extras?.fracture).find(f => f?.bonds);
  const unpaired = new Map();
  for (const node of fragments) {
    const { primitives } = json.meshes[node.mesh], stated = node.extras.fracture.volume / (node.scale?.[0] ?? 1) ** 3;
    const positions = accessor(glb, primitives[0].attributes.POSITION), triangles = [];
    for (const primitive of primitives) {
      const indices = accessor(glb, primitive.indices);
      for (const index of indices) triangles.push(index);
      if (!/interior/i.test(json.materials?.[primitive.material]?.name ?? '')) continue;
      const world = i => [0, 1, 2].map(k => Math.fround(positions[3 * i + k] + (node.translation?.[k] ?? 0))).join();
      for (let t = 0; t < indices.length; t += 3) {
        const corners = [world(indices[t]), world(indices[t + 1]), world(indices[t + 2])];
        const at = corners.indexOf([...corners].sort()[0]), turn = k => corners[(at + k) % 3];
        const mine = `${turn(0)};${turn(1)};${turn(2)}`, mirrored = `${turn(0)};${turn(2)};${turn(1)}`;
        if (unpaired.get(mirrored) > 0) unpaired.set(mirrored, unpaired.get(mirrored) - 1);
        else unpaired.set(mine, (unpaired.get(mine) ?? 0) + 1);
      }
    }
    const status = askManifold(positions, Uint32Array.from(triangles));
    if (status !== 'NoError') complaints.push(`${node.name}: Manifold says ${status}`);
    const volume = signedVolume(positions, triangles), size = positions.reduce((most, x) => Math.max(most, Math.abs(x)), 0);
    const rounding = (Math.max(...root.lattice.step) + size * 2 ** -23) * node.extras.fracture.area;
    if (!(volume > 0)) complaints.push(`${node.name}: volume ${volume}`);
    if (!(Math.abs(volume - stated) <= 1e-9 * stated + rounding)) complaints.push(`${node.name}: volume ${volume}, stated ${stated}`);
  }
  const filled = root?.report?.solid?.fill_triangles ?? root?.report?.fill_triangles ?? 0;
  const alone = [...unpaired.values()].reduce((sum, n) => sum + n, 0);
  if (alone && !filled) complaints.push(`${alone} interior triangles without their mirror image`);

  const ids = new Set(fragments.map(n => n.extras.fracture.id)), names = new Set(json.nodes.map(n => n.name));
  if (!fragments.length) complaints.push('no fragments');
  if (ids.size !== fragments.length) complaints.push('fragment ids are not unique');
  if (names.size !== json.nodes.length) complaints.push('node names are not unique');
  if (![...root.bonds.a, ...root.bonds.b].every(id => ids.has(id))) complaints.push('a bond names a fragment that does not exist');
  return { note: `${fragments.length} fragments`, complaints };
});
