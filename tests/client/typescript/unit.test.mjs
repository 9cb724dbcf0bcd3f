// The parts that need no server: digests, forms, the reader of GLB, mass and momentum, bonds.
import assert from 'node:assert/strict';
import { createHash } from 'node:crypto';
import { test } from 'node:test';
import { built, Client, Glb, packGlb, refusal, FractureError, fake, answer, stored, problem, glb as small } from './support.mjs';

const { sha256Here, digestMatches } = await built('sha256.js');
const { retryAfter } = await built('problems.js');
const { collisionFilters } = await built('filters.js');
const { Groups, uncutIndices } = await built('groups.js');

test('SHA-256 without WebCrypto is that of OpenSSL', () => {
  for (const size of [0, 1, 3, 55, 56, 57, 63, 64, 65, 119, 120, 1000, 100_003]) {
    const bytes = Uint8Array.from({ length: size }, (_, k) => (k * 7919 + size) >> 3);
    assert.equal(Buffer.from(sha256Here(bytes)).toString('hex'), createHash('sha256').update(bytes).digest('hex'), `${size} bytes`);
  }
  const inside = new Uint8Array(300).fill(5).subarray(3, 200);
  assert.equal(Buffer.from(sha256Here(inside)).toString('hex'), createHash('sha256').update(inside).digest('hex'));
});

test('a digest is that of the bytes', async () => {
  // The digest of empty data is known from FIPS 180-4's examples; its base64 comes from coreutils.
  const ofNothing = 'sha-256=:47DEQpj8HBSa+/TImW+5JCeuQeRkm5NMpJWZG3hSuFU=:', nothing = new Uint8Array();
  assert.ok(await digestMatches(ofNothing, nothing));
  assert.ok(await digestMatches(`md5=:x:, ${ofNothing}`, nothing));
  assert.ok(!await digestMatches(ofNothing, Uint8Array.of(1)));
  assert.ok(!await digestMatches('md5=:x:', nothing));
  assert.ok(!await digestMatches('xsha-256=:47DEQpj8HBSa+/TImW+5JCeuQeRkm5NMpJWZG3hSuFU=:', nothing));
});

test('collision filters exclude pairs, are not transitive, and twins share a system', () => {
  const [named, lists] = [{ system: 1, excluded: [] }, { system: 0, excluded: [1] }];
  assert.deepEqual(collisionFilters(4, [[0, 1], [1, 2]]), [named, lists, named, undefined]);
  assert.deepEqual(collisionFilters(5, [[0, 2], [0, 3], [0, 4], [1, 2], [1, 3], [1, 4]]), [named, named, lists, lists, lists]);
});

test('Retry-After is seconds within a day', () => {
  const of = value => retryAfter(new Headers(value === undefined ? {} : { 'Retry-After': value }));
  assert.deepEqual([of('2'), of(' 0 '), of('86400')], [2, 0, 86400]);
  for (const value of [undefined, '', '-1', '1.5', 'Fri, 31 Dec 1999 23:59:59 GMT', '99999999999999999999', '86401']) assert.equal(of(value), undefined, value);
});

test('what is no mesh, no address and no number is said before anything is sent', async () => {
  const client = new Client('http://127.0.0.1:1', { fetch: () => assert.fail('nothing is sent') });
  for (const input of ['barrel.glb', undefined, 7, { name: 'a.glb' }, [], [{ name: 'a\nb', data: new Uint8Array() }]])
    assert.equal((await refusal(client.put(input))).problem, 'bad-argument', `${input}`);
  for (const url of ['127.0.0.1:8080', 'not a url', 'ftp://a', ''])
    assert.throws(() => new Client(url), error => error instanceof FractureError && error.problem === 'bad-argument' && error.parameter === 'url', url);
  assert.equal((await refusal(client.mesh('sha256:0').fracture({ sites: NaN }))).problem, 'bad-argument');
  assert.equal((await refusal(client.mesh('sha256:0').fracture({ sites: 5n }))).problem, 'bad-argument');
  const badToken = new Client('http://127.0.0.1:1', { token: 'two\nlines', fetch: () => assert.fail('nothing is sent') });
  assert.equal((await refusal(badToken.version())).problem, 'bad-argument');
});

