// Failures, in the server's words: files that are broken, empty, huge or not meshes; a server that is away; a token.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import os from 'node:os';
import path from 'node:path';
import { after, before, describe, test } from 'node:test';
import { Bench, drop, eventually, pictures, problem, realServer, serious, shown, skip, state } from './support.mjs';

const SHEET = 'v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n';

describe('in trouble', { skip, timeout: 300_000 }, () => {
  let bench;
  before(async () => {
    bench = await Bench.start();
  });
  after(() => bench?.stop());

  test('files that are no use, and the next one that is', async () => {
    const opened = await bench.open(), { page } = opened;
    const files = [
      ['empty.obj', '', /0 bytes/], ['broken.glb', 'glTF and nothing else', /./], ['holiday.txt', 'a text', /format|mesh/i],
      ['soup.stl', Buffer.alloc(84 + 50), /./],
    ];
    for (const [name, data, expected] of files) {
      await page.evaluate(() => globalThis.fracture.dismiss());
      await drop(page, [{ name, data }]);
      const said = await problem(page);
      console.log(`${name}: ${said.name}: ${said.detail || said.title}`);
      assert.match(`${said.title} ${said.detail}`, expected);
      await page.waitForSelector('[role=alert]');
    }
    // The page can repair sheets, and shows the place of the problem.
    await page.evaluate(() => globalThis.fracture.dismiss());
    await drop(page, [{ name: 'sheet.obj', data: SHEET }]);
    assert.equal((await problem(page)).name, 'mesh-not-closed');
    await page.screenshot({ path: path.join(pictures, 'refused.png') });
    await page.getByRole('button', { name: /thick$/ }).first().click();
    await shown(page);
    assert.ok(await state(page, s => s.wish.settings.thickness > 0 && s.shown.answer.fragments.length > 1));
    assert.deepEqual(serious(opened.complaints), []);
    assert.deepEqual(await page.evaluate(() => globalThis.violations), []);
    await opened.close();
  });

  test('a file that is refused takes nothing away, and one that was read gives back what it took', async () => {
    const opened = await bench.open({ hash: '#sample=cube&set={"material":"stone","fragments":8}' }), { page } = opened;
    await page.evaluate(() => globalThis.fracture.breaking.setParameter('fragments', 12));
    await shown(page);
    const now = () => state(page, s => [s.source?.label, s.shown?.answer.head.etag, globalThis.fracture.breaking.canUndo, globalThis.fracture.view.batch?.pieces.length]);
    const before = await now();
    assert.deepEqual([before[0], before[2], before[3]], ['cube', true, 12]);
    // A GLB whose triangles the page can read, but which the server refuses, because its indices are out of range.
    const bad = await page.evaluate(() => [...globalThis.fracture.state.source.input.data]);
    const json = Buffer.from(bad).subarray(20, 20 + Buffer.from(bad).readUInt32LE(12)).toString().replace(/"SCALAR"/, '"VEC2"  ').slice(0, Buffer.from(bad).readUInt32LE(12));
    const files = [['empty.obj', ''], ['holiday.txt', 'a text'], ['broken.glb', 'glTF and nothing else'],
      ['refused.glb', Buffer.concat([Buffer.from(bad).subarray(0, 20), Buffer.from(json), Buffer.from(bad).subarray(20 + json.length)])],
      ['lost.obj', 'v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\nf 1 2 9\n'], ['half.stl', 'solid half\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 x\n']];
    for (const [name, data] of files) {
      await page.evaluate(() => globalThis.fracture.dismiss());
      await drop(page, [{ name, data }]);
      console.log(`${name}: ${(await problem(page)).name}`);
      assert.deepEqual(await now(), before, name);
    }
    await page.evaluate(() => globalThis.fracture.dismiss());
    await drop(page, [{ name: 'sheet.obj', data: SHEET }]);
    assert.equal((await problem(page)).name, 'mesh-not-closed');
    await page.getByRole('button', { name: 'Back to cube' }).waitFor();
    await page.keyboard.press('Control+z');
    await shown(page);
    assert.deepEqual(await now(), before);
    await page.keyboard.press('Control+z');
    await page.waitForFunction(() => globalThis.fracture.state.shown.answer.fragments.length === 8);
    assert.deepEqual(serious(opened.complaints), []);
    await opened.close();
  });

  test('of two meshes that are dropped one is taken, and the other is named', async () => {
    const opened = await bench.open(), { page } = opened, faces = 'f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n';
    const box = size => [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]].map(at => `v ${at.map(k => k * size).join(' ')}\n`).join('') + faces;
    await drop(page, [{ name: 'small.obj', data: box(1) }, { name: 'large.obj', data: `${box(2)}# and a remark\n` }]);
    await page.waitForFunction(() => globalThis.fracture.state.source?.label === 'large.obj');
    await shown(page);
    const notice = page.locator('.remark');
    await eventually(() => notice.textContent(), said => assert.match(said, /large\.obj was opened.*small\.obj was not opened/s));
    await notice.getByRole('button', { name: 'Dismiss' }).click();
    await notice.waitFor({ state: 'detached' });
    assert.deepEqual(serious(opened.complaints), []);
    await opened.close();
  });

  test('a mesh that is larger than the server takes', async () => {
    const opened = await bench.open(), { page } = opened, file = path.join(os.tmpdir(), `fracture-page-${process.pid}.stl`);
    const bytes = Buffer.alloc(65 << 20);
    bytes.writeUInt32LE((bytes.length - 84) / 50 | 0, 80);
    fs.writeFileSync(file, bytes);
    try {
      await page.keyboard.press('1');
      await page.setInputFiles('input[type=file] >> nth=0', file);
      const said = await problem(page, 60_000);
      assert.match(said.name, /body-too-large|too-large/);
    } finally {
      fs.rmSync(file);
    }
    assert.deepEqual(serious(opened.complaints), []);
    await opened.close();
  });

  test('a parameter that is refused: in words, and the next one works', async () => {
    const opened = await bench.open({ hash: '#sample=cube&set={"sites":-5}', wait: false }), { page } = opened;
    const said = await problem(page);
    assert.equal(said.name, 'bad-parameter');
    await page.evaluate(() => globalThis.fracture.breaking.setSettings({ sites: 20 }));
    await shown(page);
    assert.equal(await page.locator('[role=alert]').count(), 0);
    await opened.close();
  });

  test('a default of the page gives way to what somebody sets, and what somebody set does not', async () => {
    const opened = await bench.open({ hash: '' }), { page } = opened;
    assert.equal(await state(page, s => s.shown.wish.settings.fragments), 40, 'which nobody set');
    await page.evaluate(() => globalThis.fracture.breaking.setParameter('levels', [4, 20]));
    await shown(page);
    assert.deepEqual(await state(page, s => [s.shown.wish.settings, s.shown.answer.figures.levels.length, s.problem]), [{ material: 'terracotta', levels: [4, 20] }, 1, undefined]);
    await page.evaluate(() => globalThis.fracture.breaking.setParameter('fragments', 30));
    assert.match((await problem(page)).detail, /'fragments' and 'levels' were both given/);
    await opened.close();
  });

  test('after a change that was refused the picture says that it is not of this request, and Undo goes back to it', async () => {
    const opened = await bench.open({ hash: '#sample=cube&set={"material":"stone","fragments":8}' }), { page } = opened;
    await page.evaluate(() => globalThis.fracture.breaking.setParameter('fragments', 12));
    await shown(page);
    assert.equal(await page.locator('.seal.good').count(), 1);
    await page.evaluate(() => globalThis.fracture.breaking.setParameter('stretch', -3));
    await problem(page);
    await page.locator('.status').getByText('previous result').waitFor();
    assert.deepEqual([await page.locator('.seal.good').count(), await page.locator('.seal.old').count()], [0, 1]);
    await page.screenshot({ path: path.join(pictures, 'earlier.png') });
    await page.evaluate(() => globalThis.fracture.dismiss());
    await page.locator('.status').getByText('previous result').waitFor();
    await page.getByRole('button', { name: 'Undo' }).click();
    await shown(page);
    assert.deepEqual(await state(page, s => [s.wish.settings, s.shown.answer.fragments.length]), [{ material: 'stone', fragments: 12 }, 12]);
    assert.equal(await page.locator('.seal.good').count(), 1);
    await page.getByRole('button', { name: 'Undo' }).click();
    await page.waitForFunction(() => globalThis.fracture.state.shown.answer.fragments.length === 8);
    await opened.close();
  });

  test('what takes longer than a moment is a job, with progress, and can be cancelled', async () => {
    const opened = await bench.open({ hash: '#sample=cube&set={"sites":20}' }), { page } = opened;
    await page.route('**/fracture', async route => {
      const request = route.request(), { priority } = request.headers();
      if (priority !== 'u=1') return route.continue();
      return route.fulfill({ status: 504, contentType: 'application/problem+json', body: JSON.stringify({ type: '/problems/deadline-exceeded', title: 'Too late', status: 504, detail: '' }) });
    });
    await page.evaluate(() => globalThis.fracture.breaking.setParameter('sites', 60));
    await shown(page);
    assert.equal(await state(page, s => s.shown.answer.fragments.length), 60);
    await page.evaluate(() => globalThis.fracture.breaking.setSettings({ sites: 60_000, rough_amplitude: 0.05 }));
    await page.getByRole('button', { name: 'Cancel' }).click();
    await page.waitForFunction(() => !globalThis.fracture.state.job);
    assert.equal(await state(page, s => s.shown.answer.fragments.length), 60, 'what was there stays');
    await opened.close();
  });

  test('the server goes and comes back', async t => {
    const server = await realServer(), own = await Bench.start({ server });
    t.after(() => own.stop());
    const opened = await own.open(), { page } = opened;
    await server.kill();
    await page.evaluate(() => globalThis.fracture.breaking.setParameter('fragments', 25));
    await page.waitForSelector('.server.absent');
    await page.screenshot({ path: path.join(pictures, 'away.png') });
    own.server = await realServer({ port: server.port });
    await page.waitForSelector('.server.ready');
    await shown(page);
    assert.equal(await state(page, s => s.shown.answer.parameters.fragments), 25, 'what was asked while it was away');
    await opened.close();
  });

  test('Play while the server is away, or has another page by now: in plain words, with the way out', async () => {
    const opened = await bench.open({ hash: '#sample=cube&set={"material":"stone","fragments":8}' }), { page } = opened, alert = page.getByRole('alert');
    const play = () => page.getByRole('button', { name: 'Play', exact: true }).click(), playing = () => page.getByRole('button', { name: 'Throw a ball' }).waitFor().catch(async error => {
      throw new Error(`${error.message} ${await state(page, s => JSON.stringify([s.play, s.problem, globalThis.fracture.service.state]))}`);
    });
    bench.site.away = true;
    await play();
    await alert.getByText('The server does not answer').waitFor();
    assert.doesNotMatch(await alert.textContent(), /module|Error in the page/);
    bench.site.away = false;
    await page.waitForSelector('.server.ready');
    await alert.waitFor({ state: 'detached' });
    await play();
    await playing();
    // Another build: the module that is loaded later does not link with this page, or it links but belongs to another page.
    for (const body of ["import { no } from './shared.js'; export const startPlay = no;", 'export const startPlay = () => {}, build = "of another page";']) {
      await page.reload();
      await shown(page);
      bench.site.instead.set('/page/play.js', Buffer.from(body));
      await play();
      await alert.getByText('The server has another version of this page').waitFor();
      assert.doesNotMatch(await alert.textContent(), /export|module|Error in the page/);
      bench.site.instead.delete('/page/play.js');
      await alert.getByRole('button', { name: 'Reload the page' }).click();
      await page.waitForFunction(() => globalThis.fracture && !globalThis.fracture.state.problem);
      await shown(page);
      await play();
      await playing();
    }
    await opened.close();
  });

  test('a token is asked for, kept in memory, and forgotten', async t => {
    const file = path.join(os.tmpdir(), `fracture-page-${process.pid}.tokens`);
    fs.writeFileSync(file, 'artist very-secret-token-of-a-test\n', { mode: 0o600 });
    const server = await realServer({ flags: ['--token-file', file] });
    const own = await Bench.start({ server });
    t.after(() => own.stop());
    const opened = await own.open({ wait: false }), { page } = opened;
    await page.fill('#token', 'another');
    await page.keyboard.press('Enter');
    await page.waitForSelector('dialog .red');
    await page.fill('#token', 'very-secret-token-of-a-test');
    await page.keyboard.press('Enter');
    await shown(page);
    assert.equal(await page.evaluate(() => Object.keys(localStorage).length + Object.keys(sessionStorage).length + document.cookie.length), 0);
    await page.keyboard.press('4');
    await eventually(() => page.locator('textarea.code').inputValue(), line => assert.match(line, /\$TOKEN/));
    assert.doesNotMatch(await page.content(), /very-secret/);
    assert.doesNotMatch(page.url(), /very-secret/);
    fs.rmSync(file);
    assert.deepEqual(serious(opened.complaints), []);
    await opened.close();
  });

  test('a link to a mesh that the server has forgotten asks for the file', async () => {
    const opened = await bench.open(), { page } = opened, { createHash } = await import('node:crypto');
    const box = 'v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nf 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n';
    const id = `sha256:${createHash('sha256').update(box).digest('hex')}`;
    await page.goto(`${bench.site.url}/#mesh=${id}&name=box.obj&set={"sites":9}`);
    await page.waitForFunction(() => globalThis.fracture.state.wanted);
    await drop(page, [{ name: 'box.obj', data: box }]);
    await shown(page);
    assert.deepEqual(await state(page, s => [s.source.mesh.id, s.shown.answer.fragments.length, s.note]), [id, 9, undefined]);
    await opened.close();
  });

  test('without WebGL: no picture, and everything else', async t => {
    const own = await Bench.start({ flags: ['--disable-3d-apis'] });
    t.after(() => own.stop());
    const opened = await own.open({ wait: false }), { page } = opened;
    await page.waitForFunction(() => globalThis.fracture?.state.shown);
    await page.locator('.instead').getByText(/WebGL/).waitFor();
    await page.keyboard.press('1');
    await page.locator('#panel').getByText('Triangles').first().waitFor();
    const [file] = await Promise.all([page.waitForEvent('download'), page.keyboard.press('d')]);
    assert.match(file.suggestedFilename(), /\.glb$/);
    await page.screenshot({ path: path.join(pictures, 'no-webgl.png') });
    await opened.close();
  });
});
