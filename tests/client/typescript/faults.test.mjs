// A server that forgets, is busy, lies, falls silent or dies. The behaviour must equal that of the game's client in
// tests/client/protocol_test.cpp and the files next to it.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { answer, Client, digestOf, fake, FakeServer, fragments, glb, idOf, problem, refusal, stored } from './support.mjs';

const mesh = Buffer.from('mesh'), meshId = idOf(mesh);
const known = answer(200, JSON.stringify({ id: meshId, report: {} }));
const unknown = server => new Client(server.url).mesh('sha256:0');

/** A server that has the mesh once it was put, unless told to forget it. */
function remembering() {
  const state = { known: false, handle: ({ method, target }) => {
    if (method === 'PUT') state.known = true;
    if (method === 'PUT') return stored(meshId);
    if (method === 'GET') return state.known ? known : problem(404, 'not-found');
    return state.known && target.endsWith('/fracture') ? fragments('Server-Timing: work;dur=3.5, odd, clip;desc="x";dur=12\r\n') : problem(404, 'not-found');
  } };
  return state;
}

test('stores by digest, then fractures', async t => {
  const server = await fake(t, remembering().handle), client = new Client(server.url);
  const put = await client.put(mesh, { ask: true }), made = await put.fracture({ sites: 7 });
  assert.equal(put.id, meshId);
  assert.deepEqual(server.requests.map(({ method, target }) => `${method} ${target}`),
    [`GET /meshes/${meshId}`, `PUT /meshes/${meshId}`, `POST /meshes/${meshId}/fracture`]);
  assert.match(server.requests[1].body.toString(), /name="mesh"\r\n\r\nmesh\r\n/);
  assert.equal(server.requests[2].body.toString(), '{"sites":7}');
  assert.deepEqual(made.head.timing, { work: 3.5, clip: 12 });
  assert.deepEqual([made.fragments.length, made.fragments[0].id, made.head.exchanges], [1, 7, 1]);
  assert.deepEqual([made.warnings, made.notes], [['to do'], ['done']]);
  assert.deepEqual(made.dropped, [{ what: 'light', name: 'Lamp', reason: 'why' }]);
});

test('what the server has, or this client put, is not sent again', async t => {
  const state = remembering(), server = await fake(t, state.handle), client = new Client(server.url), large = Buffer.alloc(100_000);
  state.known = true;
  await client.put(large);
  await client.put(large);
  assert.deepEqual(server.requests.map(({ method }) => method), ['GET']);
  const small = await client.put(mesh);  // a small mesh is sent without asking first
  assert.equal((await client.put(mesh)).stored, small.stored);
  assert.deepEqual(server.requests.slice(1).map(({ method }) => method), ['PUT']);
});

test('a forgotten mesh is put, and asked for again', async t => {
  const state = remembering(), server = await fake(t, state.handle), put = await new Client(server.url).put(mesh);
  state.known = false;  // as after a restart of the server
  assert.equal((await put.fracture()).head.exchanges, 2);
  assert.deepEqual(server.requests.map(({ method }) => method), ['PUT', 'POST', 'PUT', 'POST']);
});

test('many requests for a forgotten mesh put it once', async t => {
  const state = remembering();
  let refused = 0, allRefused;
  const fourRefused = new Promise(resolve => (allRefused = resolve));
  const server = await fake(t, async request => {
    if (request.method === 'PUT' && refused > 0) await fourRefused;
    if (request.method === 'POST' && !state.known && ++refused === 4) allRefused();
    return state.handle(request);
  });
  const put = await new Client(server.url).put(mesh);
  state.known = false;
  await Promise.all([1, 2, 3, 4].map(seed => put.fracture({ seed })));
  assert.equal(server.requests.filter(({ method }) => method === 'PUT').length, 2);
});

test('a 404 after the put is the server\'s own no', async t => {
  const server = await fake(t, ({ method }) => (method === 'PUT' ? stored(meshId) : problem(404, 'not-found')));
  const error = await refusal((await new Client(server.url).put(mesh)).fracture());
  assert.deepEqual([error.problem, error.status], ['not-found', 404]);
  assert.deepEqual(server.requests.map(({ method }) => method), ['PUT', 'POST', 'PUT', 'POST']);
});

test('a fragment that does not exist is no forgotten mesh', async t => {
  const server = await fake(t, ({ method }) => (method === 'POST' ? problem(404, 'no-such-fragment') : stored(meshId)));
  const put = await new Client(server.url).put(mesh);
  assert.equal((await refusal(put.fracture({ fragment: 3 }))).problem, 'no-such-fragment');
  assert.equal(server.requests.length, 2);
});

test('an unknown mesh is refused once', async t => {
  const server = await fake(t, () => problem(404, 'not-found'));
  assert.equal((await refusal(unknown(server).fracture())).status, 404);
  assert.equal(server.requests.length, 1);
});