test('of several files the one that the server reads is the mesh, and names are as the mesh writes them', async t => {
  const formats = answer(200, JSON.stringify({ formats: ['glb', 'obj'] }));
  const server = await fake(t, ({ target, method }) => (target === '/limits' ? formats : method === 'PUT' ? stored() : problem(404, 'not-found')));
  const client = new Client(server.url), data = Uint8Array.of(1), file = name => ({ name, data });
  await client.put([file('.\\house\\textures\\ "ü".png'), file('house/house.OBJ'), file('house/house.mtl')]);
  const form = server.requests.at(-1).body.toString();
  const names = [...form.matchAll(/name="(\w+)"; filename="(.*)"\r\n/g)].map(([, part, name]) => [part, name]);
  assert.deepEqual(names, [['mesh', 'house/house.OBJ'], ['file', 'house.mtl'], ['file', 'textures/ \\"ü\\".png']]);
  for (const files of [['a.glb', 'b.obj'], ['a.png', 'b.mtl']])
    assert.equal((await refusal(client.put(files.map(file)))).parameter, 'main');
  await client.put(['a.glb', 'b.obj'].map(file), { main: 'b.obj' });
  assert.match(server.requests.at(-1).body.toString(), /name="mesh"; filename="b\.obj"/);
  assert.equal((await refusal(client.put(['a.glb', 'b.obj'].map(file), { main: 'c.obj' }))).parameter, 'main');
  assert.equal(server.requests.filter(({ target }) => target === '/limits').length, 1);
});

test('a GLB is read where it lies', () => {
  const floats = Float32Array.from({ length: 12 }, (_, k) => k), binary = new Uint8Array(64);
  binary.set(new Uint8Array(floats.buffer));
  binary.set([2, 0, 1, 0], 48);              // indices of the sparse accessor
  binary.set(new Uint8Array(Float32Array.of(-1, -2).buffer), 52);
  const json = {
    asset: { version: '2.0' }, buffers: [{ byteLength: 64 }],
    bufferViews: [{ buffer: 0, byteLength: 48 }, { buffer: 0, byteLength: 48, byteStride: 16 }, { buffer: 0, byteOffset: 48, byteLength: 12 }],
    accessors: [
      { bufferView: 0, componentType: 5126, count: 4, type: 'VEC3' },
      { bufferView: 1, byteOffset: 4, componentType: 5126, count: 3, type: 'VEC2' },
      { bufferView: 0, componentType: 5126, count: 4, type: 'SCALAR',
        sparse: { count: 2, indices: { bufferView: 2, componentType: 5121 }, values: { bufferView: 2, byteOffset: 4 } } },
      { componentType: 5123, count: 2, type: 'SCALAR' },
      { bufferView: 0, componentType: 5126, count: 5, type: 'VEC3' },
    ],
  };
  const glb = new Glb(packGlb(json, binary));
  assert.deepEqual(glb.json, json);
  assert.deepEqual([...glb.accessor(0)], [...floats]);
  assert.equal(glb.accessor(0).buffer, glb.bytes.buffer);
  assert.deepEqual([...glb.accessor(1)], [1, 2, 5, 6, 9, 10]);
  assert.deepEqual([...glb.accessor(2)], [0, 1, -1, 3].map((v, k) => (k === 0 ? -2 : v)));
  assert.deepEqual([...glb.accessor(3)], [0, 0]);
  assert.throws(() => glb.accessor(4), FractureError);
  // The same bytes at an odd offset in a larger buffer give the same.
  const odd = new Uint8Array(glb.bytes.length + 1);
  odd.set(glb.bytes, 1);
  assert.deepEqual([...new Glb(odd.subarray(1)).accessor(0)], [...floats]);
  for (let size = 0; size < glb.bytes.length; size += 11) assert.throws(() => new Glb(glb.bytes.subarray(0, size)), FractureError, `${size}`);
});

test('a hit has the origin of the file, and an answer that of its root', async () => {
  const { Answer } = await built('answer.js'), { json } = new Glb(small), [root, ...others] = json.nodes, asked = [];
  const far = packGlb({ ...json, nodes: [{ ...root, translation: [500000, 30, 4649776] }, ...others] }, new Uint8Array());
  const mesh = { deadline: 1000, fracture: parameters => (asked.push(parameters), Promise.reject(new Error('enough'))) };
  const head = { location: '/fractures/sha256:1' }, made = new Answer(far, head, () => mesh);
  assert.deepEqual(made.offset, [500000, 30, 4649776]);
  assert.deepEqual(new Answer(small, head, () => mesh).offset, [0, 0, 0]);
  await assert.rejects(made.hit([0.5, 1, 2], 1), /enough/);
  assert.deepEqual(asked.map(parameters => parameters.local_point), [[[500000.5, 31, 4649778]]]);
});

// -- mass

const { combine, inertiaOf, inherit, momentumOf, placed, principalAxes, setMomentum, turned, rotate } = await built('three/mass.js');
const { brokenBy, components, energyOf } = await built('three/bonds.js');

/** xorshift32, which gives the same numbers each time. */
function numbers(seed) {
  return () => {
    seed ^= seed << 13, seed ^= seed >>> 17, seed ^= seed << 5;
    return (seed >>> 0) / 2 ** 31 - 1;
  };
}
const close = (a, b, within, what) => a.forEach((value, k) => assert.ok(Math.abs(value - b[k]) <= within, `${what}: ${a} is not ${b}`));
const unit = q => q.map(c => c / Math.hypot(...q));

