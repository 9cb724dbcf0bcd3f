// An AbortSignal stops the computation of fracture-server (FRACTURE_TEST_SERVER), from node and from Debian's Chromium, directly and
// through the HAProxy of docker/haproxy. The server's own metrics prove it.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import { before, describe, test } from 'node:test';
import { Admin } from '../../../client/typescript/dist/index.js';
import { around, bundle, noBrowser } from './browser.mjs';
import { Client, eventually, folder, haproxy, noServer, realServer, refusal, torusFile } from './support.mjs';

const LONG = { sites: 20000, lloyd: 50 };  // a minute on one thread
const FLAGS = ['--deadline', '36000'];  // otherwise long requests would be refused
const MOST_AFTER = 2;  // processor seconds of the server after the abort: the computation's, and those of the questions that the test asks
const PATIENT = { timeout: 36e6, deadline: 36e6, retries: 0 };

/** The sum of the server's metrics whose name with its labels equals `name` or matches it. */
async function figure(server, name) {
  const lines = (await new Admin(server.admin).metrics()).split('\n').map(line => [line.slice(0, line.lastIndexOf(' ')), Number(line.slice(line.lastIndexOf(' ') + 1))]);
  return lines.filter(([key]) => (name instanceof RegExp ? name.test(key) : key === name)).reduce((sum, [, value]) => sum + value, 0);
}
/** The processor time that the server has used. Waiting for a busy machine does not count. */
function processorSeconds({ pid }) {
  const stat = fs.readFileSync(`/proc/${pid}/stat`, 'utf8'), fields = stat.slice(stat.lastIndexOf(')') + 2).split(' ');
  return (Number(fields[11]) + Number(fields[12])) / 100;  // user and system, in hundredths of a second
}
const CANCELLED = /^fracture_requests_total\{.*status="499"/;

/**
 * `start(url, parameters)` begins a computation and returns a function that aborts it. `url` is the server's, or that of HAProxy in front
 * of it.
 */
async function check(t, server, start) {
  const proxy = await haproxy(t, server);
  if (!proxy) console.log('skipped: HAProxy is not installed; directly only');
  for (const { url } of [server, ...(proxy ? [proxy] : [])]) {
    const was = await figure(server, CANCELLED);
    const abort = await start(url, { ...LONG, seed: was });
    await eventually('the computation', async () => await figure(server, 'fracture_jobs_running') === 1);
    await abort();
    const used = processorSeconds(server);
    for (const name of ['fracture_jobs_running', 'fracture_flights', 'fracture_memory_reserved_bytes{part="working"}'])
      await eventually(`${name} to be 0, through ${url}`, async () => await figure(server, name) === 0);
    const after = processorSeconds(server) - used;
    assert.ok(after < MOST_AFTER, `${after} processor seconds after the abort, through ${url}`);
    await eventually('the request to be counted as cancelled', async () => await figure(server, CANCELLED) === was + 1);
  }
}

describe('from node', { skip: noServer, timeout: 120_000 }, () => {
  let server, id;
  before(async () => {
    server = await realServer(...FLAGS);
    ({ id } = await new Client(server.url).put(torusFile));
  });

  test('an AbortSignal', t => check(t, server, (url, parameters) => {
    const controller = new AbortController(), asked = refusal(new Client(url, PATIENT).mesh(id).fracture(parameters, { signal: controller.signal }));
    return async () => {
      controller.abort();
      assert.equal((await asked).problem, 'aborted');
    };
  }));
});

describe('from Chromium', { skip: noBrowser, timeout: 120_000 }, () => {
  const here = around(async () => ({
    '/': ['text/html', '<!DOCTYPE html><title>closed</title><link rel="icon" href="data:,"><script type="module" src="/client.js"></script>'],
    '/client.js': ['text/javascript', await bundle({ stdin: { contents: "import { Client } from 'fracture-client';\nglobalThis.Client = Client;", resolveDir: folder } })],
  }), FLAGS);

  /** Opens a page whose request is on its way. */
  async function asking(url, parameters) {
    const { id } = await new Client(here.server.url).put(torusFile), { page } = await here.open(`http://127.0.0.1:${here.port}/`);
    await page.waitForFunction(() => globalThis.Client);
    await page.evaluate(([at, settings, mesh, wanted]) => {
      globalThis.controller = new AbortController();
      globalThis.asked = new globalThis.Client(at, settings).mesh(mesh).fracture(wanted, { signal: globalThis.controller.signal })
        .then(() => 'answered', ({ problem }) => problem);
    }, [url, PATIENT, id, parameters]);
    return page;
  }

  test('an AbortSignal', t => check(t, here.server, async (url, parameters) => {
    const page = await asking(url, parameters);
    return async () => {
      await page.evaluate(() => globalThis.controller.abort());
      assert.equal(await page.evaluate(() => globalThis.asked), 'aborted');
    };
  }));

  test('a page that is closed', t => check(t, here.server, async (url, parameters) => {
    const page = await asking(url, parameters);
    return () => page.close();
  }));
});
