// Every operation, status, problem type and header field of proto/openapi.yaml has its place in the package, and the package names no
// others. A new one fails here until it is handled: operations.ts, problems.ts, then a method.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Admin, operations, problemStatuses, requestFields, serverProblems } from '../../../client/typescript/dist/index.js';
import { answer, Client, dependency, fake, fragments, problem, read, refusal, stored } from './support.mjs';

const { parse } = await dependency('yaml');
const openapi = parse(read('proto/openapi.yaml'), { merge: true, maxAliasCount: -1 });
const resolve = value => (value?.$ref ? resolve(value.$ref.slice(2).split('/').reduce((at, key) => at[key], openapi)) : value);

const METHODS = ['get', 'put', 'post', 'delete', 'patch', 'head', 'options', 'trace'];
const documented = Object.entries(openapi.paths).flatMap(([path, item]) => Object.entries(item).filter(([key]) => METHODS.includes(key))
  .map(([method, operation]) => ({ path, method: method.toUpperCase(), ...operation,
    parameters: [...(item.parameters ?? []), ...(operation.parameters ?? [])].map(resolve),
    admin: (operation.servers ?? item.servers ?? openapi.servers)[0].url !== openapi.servers[0].url })));
const sorted = list => [...new Set(list)].sort();

test('operations', () => {
  assert.deepEqual(sorted(Object.keys(operations)), sorted(documented.map(({ operationId }) => operationId)));
  for (const { operationId, method, path, admin } of documented) {
    const ours = operations[operationId];
    assert.deepEqual([ours.method, ours.path, ours.admin ?? false], [method, path, admin], operationId);
  }
});

test('statuses', () => {
  const bad = new Set();
  for (const { operationId, responses } of documented) {
    assert.ok(responses.default, `${operationId} has no default`);
    const statuses = Object.keys(responses).filter(status => status !== 'default').map(Number);
    assert.deepEqual(sorted(operations[operationId].good), sorted(statuses.filter(status => status < 400)), operationId);
    for (const status of statuses) if (status >= 400) bad.add(status);
  }
  assert.deepEqual(sorted(problemStatuses), sorted(bad));
});

test('problem types', () => {
  const types = openapi.components.schemas.Problem.properties.type.enum.map(type => type.replace('/problems/', ''));
  assert.deepEqual(sorted(serverProblems), sorted(types));
});

test('header fields of requests', () => {
  const fields = documented.flatMap(({ parameters }) => parameters.filter(parameter => parameter.in === 'header').map(({ name }) => name));
  assert.deepEqual(sorted(requestFields), sorted(fields));
});

test('answers that are made of fragments carry a digest', () => {
  for (const { operationId, responses } of documented) {
    const headers = Object.values(responses).map(resolve).some(({ headers }) => headers && 'Repr-Digest' in headers);
    assert.equal(operations[operationId].digest ?? false, headers, operationId);
  }
});

test('states and stages of jobs', () => {
  const declared = read('client/typescript/src/jobs.ts');
  const union = line => new RegExp(`${line}(?: =|:) ([^;]*);`).exec(declared)[1].match(/'[^']*'/g).map(text => text.slice(1, -1));
  assert.deepEqual(sorted(union('type JobState')), sorted(openapi.components.schemas.JobState.enum));
  assert.deepEqual(sorted(union('stage')), sorted(openapi.components.schemas.Job.properties.stage.enum));
});

/** The call for each operation. */
const METHOD_OF = {
  getIndex: client => client.index(),
  getDocs: client => client.request('getDocs'),
  getPageFile: client => client.request('getPageFile', { path: { file: 'app.js' } }),
  getVersion: client => client.version(),
  getLimits: client => client.limits(),
  getPatterns: client => client.patterns(),
  getOpenapi: client => client.openapi(),
  getLlms: client => client.request('getLlms'),
  getProblem: client => client.explain('/problems/not-found'),
  postFracture: client => client.fracture(Uint8Array.of(1), { sites: 1 }),
  getFracture: client => client.answer('/fractures/sha256:1'),
  postMesh: client => client.inspect(Uint8Array.of(1)),
  putMesh: client => client.put(Uint8Array.of(1)),
  getMesh: client => client.put(Uint8Array.of(1), { ask: true }),
  deleteMesh: client => client.mesh('sha256:1').delete(),
  postMeshFracture: client => client.mesh('sha256:1').fracture(),
  postMeshEstimate: client => client.mesh('sha256:1').estimate(),
  getJobs: async client => {
    for await (const _ of client.jobs()) break;
  },
  getJob: client => client.job('1-1'),
  deleteJob: async client => (await client.job('1-1')).cancel(),
  getJobEvents: async client => (await client.job('1-1')).result(),
  getLivez: (_, admin) => admin.live(),
  getReadyz: (_, admin) => admin.ready(),
  getMetrics: (_, admin) => admin.metrics(),
};

test('every operation has a method that asks for it', async t => {
  assert.deepEqual(Object.keys(METHOD_OF).sort(), Object.keys(operations).sort());
  for (const [id, act] of Object.entries(METHOD_OF)) {
    const { method, path } = operations[id], pattern = new RegExp(`^${path.replace(/\{\w+\}/g, '[^/]+').replaceAll('.', '\\.')}$`);
    const job = { id: '1-1', state: 'running', stage: 'clip', percent: 1, links: {} };
    let asked = 0;
    const server = await fake(t, request => {
      if (request.method === method && pattern.test(request.target)) ++asked;
      if (request.target.endsWith('/events')) return problem(404, 'not-found');
      if (request.method === 'DELETE') return { bytes: Buffer.from('HTTP/1.1 204 No Content\r\n\r\n') };
      if (request.method === 'GET' && request.target.startsWith('/meshes') && id === 'putMesh') return problem(404, 'not-found');
      if (request.method === 'GET' && request.target === '/jobs') return answer(200, JSON.stringify({ jobs: [] }));
      if (request.target.startsWith('/jobs')) return answer(200, JSON.stringify(job));
      if (request.target.includes('fracture')) return fragments();
      return request.method === 'PUT' ? stored() : answer(200, '{}');
    });
    try {
      await act(new Client(server.url), new Admin(server.url));
    } catch (error) {
      assert.equal(id, 'getJobEvents', error.stack);
    }
    assert.equal(asked, 1, id);
    await server.close();
  }
});

test('every problem type is a name that a program can decide by', async t => {
  for (const name of serverProblems) {
    const server = await fake(t, () => problem(422, name));
    const error = await refusal(new Client(server.url).version());
    assert.deepEqual([error.problem, error.type, error.name], [name, `/problems/${name}`, 'FractureError']);
    await server.close();
  }
});
