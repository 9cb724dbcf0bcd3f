// Tests against fracture-server itself (FRACTURE_TEST_SERVER).
import assert from 'node:assert/strict';
import fs from 'node:fs';
import os from 'node:os';
import path from 'node:path';
import { before, describe, test } from 'node:test';
import { Admin } from '../../../client/typescript/dist/index.js';
import { Client, Glb, house, noServer, png, realServer, refusal, torus, torusFile } from './support.mjs';

describe('the service', { skip: noServer }, () => {
  let server, client, mesh, answer;
  before(async () => {
    server = await realServer();
    client = new Client(server.url);
    mesh = await client.put(torusFile, { parameters: { material: 'stone' } });
    answer = await mesh.fracture({ material: 'stone', fragments: 24, seed: 7 });
  });

  test('fragments are plain values and views of the file', () => {
    const { fragments, certificate, bonds, glb } = answer, sum = values => values.reduce((a, b) => a + b, 0);
    assert.equal(fragments.length, certificate.fragments);
    assert.ok(Math.abs(sum(fragments.map(({ volume }) => volume)) - certificate.volume_in) < 1e-9 * certificate.volume_in);
    assert.equal(new Set(fragments.map(({ id }) => id)).size, fragments.length);
    for (const fragment of fragments) {
      for (const view of [fragment.positions, fragment.uvs, fragment.triangles, ...fragment.hulls.flatMap(hull => [hull.positions, hull.triangles])])
        assert.equal(view.buffer, glb.buffer, `a copy in ${fragment.name}`);
      assert.ok(fragment.hulls.length >= 1 && fragment.motion.mass === fragment.mass && !fragment.anchored);
      assert.equal(fragment.triangles.length, sum(fragment.primitives.map(({ triangles }) => triangles.length)));
      assert.deepEqual(fragment.primitives.map(({ interior }) => interior).at(-1), true);
      assert.ok(Math.abs(volumeOf(fragment) - fragment.volume) < 1e-5 * fragment.volume + 1e-9, fragment.name);
      assert.equal(answer.fragment(fragment.id), fragment);
    }
    for (const { a, b, area, strength, normal } of bonds)
      assert.ok(answer.fragment(a) && answer.fragment(b) && area > 0 && strength > 0 && Math.abs(Math.hypot(...normal) - 1) < 1e-6);
    assert.ok(answer.head.timing.work >= 0 && answer.location.startsWith('/fractures/sha256:') && answer.report.solid);
  });

  test('the same request gives the same bytes, also by address, form, figures and job', async () => {
    const asked = { material: 'stone', fragments: 24, seed: 7 }, bytes = Buffer.from(answer.glb);
    assert.ok(bytes.equals((await mesh.fracture(asked, { realtime: true })).glb));
    assert.ok(bytes.equals((await client.fracture(torusFile, asked)).glb));
    assert.ok(bytes.equals((await client.answer(answer.location)).glb));
    assert.deepEqual(await mesh.figures(asked), answer.figures);
    assert.equal(JSON.parse(await mesh.gltf(asked)).nodes.length, answer.document.json.nodes.length);
    const job = await mesh.job(asked), percents = [];
    assert.ok(bytes.equals((await job.result({ onProgress: ({ percent }) => percents.push(percent) })).glb));
    assert.equal(percents.at(-1), 100);
    assert.equal((await client.job(job.id)).state, 'done');
    const listed = [];
    for await (const { id } of client.jobs({ limit: 1, state: 'done' })) listed.push(id);
    assert.ok(listed.includes(job.id));
    await job.cancel();
    assert.equal((await refusal(client.job(job.id))).problem, 'not-found');
  });

  test('a job is cancelled', async () => {
    const job = await mesh.job({ sites: 20000, lloyd: 50 });
    let asked = false;
    for await (const { state } of job.progress()) {
      if (state !== 'running' || asked) continue;
      asked = true;  // only once: a second cancellation could arrive when the job has stopped, and would make the server forget it
      await job.cancel();
    }
    assert.equal((await refusal(job.result())).problem, 'cancelled');
  });

  test('compressed answers are the same', async () => {
    const packed = await new Client(server.url, { compressed: true }).mesh(mesh.id).fracture({ material: 'stone', fragments: 24, seed: 7 });
    assert.match(packed.head.etag, /\.(gzip|zstd)"$/);
    assert.ok(Buffer.from(answer.glb).equals(packed.glb));
  });

  test('discovery', async () => {
    const [patterns, limits, openapi, version, index] =
      await Promise.all([client.patterns(), client.limits(), client.openapi(), client.version(), client.index()]);
    assert.ok(patterns.materials.some(({ name }) => name === 'stone') && patterns.patterns.some(({ name }) => name === 'radial'));
    assert.ok(limits.formats.includes('glb') && limits.parameters.some(({ name }) => name === 'fragments'));
    assert.deepEqual([openapi.openapi, version.name, index.links.limits], ['3.1.0', 'fracture-server', '/limits']);
    assert.match(await client.explain('mesh-not-closed'), /volume/);
    assert.match(new TextDecoder().decode((await client.request('getLlms')).bytes), /POST \/fracture/);
    const report = (await client.inspect(torusFile)).report;
    assert.deepEqual([report.verdict, report.solid.parts], ['closed', 1]);
    const admin = new Admin(server.admin);
    assert.deepEqual([await admin.live(), await admin.ready(), /fracture_/.test(await admin.metrics())], [true, true, true]);
  });

  test('the server\'s refusals', async () => {
    const misspelt = await refusal(mesh.fracture({ sitess: 3 }));
    assert.deepEqual([misspelt.problem, misspelt.parameter, misspelt.status], ['unknown-parameter', 'sitess', 400]);
    assert.match(misspelt.detail, /sites/);
    assert.equal((await refusal(client.put(Buffer.from('no mesh at all')))).problem, 'unknown-format');
    assert.equal((await refusal(client.put(Buffer.from('no mesh at all'), { format: 'obj' }))).status, 422);
    assert.equal((await refusal(client.mesh(`sha256:${'0'.repeat(64)}`).fracture())).problem, 'not-found');
    assert.equal((await refusal(client.answer(`/fractures/sha256:${'0'.repeat(64)}`))).problem, 'not-found');
    assert.equal((await refusal(mesh.fracture({ fragment: 12345 }))).problem, 'no-such-fragment');
    assert.equal((await refusal(mesh.fracture({ sites: 20000 }, { timeout: 5, retries: 0 }))).problem.length > 0, true);
  });

  test('an estimate is near what is made', async () => {
    const parameters = { material: 'stone', fragments: 24 }, said = await mesh.estimate(parameters), { glb } = await mesh.fracture(parameters);
    assert.deepEqual([said.fits, said.fragments, said.advice], [true, 24, null]);
    assert.ok(said.bytes < 2 * glb.length && glb.length < 2 * said.bytes, `${said.bytes} of ${glb.length}`);
    assert.equal((await refusal(mesh.estimate({ sites: 0 }))).problem, 'bad-parameter');
  });

  test('an implausible size is a choice', async () => {
    const text = torus({ radius: 1000, tube: 400 });
    const large = await client.put([{ name: 'large.obj', data: Buffer.from(text) }]), [choice] = large.choices;
    assert.deepEqual([choice.kind, choice.parameters], ['unit', { unit: 'mm' }]);
    const made = await large.fracture({ sites: 2 });
    assert.deepEqual(made.choices, large.choices);
    assert.deepEqual((await large.fracture({ sites: 2, ...choice.parameters })).choices, []);
  });

  test('OBJ with its MTL and texture, under names that are not ASCII', async () => {
    const mtl = 'newmtl skin\nKd 1 1 1\nmap_Kd bäume/rinde.png\n';
    const files = [{ name: 'türe.obj', data: Buffer.from(torus({ material: 'türe.mtl' })) }, { name: 'türe.mtl', data: Buffer.from(mtl) },
      { name: 'bäume/rinde.png', data: png }, { name: 'a.txt', data: Buffer.from('nothing') }];
    const put = await client.put(files), made = await put.fracture({ sites: 5 });
    assert.deepEqual([put.stored.files, put.report.images, put.report.warnings?.length ?? 0], [3, 1, 0]);
    assert.equal(made.document.json.images.length, 1);
    assert.ok(Buffer.from(made.document.image(0).bytes).includes('IDAT'));
    await put.delete();
    assert.equal((await put.fracture({ sites: 6 })).head.exchanges, 2);
  });

  test('glTF with its buffer', async () => {
    const { json, binary } = answer.document, files = [
      { name: 'set/all.gltf', data: Buffer.from(JSON.stringify({ ...json, buffers: [{ byteLength: binary.length, uri: 'geometry/all.bin' }] })) },
      { name: 'set/geometry/all.bin', data: Buffer.from(binary) },
    ];
    const put = await client.put(files);
    assert.equal(put.stored.files, 1);
    assert.ok(Math.abs(put.report.solid.volume - answer.certificate.volume_in) < 1e-6);
    assert.equal((await client.put(files)).id, put.id);
  });

  test('many points go with the mesh', async () => {
    const points = Float32Array.from({ length: 600 }, (_, k) => Math.sin(k));
    const made = await mesh.fracture({ pattern: 'points', points: Array.from({ length: 200 }, (_, k) => [...points.subarray(3 * k, 3 * k + 3)]) });
    assert.equal(made.parameters.points.length, 200);
  });

  test('a fragment is fractured again', async () => {
    const { id, volume } = answer.fragments[3], parts = await answer.refracture(id, { sites: 6, seed: 2 });
    assert.ok(Math.abs(parts.certificate.volume_out - volume) < 1e-5 * volume, `${parts.certificate.volume_out}, ${volume}`);
    assert.equal((await refusal(parts.hit([1, 0, 0], 0.1))).status, 400);
  });

  // -- hits: a merged delta must equal the whole answer that the service gives with delta=stated

  const equal = (ours, theirs) => {
    assert.deepEqual(ours.document.json, theirs.document.json);
    assert.ok(Buffer.from(ours.document.binary).equals(Buffer.from(theirs.document.binary)), 'the buffers differ');
  };
  const CASES = [
    ['stone', { material: 'stone', fragments: 24, seed: 7 }], ['flat cuts', { sites: 30 }], ['wood, which is rough', { material: 'wood', fragments: 20 }],
    ['glass, whose walls are hollow', { material: 'glass', fragments: 20 }], ['physics=omi', { sites: 20, physics: 'omi' }],
    ['physics=none with hulls for Unreal', { sites: 20, physics: 'none', ue_collision: 'ucx', pivot: 'source' }],
    ['anchors: the whole is asked for', { sites: 20, anchor_plane: [[0, -0.39, 0], [0, 1, 0]] }],
    ['levels: the whole is asked for', { levels: [4, 20] }],
    ['maps of the cuts: the whole is asked for', { material: 'wood', fragments: 20, interior_detail: 'wood' }],
  ];
  for (const [name, parameters] of CASES) test(`a hit makes the whole: ${name}`, async () => {
    let sent = 0;
    const counting = new Client(server.url, { fetch: (...given) => (++sent, fetch(...given)) }).mesh(mesh.id);
    const first = await counting.fracture(parameters);
    sent = 0;
    const hit = await first.hit([1.3, 0.1, 0], 0.3, { sites: 6 });
    assert.equal(sent, 1);
    const stated = { local_sites: 6, local_radius: 0.3, delta: 'stated' };
    const whole = await mesh.fracture({ of: first.location, local_point: [1.3, 0.1, 0], ...stated });
    assert.ok(whole.fragments.length > first.fragments.length);
    equal(hit, whole);
    // Another hit on the merged answer: several places, one of which misses.
    const again = await hit.hit([[-1.2, 0, 0.3], [50, 50, 50]], [0.3, 0.1], { sites: [5, 3] });
    const both = { local_point: [[-1.2, 0, 0.3], [50, 50, 50]], local_radius: [0.3, 0.1], local_sites: [5, 3], delta: 'stated' };
    equal(again, await mesh.fracture({ of: whole.location, ...both }));
  });

  for (const more of [{}, { physics: 'omi', ue_collision: 'ucx' }, { sheets: 'whole' }]) test(`a hit makes the whole, with its sheets: ${JSON.stringify(more)}`, async () => {
    const pane = 'v -2 0.8 -2\nv 2 0.8 -2\nv 2 0.8 2\nv -2 0.8 2\nf -4 -1 -2 -3\n';
    const roofed = await client.put({ name: 'roofed.obj', data: Buffer.from(`${torus()}\n${pane}`) }), first = await roofed.fracture({ sites: 24, ...more });
    const hit = await first.hit([1.3, 0.1, 0], 0.3, { sites: 6 });
    equal(hit, await roofed.fracture({ of: first.location, local_point: [1.3, 0.1, 0], local_sites: 6, local_radius: 0.3, delta: 'stated' }));
    const carried = hit.fragments.filter(({ sheet }) => sheet);
    assert.equal(carried.length > 0, !more.sheets);
    for (const { name, sheet } of carried) assert.equal(sheet.name, `${name}_sheet`);
    assert.ok(Math.abs(hit.certificate.sheet_area_out - 16) < 1e-4);
  });

  for (const more of [{}, { nodes: 'House' }, { physics: 'omi', ue_collision: 'ucx' }]) test(`a hit makes the whole, with its groups: ${JSON.stringify(more)}`, async () => {
    const put = await client.put({ name: 'house.glb', data: house() }), first = await put.fracture({ sites: 24, ...more });
    const hit = await first.hit([0.5, 0.5, 0.5], 0.8, { sites: 9 });
    equal(hit, await put.fracture({ of: first.location, local_point: [0.5, 0.5, 0.5], local_sites: 9, local_radius: 0.8, delta: 'stated' }));
    const nodes = hit.document.json.nodes, sources = nodes.flatMap(({ extras, children }) => (extras?.fracture?.source ? [[extras.fracture.source.name, children]] : []));
    assert.deepEqual(sources.map(([name]) => name), more.nodes ? ['House', 'Wall', 'Beam'] : ['House', 'Wall', 'Beam', 'Lamp']);
    assert.deepEqual(hit.passedThrough.map(({ name }) => name), more.nodes ? ['Lamp'] : []);
    assert.ok(nodes[0].children.every(child => nodes[child].extras?.fracture?.id === undefined), 'all fragments are in groups');
    for (const [name, children] of sources.slice(1)) assert.ok(children.length > 0, name);
  });

  test('without delta the fragments, volumes, geometry and bonds are the same', async () => {
    const hit = await answer.hit([1.3, 0.1, 0], 0.3, { sites: 6 });
    const whole = await mesh.fracture({ of: answer.location, local_point: [1.3, 0.1, 0], local_radius: 0.3, local_sites: 6, delta: 'none' });
    assert.deepEqual(hit.certificate, whole.certificate);
    assert.deepEqual(hit.bonds, whole.bonds);
    const figures = ({ fragments }) => fragments.map(({ id, name, volume, mass }) => ({ id, name, volume, mass }));
    assert.deepEqual(figures(hit), figures(whole));
    for (const fragment of hit.fragments)
      for (const member of ['positions', 'normals', 'uvs', 'triangles']) assert.deepEqual(fragment[member], whole.fragment(fragment.id)[member]);
    assert.ok(Buffer.from(hit.document.binary).equals(Buffer.from(whole.document.binary)));
    const { new: made, changed, gone } = hit.figures.delta;
    assert.equal(hit.fragments.length, answer.fragments.length + made.length - gone.length);
    for (const { id } of hit.fragments.filter(({ id }) => !made.includes(id) && !changed.includes(id)))
      assert.deepEqual(hit.fragment(id).positions, answer.fragment(id).positions);
  });

  test('a server that forgot the answer makes the same hit from its parameters', async () => {
    const fresh = await realServer(), saved = new Client(fresh.url).open(answer.glb);
    assert.equal((await refusal(saved.hit([1.3, 0.1, 0], 0.3))).problem, 'not-found');
    const known = await new Client(fresh.url).put(torusFile), made = new Client(fresh.url, { fetch: (url, options) => fetch(url, options) });
    const hit = await new Client(fresh.url).open(answer.glb).hit([1.3, 0.1, 0], 0.3, { sites: 6 });
    assert.ok(Buffer.from(hit.glb).equals((await answer.hit([1.3, 0.1, 0], 0.3, { sites: 6 })).glb));
    // The address of an answer that this server never made: 404, then by its parameters.
    const moved = await made.mesh(known.id).fracture({ sites: 12 });
    moved.head.location = `/fractures/sha256:${'0'.repeat(64)}`;
    assert.ok((await moved.hit([1.3, 0.1, 0], 0.3)).figures.delta.new.length > 0);
    fresh.kill();
  });

  test('a token is asked for and given', async () => {
    const folder = fs.mkdtempSync(path.join(os.tmpdir(), 'fracture-token-')), file = path.join(folder, 'tokens');
    fs.writeFileSync(file, 'studio 0123456789abcdef0123456789abcdef\n', { mode: 0o600 });
    const closed = await realServer('--token-file', file);
    assert.equal((await refusal(new Client(closed.url).version())).problem, 'unauthorized');
    const open = new Client(closed.url, { token: '0123456789abcdef0123456789abcdef' }), job = await (await open.put(torusFile)).job({ sites: 9 });
    assert.equal((await job.result()).certificate.unmirrored_caps, 0);
    closed.kill();
    fs.rmSync(folder, { recursive: true });
    assert.equal((await refusal(open.version({ retries: 0 }))).problem, 'server-absent');
  });
});

/** The volume by the divergence theorem. */
function volumeOf({ positions: p, triangles: t }) {
  let sum = 0;
  for (let k = 0; k < t.length; k += 3) {
    const [a, b, c] = [3 * t[k], 3 * t[k + 1], 3 * t[k + 2]];
    sum += p[a] * (p[b + 1] * p[c + 2] - p[b + 2] * p[c + 1]) + p[a + 1] * (p[b + 2] * p[c] - p[b] * p[c + 2]) + p[a + 2] * (p[b] * p[c + 1] - p[b + 1] * p[c]);
  }
  return sum / 6;
}
