// Common code of the judges: reading the files, and the verdict of a run. The reader is a few lines of our own, so that a judge's reader is
// never the only one. Exit codes: 0 if all files are good, 1 if a file has a fault, 77 if the judge is not installed.
import fs from 'node:fs';
import path from 'node:path';

const COMPONENTS = { SCALAR: 1, VEC2: 2, VEC3: 3, VEC4: 4 };
const ARRAYS = { 5123: Uint16Array, 5125: Uint32Array, 5126: Float32Array };

/** Imports the judge's packages. If a package is missing, the run ends as skipped. Any other failure is an error. */
export async function installed(load) {
  try {
    return await load();
  } catch (error) {
    if (!['ERR_MODULE_NOT_FOUND', 'MODULE_NOT_FOUND'].includes(error.code)) throw error;
    console.log(`skipped: the judge is not installed (npm ci in tests/judges): ${error.message.split('\n')[0]}`);
    process.exit(77);
  }
}

export function parse(bytes) {
  if (bytes[0] === 0x7b) {  // {
    const json = JSON.parse(new TextDecoder().decode(bytes));
    return { json, binary: Uint8Array.from(Buffer.from(json.buffers[0].uri.split(',')[1], 'base64')) };
  }
  const length = new DataView(bytes.buffer, bytes.byteOffset).getUint32(12, true);
  return { json: JSON.parse(new TextDecoder().decode(bytes.subarray(20, 20 + length))), binary: bytes.subarray(28 + length) };
}

export function accessor({ json, binary }, index) {
  const a = json.accessors[index], v = json.bufferViews[a.bufferView], Type = ARRAYS[a.componentType];
  const length = a.count * COMPONENTS[a.type], start = (v.byteOffset ?? 0) + (a.byteOffset ?? 0);
  return new Type(binary.slice(start, start + length * Type.BYTES_PER_ELEMENT).buffer);
}

/** The nodes that are fragments: no other node has an id in extras.fracture. */
export const fragmentsOf = json => json.nodes.filter(n => n.extras?.fracture?.id !== undefined);

/** Points (x, y, z, x, …) after a node's rotation and uniform scale, which only nodes of whole instances have. */
export function turned(points, { rotation = [0, 0, 0, 1], scale = [1, 1, 1] }) {
  const [x, y, z, w] = rotation;
  if (scale.some(s => s !== scale[0])) throw new Error('the scale of an instance is not uniform');
  return Float64Array.from(points).map((_, k, all) => {
    const [a, b, c] = all.subarray(k - k % 3, k - k % 3 + 3);
    return scale[0] * [(1 - 2 * (y * y + z * z)) * a + 2 * (x * y - w * z) * b + 2 * (x * z + w * y) * c,
      2 * (x * y + w * z) * a + (1 - 2 * (x * x + z * z)) * b + 2 * (y * z - w * x) * c,
      2 * (x * z - w * y) * a + 2 * (y * z + w * x) * b + (1 - 2 * (x * x + y * y)) * c][k % 3];
  });
}

/** The rotation by `b`, then by `a`. */
const product = ([x, y, z, w], [a, b, c, d]) =>
  [w * a + x * d + y * c - z * b, w * b - x * c + y * d + z * a, w * c + x * b - y * a + z * d, w * d - x * a - y * b - z * c];

/**
 * The rigid bodies of KHR_physics_rigid_bodies, as the extension specifies: motion, position, and the points of the convex hulls. The hulls
 * are those of the node's own collider or of its children's (compounds; their transforms must be the identity, which is checked). The node
 * of a whole instance is rotated and scaled; here its points and its motion are, too.
 */