test('refusals carry the server\'s words', async t => {
  const server = await fake(t, () => problem(400, 'bad-parameter', '', { parameter: 'sites', request_id: 'r', errors: [{ detail: 'x' }] }));
  const error = await refusal(unknown(server).fracture({ sites: -1 }));
  assert.deepEqual([error.type, error.problem, error.title, error.detail, error.message, error.parameter, error.status, error.exchanges],
    ['/problems/bad-parameter', 'bad-parameter', 'Title', 'Because.', 'Because.', 'sites', 400, 1]);
  assert.deepEqual([error.document.request_id, error.document.errors.length], ['r', 1]);
});

test('a proxy\'s page is an error, too', async t => {
  const server = await fake(t, () => answer(502, '<html>Bad gateway</html>'));
  const error = await refusal(unknown(server).fracture());
  assert.deepEqual([error.type, error.problem, error.status, error.document], ['about:blank', 'unknown', 502, undefined]);
  assert.match(error.detail, /^The response \(HTTP 502\) has no problem document/);
});

test('a busy server is asked again after its Retry-After', async t => {
  const server = await fake(t, ({ number }) => (number < 6 ? problem(number % 2 ? 429 : 503, 'overloaded', 'Retry-After: 0\r\n') : fragments()));
  assert.equal((await unknown(server).fracture()).head.exchanges, 7);
});

test('a Retry-After is waited for', async t => {
  const server = await fake(t, ({ number }) => (number === 0 ? problem(503, 'overloaded', 'Retry-After: 1\r\n') : fragments()));
  const began = performance.now();
  await unknown(server).fracture();
  assert.ok(performance.now() - began >= 990);
});

test('a Retry-After beyond the deadline is an answer at once', async t => {
  const server = await fake(t, () => problem(503, 'overloaded', 'Retry-After: 3600\r\n'));
  const error = await refusal(unknown(server).fracture());
  assert.deepEqual([error.problem, error.retryAfter, error.exchanges], ['overloaded', 3600, 1]);
});

test('tries are bounded', async t => {
  const server = await fake(t, () => problem(429, 'over-share', 'Retry-After: 0\r\n'));
  assert.equal((await refusal(unknown(server).fracture({}, { retries: 3 }))).exchanges, 4);
  assert.equal(server.requests.length, 4);
});

test('a storm of refusals loses no request', async t => {
  const server = await fake(t, ({ number }) => (number % 3 !== 2 ? problem(503, 'overloaded', 'Retry-After: 0\r\n') : fragments()));
  const client = new Client(server.url, { retries: 100 });
  await Promise.all(Array.from({ length: 30 }, (_, seed) => client.mesh('sha256:0').fracture({ seed })));
  assert.equal(server.requests.length, 90);
});

test('a bit that flipped is noticed, and asked for again', async t => {
  const server = await fake(t, ({ number }) => {
    const reply = fragments();
    if (number === 0) reply.bytes[reply.bytes.length - 5] ^= 4;
    return reply;
  });
  assert.equal((await unknown(server).fracture()).head.exchanges, 2);
});

test('answers that stay damaged fail as damaged', async t => {
  const server = await fake(t, () => answer(200, 'other bytes', `Repr-Digest: sha-256=:${digestOf(glb)}:\r\n`));
  const error = await refusal(unknown(server).fracture());
  assert.deepEqual([error.problem, error.exchanges], ['damaged-answer', 3]);
});

test('an answer without digest is damaged', async t => {
  const server = await fake(t, () => answer(200, glb));
  assert.equal((await refusal(unknown(server).fracture())).problem, 'damaged-answer');
});

test('an answer that is whole, and no GLB, is damaged', async t => {
  const server = await fake(t, () => answer(200, 'hello', `Repr-Digest: sha-256=:${digestOf('hello')}:\r\n`));
  assert.equal((await refusal(unknown(server).fracture())).problem, 'damaged-answer');
});

test('every truncation of an answer is survived', async t => {
  const whole = fragments().bytes;
  let length = 0, cut = true;
  const server = await fake(t, () => {
    const reply = cut ? { bytes: whole.subarray(0, length), close: true } : { bytes: whole };
    cut = false;
    return reply;
  });
  const lengths = Array.from({ length: 24 }, (_, k) => 1 + Math.floor(k * (whole.length - 1) / 24));
  for (length of [...lengths, whole.length - 1]) {
    cut = true;
    const made = await unknown(server).fracture();
    assert.ok(Buffer.from(made.glb).equals(Buffer.from(glb)), `${length} bytes`);
  }
});

test('flipped bytes of an answer are survived', async t => {
  const whole = fragments().bytes;
  let at = 0, flip = true;
  const server = await fake(t, () => {
    const bytes = Buffer.from(whole), flipped = flip;
    flip = false;
    if (flipped) bytes[at] ^= 0x12;
    return { bytes, close: flipped };  // so that the client does not wait for a longer body
  });
  for (at = 0; at < whole.length; at += at < 200 ? 9 : 37) {
    flip = true;
    // If the flipped bit changed the status, the client reports a refusal by the server. Otherwise only the intact fragments may arrive.
    try {
      assert.ok(Buffer.from((await unknown(server).fracture()).glb).equals(Buffer.from(glb)), `${at}`);
    } catch (error) {
      assert.equal(error.type, 'about:blank', `byte ${at}: ${error}`);
    }
  }
});