test('the node of an instance is turned and scaled', async () => {
  const { turnOf } = await built('turn.js'), half = Math.SQRT1_2;
  assert.equal(turnOf({ translation: [1, 2, 3] }), undefined);
  // A quarter turn about y, after doubling: (x, y, z) -> (2 z, 2 y, -2 x).
  const turn = turnOf({ rotation: [0, half, 0, half], scale: [2, 2, 2] });
  close([...turn.attribute('POSITION', Float32Array.of(1, 0, 0, 0, 3, 5))], [0, 0, -2, 10, 6, 0], 1e-6, 'positions');
  close([...turn.attribute('TANGENT', Float32Array.of(1, 0, 0, -1))], [0, 0, -1, -1], 1e-6, 'tangents');
  const motion = turn.motion({ mass: 1, centerOfMass: [1, 0, 0], inertiaDiagonal: [1, 2, 3], inertiaOrientation: [half, 0, 0, half] });
  close(motion.centerOfMass, [0, 0, -2], 1e-12, 'centre');
  close(motion.inertiaOrientation, [0.5, 0.5, -0.5, 0.5], 1e-12, 'the turn about x comes first');
});

test('principal axes make the inertia again', () => {
  const random = numbers(7);
  for (let k = 0; k < 200; ++k) {
    const moments = [1 + random(), 1 + random(), k % 3 === 0 ? 1e-6 : 1 + random()];
    const inertia = inertiaOf(moments, unit([random(), random(), random(), random()]));
    const { moments: found, axes } = principalAxes(inertia);
    close(inertiaOf(found, axes), inertia, 1e-13, `${k}`);
    close([...found].sort((a, b) => a - b), moments.sort((a, b) => a - b), 1e-13, `${k}`);
  }
  close(principalAxes([0, 0, 0, 0, 0, 0, 0, 0, 0]).moments, [0, 0, 0], 0, 'nothing');
});

test('two halves weigh and turn as the whole does', () => {
  // A bar of 2 x 1 x 1 m and 12 kg; each half is a cube of 6 kg, 1/6 m a² = 1 kg m² about its centre.
  const half = x => ({ mass: 6, center: [x, 0, 0], inertia: [1, 0, 0, 0, 1, 0, 0, 0, 1] });
  const { mass, center, inertia } = combine([half(-0.5), half(0.5)]);
  assert.deepEqual([mass, center], [12, [0, 0, 0]]);
  close(inertia, [2, 0, 0, 0, 5, 0, 0, 0, 5], 1e-15, 'inertia');  // m (1 + 1)/12 and m (4 + 1)/12
});

test('any bodies get exactly the momentum that they are given', () => {
  const random = numbers(11), vec = () => [random(), random(), random()];
  for (let k = 0; k < 100; ++k) {
    const bodies = Array.from({ length: 1 + k % 9 }, () => ({
      mass: 1 + random() + 0.01, center: vec(), velocity: vec(), spin: vec(),
      inertia: turned([1.5 + random(), 0, 0, 0, 1.5 + random(), 0, 0, 0, 1.5 + random()], unit([random(), random(), random(), random()])),
    }));
    const wanted = { mass: 3, center: vec(), linear: vec(), angular: vec() };
    setMomentum(bodies, wanted);
    const { linear, angular } = momentumOf(bodies, wanted.center);
    close(linear, wanted.linear, 1e-12, `${k}: linear`);
    close(angular, wanted.angular, 1e-12, `${k}: angular`);
  }
  setMomentum([], { mass: 0, center: [0, 0, 0], linear: [0, 0, 0], angular: [0, 0, 0] });
});

test('what takes the place of a body moves as it did', () => {
  const random = numbers(13), vec = () => [random(), random(), random()];
  for (let k = 0; k < 50; ++k) {
    const parts = Array.from({ length: 2 + k % 7 }, () => ({ mass: 1.01 + random(), center: vec(), inertia: inertiaOf([1, 1, 1], [0, 0, 0, 1]) }));
    const at = vec(), turn = unit([random(), random(), random(), random()]), [velocity, spin] = [vec(), vec()];
    const body = { ...placed(combine(parts), at, turn), velocity, spin };
    // If the parts weigh as much as the body, they move with its velocity field, v + ω × r, in any frame.
    const made = inherit(body, parts.map(part => placed(part, at, turn)));
    made.forEach((part, number) => {
      const r = part.center.map((value, axis) => value - body.center[axis]);
      const field = [spin[1] * r[2] - spin[2] * r[1], spin[2] * r[0] - spin[0] * r[2], spin[0] * r[1] - spin[1] * r[0]];
      close(part.velocity, field.map((value, axis) => value + velocity[axis]), 1e-12, `${k}: velocity of ${number}`);
      close(part.spin, spin, 1e-12, `${k}: spin of ${number}`);
    });
    // Parts that are twice as heavy still keep the body's momentum.
    const heavy = inherit(body, parts.map(part => ({ ...placed(part, at, turn), mass: 2 * part.mass })));
    const [was, is] = [momentumOf([body]), momentumOf(heavy, body.center)];
    close(is.linear, was.linear, 1e-12, `${k}: linear`);
    close(is.angular, was.angular, 1e-12, `${k}: angular`);
  }
});

