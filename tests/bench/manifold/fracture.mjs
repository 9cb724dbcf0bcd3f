// npm manifold-3d as a fracturer: for each site, hull(vertices of its Voronoi cell) ∩ mesh, on the workloads
// that `bench_fracture --out FOLDER` wrote, with one thread (WASM). The mesh is built once per run, which is
// timed; the cells cost it nothing.
//
//   npm ci && node fracture.mjs FOLDER [filter [runs]]
//
// Prints the milliseconds of both programs and their ratio, and checks that the peer's pieces have the
// solid's volume.
import {readFileSync, writeFileSync} from 'node:fs';
import {join} from 'node:path';
import Module from 'manifold-3d';

const [folder, filter = '', most = '3'] = process.argv.slice(2);
if (!folder) {
  console.error('usage: node fracture.mjs FOLDER [filter [runs]]');
  process.exit(2);
}

const wasm = await Module();
wasm.setup();
const {Manifold, Mesh} = wasm;

function load(path) {
  const bytes = readFileSync(path);
  const buffer = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength);
  const [vertices, triangles, sites, points] = new Uint32Array(buffer, 0, 4);
  let at = 16;
  const take = (Type, count) => {
    const array = new Type(buffer, at, count);
    at += array.byteLength;
    return array;
  };
  const coordinates = take(Float64Array, 3 * points);
  const positions = take(Float32Array, 3 * vertices);
  const indices = take(Uint32Array, 3 * triangles);
  const first = take(Uint32Array, sites + 1);
  const cells = [];
  for (let s = 0; s < sites; ++s) {
    const cell = [];
    for (let i = first[s]; i < first[s + 1]; ++i) cell.push([coordinates[3 * i], coordinates[3 * i + 1], coordinates[3 * i + 2]]);
    cells.push(cell);
  }
  return {positions, indices, cells};
}

function fracture({positions, indices, cells}) {
  const begin = performance.now();
  const solid = new Manifold(new Mesh({numProp: 3, vertProperties: positions, triVerts: indices}));
  let pieces = 0, volume = 0;
  for (const cell of cells) {
    const hull = Manifold.hull(cell);
    const piece = solid.intersect(hull);
    if (piece.numTri() > 0) {  // forces the evaluation
      ++pieces;
      volume += piece.volume();
    }
    piece.delete();
    hull.delete();
  }
  solid.delete();
  return {milliseconds: performance.now() - begin, pieces, volume};
}

const workloads = JSON.parse(readFileSync(join(folder, 'workloads.json'), 'utf8'));
const results = [];
let wrong = false;
for (const workload of workloads) {
  if (!`${workload.name}_${workload.sites}`.includes(filter)) continue;
  const input = load(join(folder, workload.file));
  const runs = [fracture(input)];
  while (runs.length < Number(most) && runs[0].milliseconds < 5000) runs.push(fracture(input));
  const best = Math.min(...runs.map((run) => run.milliseconds));
  const error = Math.abs(runs[0].volume / workload.volume - 1);
  wrong ||= error > 1e-4;
  results.push({...workload, manifold_milliseconds: best, manifold_pieces: runs[0].pieces, ratio: best / workload.milliseconds});
  console.log(`${workload.name.padEnd(10)} ${String(workload.sites).padStart(5)} sites: fracture ${workload.milliseconds.toFixed(2)} ms` +
              `, manifold-3d ${best.toFixed(1)} ms, ratio ${(best / workload.milliseconds).toFixed(1)}` +
              ` (${workload.fragments} / ${runs[0].pieces} pieces, peer's volume error ${error.toExponential(1)})`);
}
writeFileSync(join(folder, 'results.json'), JSON.stringify(results, null, 1) + '\n');
process.exit(wrong ? 1 : 0);
