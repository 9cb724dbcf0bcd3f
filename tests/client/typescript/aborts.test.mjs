// Requests that are aborted at any point, and jobs whose streams are cut, break or are missing.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { answer, built, Client, fake, FakeServer, fragments, idOf, problem, refusal, stored } from './support.mjs';

const mesh = Buffer.from('mesh'), id = '0123456789abcdef-0123456789abcdef';
const silent = { silent: true };

/** Aborts as soon as the server has seen a request for which `when` is true. Returns the result. */
async function aborted(t, handle, when, act) {
  const controller = new AbortController();
  const server = await fake(t, request => {
    const reply = handle(request);
    if (when(request)) setImmediate(() => controller.abort(new Error('no more')));
    return reply;
  });
  const error = await refusal(act(new Client(server.url), controller.signal));
  assert.deepEqual([error.problem, error.name, error.cause?.message], ['aborted', 'AbortError', 'no more']);
  return server;
}

test('before anything was sent', async t => {
  const server = await fake(t, () => fragments()), client = new Client(server.url), signal = AbortSignal.abort(new Error('no more'));
  assert.equal((await refusal(client.mesh('sha256:0').fracture({}, { signal }))).problem, 'aborted');
  assert.equal((await refusal(client.put(mesh, { signal }))).problem, 'aborted');
  assert.equal(server.requests.length, 0);
});

test('while the server computes', t => aborted(t, () => silent, () => true, (client, signal) => client.mesh('sha256:0').fracture({}, { signal })));

test('in the middle of the answer', t =>
  aborted(t, () => ({ bytes: fragments().bytes.subarray(0, -20) }), () => true, (client, signal) => client.mesh('sha256:0').fracture({}, { signal })));

test('while a busy server is waited for', t => aborted(t, () => problem(503, 'overloaded', 'Retry-After: 30\r\n'), () => true,
  (client, signal) => client.mesh('sha256:0').fracture({}, { signal })));

test('while an absent one is', async t => {
  const server = await new FakeServer(() => fragments()).listen(), { url } = server, controller = new AbortController();
  await server.close();
  const waiting = refusal(new Client(url, { retries: 1000 }).mesh('sha256:0').fracture({}, { signal: controller.signal }));
  setTimeout(() => controller.abort(), 60);
  assert.equal((await waiting).problem, 'aborted');
});

test('while a mesh is put', t => aborted(t, ({ method }) => (method === 'GET' ? problem(404, 'not-found') : silent), ({ method }) => method === 'PUT',
  (client, signal) => client.put(mesh, { signal, ask: true })));

test('while a forgotten mesh is put again: another one that waits for that puts it itself', async t => {
  let puts = 0;
  const controller = new AbortController();
  const server = await fake(t, async ({ method }) => {
    if (method === 'GET') return answer(200, JSON.stringify({ id: idOf(mesh), report: {} }));  // put() sends nothing
    if (method === 'POST') return puts < 2 ? problem(404, 'not-found') : fragments();
    if (++puts > 1) return stored(idOf(mesh));
    setTimeout(() => controller.abort(), 30);
    return silent;
  });
  const put = await new Client(server.url).put(mesh, { ask: true });
  const [first, second] = await Promise.all([refusal(put.fracture({ seed: 1 }, { signal: controller.signal })), put.fracture({ seed: 2 })]);
  assert.equal(first.problem, 'aborted');
  assert.equal(second.fragments.length, 1);
  assert.equal(puts, 2);
});

test('while another one puts the mesh, which goes on; and one deadline is of all that a call does', async t => {
  let puts = 0;
  const controller = new AbortController();
  const server = await fake(t, ({ method }) => {
    if (method === 'GET') return answer(200, JSON.stringify({ id: idOf(mesh), report: {} }));
    if (method === 'POST') return problem(404, 'not-found');
    if (++puts === 1) setTimeout(() => controller.abort(), 50);
    return silent;
  });
  const put = await new Client(server.url).put(mesh, { ask: true }), ended = [];
  const ending = async (seed, options) => ended.push((await refusal(put.fracture({ seed }, options))).problem);
  await Promise.all([ending(1, { deadline: 1500 }), ending(2, { signal: controller.signal })]);
  assert.deepEqual([ended, puts], [['aborted', 'timed-out'], 1]);
});

test('a fetch that does not heed its signal, too', async () => {
  const never = () => new Promise(() => {}), client = new Client('http://127.0.0.1:1', { fetch: never });
  assert.equal((await refusal(client.version({ signal: AbortSignal.timeout(20) }))).problem, 'aborted');
  assert.equal((await refusal(client.version({ timeout: 20, retries: 0 }))).problem, 'timed-out');
});

test('nobody listens to a signal any more when the request has ended', async t => {
  const server = await fake(t, () => fragments()), { signal } = new AbortController();
  let listening = 0;
  const { addEventListener: add, removeEventListener: remove } = signal;
  signal.addEventListener = (...given) => (++listening, add.apply(signal, given));
  signal.removeEventListener = (...given) => (--listening, remove.apply(signal, given));
  const client = new Client(server.url);
  for (let k = 0; k < 3; ++k) await client.mesh('sha256:0').fracture({}, { signal });
  assert.equal(listening, 0);
});