test('JSON or damaged', async t => {
  const server = await fake(t, ({ number }) => answer(200, number === 0 ? '{"patterns": [' : '{"patterns": []}'));
  assert.deepEqual(await new Client(server.url).patterns(), { patterns: [] });
  assert.equal(server.requests.length, 2);
});

test('an answer over the limit is refused unread', async t => {
  const server = await fake(t, () => ({ bytes: Buffer.from('HTTP/1.1 200 OK\r\nContent-Length: 99999999999\r\n\r\nabc') }));
  const error = await refusal(new Client(server.url, { maxAnswerBytes: 1000 }).mesh('sha256:0').fracture());
  assert.deepEqual([error.problem, error.exchanges], ['answer-too-large', 1]);
  assert.match(error.detail, /1,000/);
});

test('parameters over the limit go with the mesh, or nowhere', async t => {
  const server = await fake(t, ({ target }) => (target === '/fracture' ? fragments() : stored(meshId)));
  const client = new Client(server.url), points = Array.from({ length: 5000 }, (_, k) => [k, 0.25, -k]);
  await (await client.put(mesh)).fracture({ pattern: 'points', points });
  assert.match(server.requests.at(-1).body.toString(), /name="params"\r\nContent-Type: application\/json\r\n\r\n\{"pattern":"points","points":\[\[0,0\.25,0\]/);
  const before = server.requests.length;
  assert.equal((await refusal(client.mesh('sha256:0').fracture({ points }))).problem, 'bad-argument');
  assert.equal(server.requests.length, before);
});

test('what is sent with each request', async t => {
  const server = await fake(t, () => fragments());
  let asked = 0;
  const client = new Client(`${server.url}/behind/a/proxy/`, { token: () => `secret${++asked}`, headers: { 'X-Studio': 'a' }, timeout: 5000 });
  await client.mesh('sha256:0').fracture({});
  await client.mesh('sha256:0').fracture({}, { realtime: true, timeout: 500 });
  const [first, second] = server.requests;
  assert.equal(first.target, '/behind/a/proxy/meshes/sha256:0/fracture');
  for (const line of ['authorization: Bearer secret1', 'x-studio: a', 'priority: u=3', 'request-timeout: 5', 'range: bytes=0-', 'accept-encoding: identity'])
    assert.ok(first.head.toLowerCase().includes(`${line.toLowerCase()}\r\n`), `${line} in ${first.head}`);
  for (const line of ['authorization: bearer secret2', 'priority: u=1', 'request-timeout: 0.5'])
    assert.ok(second.head.toLowerCase().includes(`${line}\r\n`), line);
});

test('a silent server times out, and is asked again while there is time', async t => {
  const server = await fake(t, () => ({ silent: true }));
  const error = await refusal(new Client(server.url, { timeout: 40, deadline: 200 }).mesh('sha256:0').fracture());
  assert.equal(error.problem, 'timed-out');
  assert.ok(error.exchanges >= 2, `${error.exchanges}`);
});

test('a server that stops in the middle of its answer times out', async t => {
  const server = await fake(t, () => ({ bytes: fragments().bytes.subarray(0, -10) }));
  const error = await refusal(new Client(server.url, { timeout: 60, retries: 0 }).mesh('sha256:0').fracture());
  assert.deepEqual([error.problem, error.exchanges], ['timed-out', 1]);
});

test('an absent server is an error when the tries or the deadline end', async t => {
  const server = await new FakeServer(() => fragments()).listen(), { url } = server;
  await server.close();
  const error = await refusal(new Client(url, { retries: 2 }).mesh('sha256:0').fracture());
  assert.deepEqual([error.problem, error.status, error.exchanges], ['server-absent', 0, 3]);
  assert.match(error.detail, /No server answers at http:\/\/127\.0\.0\.1:\d+ \(fetch failed: ECONNREFUSED\)/);
  assert.ok((await refusal(new Client(url, { deadline: 100 }).mesh('sha256:0').fracture())).exchanges <= 3);
});

test('a request waits for the server to come back', async t => {
  const gone = await new FakeServer(() => fragments()).listen(), { port, url } = gone;
  await gone.close();
  const waiting = new Client(url).mesh('sha256:0').fracture();
  await refusal(new Client(url, { retries: 0 }).mesh('sha256:0').fracture());
  await fake(t, () => fragments(), port);
  assert.ok((await waiting).head.exchanges >= 2);
});

test('a server that dies in mid-flight and comes back answers', async t => {
  let asked;
  const first = new Promise(resolve => (asked = resolve)), dying = await new FakeServer(() => (asked(), { silent: true })).listen();
  const { port, url } = dying, waiting = new Client(url).mesh('sha256:0').fracture();
  await first;
  await dying.close();
  await fake(t, () => fragments(), port);
  assert.ok((await waiting).head.exchanges >= 2);
});

test('a kept connection that the server closed is replaced', async t => {
  const server = await fake(t, ({ number }) => ({ ...fragments(), close: number === 0 })), one = unknown(server);  // without Connection: close
  await one.fracture();
  await one.fracture();
  assert.equal(server.connections, 2);
});