test('a quarter turn about z takes x to y', () => close(rotate(unit([0, 0, 1, 1]), [1, 0, 0]), [0, 1, 0], 1e-15, 'turned'));

test('a blow breaks the nearest bonds, as far as its energy goes', () => {
  const bonds = [3, 1, 2, 4].map((x, k) => ({ a: k, b: k + 1, area: 1, centroid: [x, 0, 0], normal: [1, 0, 0], strength: 2000 }));
  const cost = 0.5 * 2000 * 1e-3;
  assert.deepEqual(brokenBy({ point: [0, 0, 0], energy: 2.5 * cost }, bonds, [0, 1, 2, 3], 1e-3), [1, 2]);
  assert.deepEqual(brokenBy({ point: [9, 0, 0], energy: cost }, bonds, [0, 1, 2], 1e-3), [0]);
  assert.deepEqual(brokenBy({ point: [0, 0, 0], energy: 0.9 * cost }, bonds, [0, 1, 2, 3], 1e-3), []);
  // Two bodies of 2 kg, one at rest, the other at 3 m/s, stay together: 9 J become 4.5 J, and the impulse was 3 N·s.
  assert.equal(energyOf(3, 2, 2), 4.5);
  assert.equal(energyOf(6, 2, 0), 9);  // against an immovable body all energy is lost
});

test('groups of both answers are written as the server does', () => {
  const group = (index, name, children, source = name) => ({ name, children, extras: { fracture: { source: { index, name: source } }, hp: index } });
  const fragment = id => ({ name: `Cube_${id}`, extras: { fracture: { id } } });
  const answer = (...nodes) => new Glb(packGlb({ asset: { version: '2.0' }, scene: 0, scenes: [{ nodes: [0] }], nodes }, new Uint8Array()));
  // The source: 0 House {2 Cube, 3 Cube.1, 5 Lid_group}, 7 Gone.
  const before = answer({ children: [4, 6] }, fragment(0), fragment(1), { name: 'sign', mesh: 0 }, group(0, 'House', [5]), group(2, 'Cube', [1, 3]), group(7, 'Gone', [2]));
  const delta = answer({ children: [3] }, fragment(2), fragment(3), group(0, 'House_group', [4, 5], 'House'), group(3, 'Cube_1_group', [1], 'Cube.1'), group(5, 'Lid_group', [2]));
  assert.deepEqual([uncutIndices(before), uncutIndices(delta)], [[3], []]);
  const groups = new Groups([before, delta]), old = before.json.nodes, now = delta.json.nodes;
  assert.deepEqual([old[1], old[2], old[3], now[1], now[2], old[4]].map(node => groups.above(node)), [2, 7, 2, 3, 5, undefined]);
  const held = [{ group: 2, node: 1 }, { group: 3, node: 2 }, { group: 5, node: 3 }, { group: 2, node: 4 }];
  for (const [taken, names] of [[[], ['House', 'Cube', 'Cube_1', 'Lid_group']],
    [['Cube_1', 'Lid_group', 'House', 'House_group'], ['House_2_group', 'Cube', 'Cube_1_group', 'Lid_group_group']]])
    assert.deepEqual(groups.written(held, 5, new Set(taken)), { ofRoot: [5], nodes: [
      { ...group(0, names[0], [6, 7, 8]), extras: old[4].extras }, { ...group(2, names[1], [1, 4]), extras: old[5].extras },
      { ...group(3, names[2], [2]), extras: now[4].extras }, { ...group(5, names[3], [3]), extras: now[5].extras }] });
  assert.deepEqual(groups.written([{ group: undefined, node: 1 }], 2, new Set()), { nodes: [], ofRoot: [1] });
});

test('groups are what bonds still hold together', () => {
  const ends = bond => [[0, 1], [1, 2], [3, 4], [5, 9]][bond];
  assert.deepEqual(components([0, 1, 2, 3, 4, 5], [0, 1, 2, 3], ends), [[0, 1, 2], [3, 4], [5]]);
  assert.deepEqual(components([0, 1, 2], [], ends), [[0], [1], [2]]);
});