// -- jobs

const job = (state, percent, more = {}) => ({ id, state, stage: 'clip', percent, created: '2026-01-01T00:00:00Z', durable: false, links: {}, ...more });
const event = document => `id: ${document.percent}\r\nevent: ${document.state}\r\ndata: ${JSON.stringify(document)}\r\n\r\n`;
const accepted = answer(202, JSON.stringify(job('queued', 0)));
const done = job('done', 100, { result: '/fractures/sha256:1' });
const streamed = text => ({ bytes: Buffer.from(`HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\nConnection: close\r\n\r\n${text}`), close: true });

function jobServer(t, events, poll = () => answer(200, JSON.stringify(done))) {
  return fake(t, request => {
    if (request.method === 'POST') return accepted;
    if (request.target.endsWith('/events')) return events(request);
    return request.target.startsWith('/jobs') ? poll(request) : fragments();
  });
}

test('events, wherever they are cut', async () => {
  const { EventParser } = await built('events.js');
  const text = ': hello\r\n\r\nid: 1\r\nevent: progress\r\ndata: {"a":\r\ndata: 1}\r\n\r\ndata:x\n\ndata\n\nevent: end\r\rdata: ü\r\n\r\n';
  const wanted = [
    { event: 'progress', data: '{"a":\n1}', id: '1' }, { event: 'message', data: 'x', id: '1' }, { event: 'message', data: '', id: '1' },
    { event: 'end', data: '', id: '1' }, { event: 'message', data: 'ü', id: '1' },
  ];
  for (let cut = 0; cut <= text.length; ++cut) {
    const parser = new EventParser();
    assert.deepEqual([...parser.push(text.slice(0, cut)), ...parser.push(text.slice(cut))], wanted, `cut at ${cut}`);
  }
});

test('progress by events, then the fragments', async t => {
  const server = await jobServer(t, () => streamed(event(job('running', 20)) + ': nothing new\n\n' + event(job('running', 60)) + event(done)));
  const seen = [], started = await new Client(server.url).mesh('sha256:0').job({ sites: 9 });
  assert.equal((await started.result({ onProgress: ({ percent }) => seen.push(percent) })).fragments.length, 1);
  assert.deepEqual([seen, started.state, started.id], [[0, 20, 60, 100], 'done', id]);
  assert.match(server.requests[0].head, /prefer: respond-async\r\n/i);
  assert.doesNotMatch(server.requests[0].head, /request-timeout/i);
});

test('a stream that breaks is asked for again, by polls in between', async t => {
  let polls = 0;
  const server = await jobServer(t, () => streamed(event(job('running', 20 + 10 * polls)).slice(0, polls ? undefined : 30)),
    () => answer(200, JSON.stringify(++polls < 3 ? job('running', 20 + 10 * polls) : done)));
  const seen = [];
  await (await new Client(server.url).mesh('sha256:0').job()).result({ onProgress: ({ percent }) => seen.push(percent) });
  assert.deepEqual(seen, [0, 30, 30, 40, 40, 100]);
  assert.equal(server.requests.filter(({ target }) => target.endsWith('/events')).length, 3);
});

test('where no stream can be read, by polls that wait', async t => {
  const server = await jobServer(t, () => problem(404, 'not-found'));
  const client = new Client(server.url, { streams: false });
  assert.equal((await (await client.mesh('sha256:0').job()).result()).fragments.length, 1);
  assert.match(server.requests[1].head, /prefer: wait=20\r\n/i);
  assert.equal(server.requests.some(({ target }) => target.endsWith('/events')), false);
});

test('a job that failed says why', async t => {
  const error = { type: '/problems/too-complex', title: 'Too complex', status: 422, detail: 'Because.', request_id: 'r' };
  const server = await jobServer(t, () => streamed(event(job('failed', 40, { error }))));
  const said = await refusal((await new Client(server.url).mesh('sha256:0').job()).result());
  assert.deepEqual([said.problem, said.status, said.detail], ['too-complex', 422, 'Because.']);
});

test('a job that nobody knows any more ends the wait', async t => {
  const server = await jobServer(t, () => problem(404, 'not-found'));
  assert.equal((await refusal((await new Client(server.url).mesh('sha256:0').job()).result())).status, 404);
});

test('in the middle of events', async t => {
  const open = { bytes: streamed(event(job('running', 20))).bytes };
  await aborted(t, ({ method }) => (method === 'POST' ? accepted : open), ({ target }) => target.endsWith('/events'),
    async (client, signal) => (await client.mesh('sha256:0').job()).result({ signal }));
});

test('an answer that came in time is no job', async t => {
  const server = await fake(t, () => fragments('Preference-Applied: wait=5\r\n'));
  const started = await new Client(server.url).mesh('sha256:0').job({}, { wait: 5 });
  assert.deepEqual([started.state, started.id, (await started.result()).fragments.length], ['done', '', 1]);
  await started.cancel();
  assert.equal(server.requests.length, 1);
  assert.match(server.requests[0].head, /prefer: respond-async, wait=5\r\n/i);
});