export function bodiesOf(glb) {
  const { json } = glb, NAME = 'KHR_physics_rigid_bodies';
  return fragmentsOf(json).filter(n => n.extensions?.[NAME]).map(node => {
    const filters = new Set();
    const colliders = [node, ...(node.children ?? []).map(k => json.nodes[k])].flatMap(n => {
      const collider = n.extensions?.[NAME]?.collider;
      if (!collider) return [];
      if (n !== node && (n.translation || n.rotation || n.scale || n.matrix)) throw new Error(`${n.name} is not at the identity`);
      filters.add(collider.collisionFilter);
      if (collider.geometry.convexHull !== true) throw new Error(`${n.name}: not a convex hull`);
      return [collider];
    });
    const turns = node.rotation || node.scale, { motion } = node.extensions[NAME];
    const placed = points => turns ? Float32Array.from(turned(points, node)) : points;
    if (filters.size > 1) throw new Error(`${node.name}: several collision filters`);
    const hulls = colliders.map(({ geometry }) => {
      const { attributes, indices } = json.meshes[geometry.mesh].primitives[0];
      return { points: placed(accessor(glb, attributes.POSITION)), triangles: accessor(glb, indices) };
    });
    return { name: node.name, motion: turns ? { ...motion, centerOfMass: [...turned(motion.centerOfMass, node)],
      inertiaOrientation: product(node.rotation ?? [0, 0, 0, 1], motion.inertiaOrientation) } : motion, translation: node.translation ?? [0, 0, 0], hulls,
      material: json.extensions[NAME].physicsMaterials[colliders[0]?.physicsMaterial], filter: json.extensions[NAME].collisionFilters?.[[...filters][0]], fracture: node.extras.fracture };
  });
}

/** The same bodies in another unit of length, with `unit` of them in a metre. Masses keep their density. */
export const inUnits = (bodies, unit) => bodies.map(body => ({ ...body, translation: body.translation.map(x => x * unit),
  hulls: body.hulls.map(hull => ({ ...hull, points: hull.points.map(x => x * unit) })),
  motion: { ...body.motion, mass: body.motion.mass * unit ** 3, centerOfMass: body.motion.centerOfMass.map(x => x * unit),
    inertiaDiagonal: body.motion.inertiaDiagonal.map(x => x * unit ** 5) } }));

/** The tensor (xx yy zz xy xz yz) of principal moments in the frame of a unit quaternion. */
export function tensorOf(moments, [x, y, z, w]) {
  const axes = [[1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)],
    [2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)],
    [2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)]];
  return [[0, 0], [1, 1], [2, 2], [0, 1], [0, 2], [1, 2]].map(([i, j]) => moments.reduce((sum, m, k) => sum + m * axes[k][i] * axes[k][j], 0));
}

/** Compares the engine's {mass, centerOfMass, inertiaDiagonal, inertiaOrientation} with the file's, to 1e-5. */
export function massComplaints(body, read, size) {
  const complaints = [], { mass, centerOfMass, inertiaDiagonal, inertiaOrientation } = body.motion;
  const off = (what, a, b, tolerance) => Math.abs(a - b) <= tolerance || complaints.push(`${body.name}: ${what} ${a} in the engine, ${b} in the file`);
  off('mass', read.mass, mass, 1e-5 * mass);
  centerOfMass.forEach((c, k) => off('centre', read.centerOfMass[k], c, 1e-5 * size));
  const theirs = tensorOf(read.inertiaDiagonal, read.inertiaOrientation), trace = inertiaDiagonal[0] + inertiaDiagonal[1] + inertiaDiagonal[2];
  tensorOf(inertiaDiagonal, inertiaOrientation).forEach((m, k) => off('inertia', theirs[k], m, 1e-5 * trace));
  return complaints;
}

/** Whether the filter of one body lets it collide with the other, as the extension defines it. It must hold both ways. */
const lets = (a, b) => !a.filter?.notCollideWithSystems?.length || !(b.filter?.collisionSystems ?? []).length ||
  !b.filter.collisionSystems.every(system => a.filter.notCollideWithSystems.includes(system));
export const collide = (a, b) => lets(a, b) && lets(b, a);

/** Runs `judge(bytes, file)`, which returns {note, complaints}, over the files of the command line. */
export async function judgeAll(judge) {
  const files = process.argv.slice(2);
  let bad = 0;
  for (const file of files) {
    const { note, complaints } = await judge(Uint8Array.from(fs.readFileSync(file)), file);
    console.log(`${complaints.length ? 'BAD ' : 'good'} ${path.basename(file)}: ${note}`);
    for (const complaint of complaints.slice(0, 20)) console.log(`     ${complaint}`);
    bad += complaints.length > 0;
  }
  if (!files.length) console.log('no files to judge');
  process.exit(bad || !files.length ? 1 : 0);
}
