// Validates recorded exchanges (tests/server/record.hpp) against proto/openapi.yaml. The document must describe the path, the method, the
// status and the media type. A JSON body and every described header must fit their schemas. Exit codes: 0 if all are valid, 1 if not, 77 if
// node_modules is missing. The document is the one that the server served. Usage: node validate.mjs FILE.jsonl...
import fs from 'node:fs';

let Ajv, addFormats;
try {
  ({default: Ajv} = await import('ajv/dist/2020.js'));
  ({default: addFormats} = await import('ajv-formats'));
} catch {
  console.log('skipped: tests/contract/node_modules is missing (npm ci there)');
  process.exit(77);
}

const exchanges = process.argv.slice(2).flatMap(
    file => fs.readFileSync(file, 'utf8').split('\n').filter(line => line !== '').map(line => JSON.parse(line)));
const served = exchanges.find(e => e.method === 'GET' && e.target === '/openapi.json' && e.status === 200);
if (!served) {
  console.log('no exchange holds the document (GET /openapi.json)');
  process.exit(1);
}
const document = JSON.parse(served.body);
const ajv = new Ajv({strict: false, allErrors: true});
addFormats(ajv);
ajv.addFormat('binary', true);
ajv.addSchema(document, 'openapi');

/** The object behind a $ref, and the JSON pointer to its place. */
function resolve(pointer) {
  let value = document;
  for (const token of pointer.split('/').slice(1))
    value = value[decodeURIComponent(token).replaceAll('~1', '/').replaceAll('~0', '~')];
  return value?.$ref ? resolve(value.$ref.slice(1)) : {value, pointer};
}
const escape = token => token.replaceAll('~', '~0').replaceAll('/', '~1').replaceAll('%', '%25').replaceAll(
    '{', '%7B').replaceAll('}', '%7D');

const validators = new Map();
function check(pointer, value) {
  if (!validators.has(pointer)) validators.set(pointer, ajv.compile({$ref: `openapi#${pointer}`}));
  const validate = validators.get(pointer);
  return validate(value) ? [] : validate.errors.map(e => `${e.instancePath || '(body)'} ${e.message}`);
}

function pathOf(target) {
  const path = target.split('?')[0];
  try {
    return decodeURIComponent(path);
  } catch {
    return path;  // a malformed escape: none of our paths
  }
}

function findPath(path) {
  const names = Object.keys(document.paths);
  return names.find(name => name === path) ?? names.find(name => {
    const pattern = name.replace(/[.*+?^$()|[\]\\]/g, '\\$&').replace(/\{[^}]+\}/g, '[^/]+');
    return new RegExp(`^${pattern}$`).test(path);
  });
}

/** A header is text. Its schema may say that it is a number. */
function headerValue(schema, text) {
  return schema?.type === 'integer' || schema?.type === 'number' ? Number(text) : text;
}

function problemsOf({method, target, status, headers, body}) {
  // The Fetch standard governs the preflights of browsers; the document does not describe them.
  if (method === 'OPTIONS' && status === 204) return body === '' ? [] : ['a preflight with a body'];
  const path = pathOf(target), name = findPath(path);
  const item = name && document.paths[name];
  const verb = method.toLowerCase() === 'head' ? 'get' : method.toLowerCase();
  const operation = item?.[verb];
  let at;
  if (operation) {
    const key = operation.responses[status] ? status : operation.responses.default ? 'default' : null;
    if (key === null) return [`status ${status} is not described`];
    at = resolve(`/paths/${escape(name)}/${verb}/responses/${key}`);
  } else if ([400, 401, 403, 404, 405, 406, 408, 413, 414, 417, 429, 431, 501, 503, 505].includes(status)) {
    at = resolve('/components/responses/Problem');  // the path or method does not exist: always a problem
  } else {
    return [`${method} ${path} is not described and was answered with ${status}`];
  }
  const problems = [];
  const response = at.value;
  for (const [field, description] of Object.entries(response.headers ?? {})) {
    const text = headers[field.toLowerCase()];
    const {value} = description.$ref ? resolve(description.$ref.slice(1)) : {value: description};
    if (text === undefined) {
      if (value.required) problems.push(`the header ${field} is missing`);
      continue;
    }
    const schema = ajv.compile(value.schema ?? {});
    if (!schema(headerValue(value.schema, text))) problems.push(`header ${field}: '${text}' is not as described`);
  }
  const type = (headers['content-type'] ?? '').split(';')[0];
  const content = response.content ?? {};
  if (status === 304 || status === 204) {
    if (body !== '') problems.push('a body where there can be none');
    return problems;
  }
  if (Object.keys(content).length === 0) return problems;
  if (!content[type]) return [...problems, `media type '${type}' is not described for ${status}`];
  if (method === 'HEAD' || !/\bjson$/.test(type) || body === null) return problems;
  let value;
  try {
    value = JSON.parse(body);
  } catch {
    return [...problems, 'the body is no JSON'];
  }
  problems.push(...check(`${at.pointer}/content/${escape(type)}/schema`, value));
  if (type === 'application/problem+json') {
    if (value.status !== status) problems.push(`the problem says ${value.status}, the status line ${status}`);
    if (value.request_id !== headers['x-request-id']) problems.push('the problem names another request');
    if ([429, 503].includes(status) && headers['retry-after'] === undefined) problems.push('no Retry-After');
  }
  return problems;
}

let bad = 0;
const seen = new Map();
for (const exchange of exchanges) {
  const {method, target, status} = exchange, problems = problemsOf(exchange);
  const key = `${method} ${findPath(pathOf(target)) ?? '(no such path)'}`;
  seen.set(key, (seen.get(key) ?? 0) + 1);
  if (problems.length === 0) continue;
  if (++bad <= 50) console.log(`${method} ${target.slice(0, 200)} -> ${status}: ${problems.join('; ')}`);
}
for (const [key, count] of [...seen].sort()) console.log(`${String(count).padStart(6)} ${key}`);
const undone = [];
for (const [path, item] of Object.entries(document.paths))
  for (const verb of ['get', 'put', 'post', 'delete'])
    if (item[verb] && !seen.has(`${verb.toUpperCase()} ${path}`)) undone.push(`${verb.toUpperCase()} ${path}`);
if (undone.length > 0) console.log(`described and never asked: ${undone.join(', ')}`);
console.log(`${exchanges.length} exchanges, ${bad} not as described`);
process.exit(bad === 0 && undone.length === 0 ? 0 : 1);
