// The package in Debian's Chromium, with fracture-server (FRACTURE_TEST_SERVER): the game of client/examples/web, and a worker in a page
// that is not a secure context.
import assert from 'node:assert/strict';
import os from 'node:os';
import path from 'node:path';
import { describe, test } from 'node:test';
import { around, bundle, checkSwaps, example, hitIt, noBrowser, pictures, watchFrames } from './browser.mjs';
import { folder, torus } from './support.mjs';

const WORKER = `
  import { Client } from 'fracture-client';
  onmessage = async ({ data: { url, mesh } }) => {
    try {
      const client = new Client(url), put = await client.put({ name: 'größe.obj', data: new Blob([mesh]) });
      const answer = await put.fracture({ sites: 12 }), hit = await answer.hit([1.3, 0, 0], 0.3), percents = [];
      const long = await (await put.job({ sites: 9 })).result({ onProgress: ({ percent }) => percents.push(percent) });
      const { problem } = await put.fracture({ sitess: 1 }).catch(error => error);
      const { name } = await put.fracture({ sites: 5000 }, { signal: AbortSignal.timeout(5) }).catch(error => error);
      postMessage({ id: put.id, secure: isSecureContext, subtle: !!globalThis.crypto?.subtle, fragments: answer.fragments.length, etag: answer.head.etag,
        hit: hit.fragments.length, long: long.fragments.length, percent: percents.at(-1), problem, name });
    } catch (error) {
      postMessage({ error: String(error.stack) });
    }
  };`;

/** Prints the lengths of frames until the swap, the longest after it, and those while fragments fly. */
function tellFrames({ frames, swap, bodies, says }) {
  const lengths = frames.slice(1).map((end, k) => ({ end, length: end - frames[k] })), at = swap.startTime + swap.duration;
  const told = kept => {
    const sorted = lengths.filter(kept).map(({ length }) => length).sort((a, b) => a - b);
    return `${sorted.length} frames, median ${sorted[sorted.length >> 1]?.toFixed()} ms, longest ${sorted.at(-1)?.toFixed()} ms`;
  };
  console.log(`${says}, ${bodies} bodies; load ${os.loadavg()[0].toFixed(1)} on ${os.cpus().length} cores`);
  console.log(`whole: ${told(({ end }) => end <= swap.startTime)}; swap() itself ${swap.duration.toFixed(1)} ms; after it: ${told(({ end }) => end > at)}`);
}

describe('in a browser', { skip: noBrowser }, () => {
  const here = around(async () => ({
    ...await example('web'),
    '/empty': ['text/html', '<!DOCTYPE html><title>empty</title><link rel="icon" href="data:,">'],
    '/worker.js': ['text/javascript', await bundle({ stdin: { contents: WORKER, resolveDir: folder } })],
  }));

  test('a ball breaks a stone in flight', async () => {
    const { page, complaints } = await here.open(`http://127.0.0.1:${here.port}/web/?server=${here.server.url}`);
    const says = (text, timeout = 20_000) => page.waitForFunction(words => document.getElementById('says').textContent.includes(words), text, { timeout });
    await says('Click the stone');
    await page.screenshot({ path: path.join(pictures, 'whole.png') });
    const frames = await watchFrames(page);
    await frames(10);
    await hitIt(page, says);
    await page.waitForFunction(() => globalThis.stone.rigidBodies.length > 1, undefined, { timeout: 15_000 });
    await page.screenshot({ path: path.join(pictures, 'hit.png') });
    await frames(20);
    await page.screenshot({ path: path.join(pictures, 'falling.png') });
    const seen = await page.evaluate(() => ({
      swaps: globalThis.stone.swaps, fragments: globalThis.stone.answer.fragments.length, bodies: globalThis.stone.rigidBodies.length,
      frames: globalThis.frames, says: document.getElementById('says').textContent, swap: performance.getEntriesByName('swap')[0].toJSON(),
    }));
    tellFrames(seen);
    checkSwaps(seen.swaps, 1e-6);
    assert.ok(seen.fragments >= 180 && seen.fragments <= 220, `${seen.fragments}`);
    assert.ok(seen.bodies > 20, `${seen.bodies}`);
    assert.deepEqual(complaints, []);
  });

  test('a worker without WebCrypto', async () => {
    const { page, complaints } = await here.open(`http://game.test:${here.port}/empty`), mesh = torus();
    const said = await page.evaluate(([url, text]) => new Promise(resolve => {
      const worker = new Worker('/worker.js', { type: 'module' });
      worker.onmessage = ({ data }) => resolve(data);
      worker.onerror = event => resolve({ error: event.message });
      worker.postMessage({ url, mesh: text });
    }), [here.server.url, mesh]);
    assert.equal(said.error, undefined);
    const { createHash } = await import('node:crypto');
    assert.equal(said.id, `sha256:${createHash('sha256').update(mesh).digest('hex')}`);
    assert.deepEqual([said.secure, said.subtle, said.problem, said.name, said.percent], [false, false, 'unknown-parameter', 'AbortError', 100]);
    assert.ok(said.fragments === 12 && said.hit > 12 && said.long === 9, JSON.stringify(said));
    assert.match(said.etag, /^"[0-9a-f]+"$/, 'the answer came as it is, so that its digest could be checked');
    // Only the lines that a browser logs about a 400 and about aborted requests.
    assert.deepEqual(complaints.filter(text => !/status of 400|ERR_ABORTED/.test(text)), []);
  });
});
