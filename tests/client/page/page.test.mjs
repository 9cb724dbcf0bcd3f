// The page as a person uses it: it opens with a broken sample, breaks where it is clicked, follows a slider, and goes back and forth.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import path from 'node:path';
import { after, before, describe, test } from 'node:test';
import { Bench, clean, eventually, onMesh, pictures, require, shown, skip, state } from './support.mjs';

describe('the page', { skip, timeout: 300_000 }, () => {
  let bench;
  before(async () => {
    bench = await Bench.start();
  });
  after(() => bench?.stop());

  test('opens with a sample that is broken', async () => {
    await (await bench.open()).close();  // the browser's own start is not the page's
    const opened = await bench.open(), { page } = opened;
    const { interactive, first } = await page.evaluate(() => {
      const [paint] = performance.getEntriesByName('first-contentful-paint'), { at } = globalThis.fracture.marks;
      return { interactive: at.picture, first: paint?.startTime };
    });
    console.log(`first paint ${first?.toFixed(0)} ms, something broken ${interactive.toFixed(0)} ms after the navigation began`);
    assert.ok(interactive > 0);
    assert.equal(await state(page, s => s.shown.answer.fragments.length > 30 && s.shown.answer.certificate.open_edges), 0);
    await page.screenshot({ path: path.join(pictures, 'open.png') });
    await clean(opened);
    await opened.close();
  });

  test('breaks where it is clicked, and again', async () => {
    const opened = await bench.open(), { page } = opened, whole = await state(page, s => s.shown.answer.fragments.length);
    await page.mouse.click(...await onMesh(page));
    await shown(page);
    assert.equal(await state(page, s => s.wish.settings.impacts.length), 1, 'the first click is where it was hit');
    assert.equal(await state(page, s => s.wish.hits.length), 1, 'and breaks what is near');
    const first = await state(page, s => s.shown.answer.fragments.length);
    assert.ok(first > whole, `${first} fragments of ${whole}`);
    const before = bench.site.passed.length;
    await page.mouse.click(...await onMesh(page));
    await shown(page);
    const asked = bench.site.passed.slice(before).filter(({ path: at }) => at.endsWith('/fracture'));
    assert.match(asked[0].body, /"delta":"only".*"of":"\/fractures\//, 'the next one is a hit on the answer');
    const after = await state(page, s => s.shown.answer.fragments.length);
    assert.ok(after > first, `${after} fragments of ${first}`);
    await page.keyboard.press('Control+z');
    await page.waitForFunction(() => globalThis.fracture.state.shown.wish.hits.length === 1);
    await page.keyboard.press('Control+z');
    await page.waitForFunction(() => !globalThis.fracture.state.shown.wish.settings.impacts);
    await page.keyboard.press('Control+y');
    await page.keyboard.press('Control+y');
    await page.waitForFunction(count => globalThis.fracture.state.shown.answer.fragments.length === count, after);
    await clean(opened);
    await opened.close();
  });

  test('a slider that is dragged: three requests at most, the last one wins, no stale picture', async () => {
    const opened = await bench.open({ hash: '#sample=cube&set={"material":"stone","fragments":20}' }), { page } = opened;
    // With a delay for some answers, later answers overtake earlier ones.
    bench.site.delay = 60;
    bench.site.most = 0;
    await page.evaluate(() => {
      globalThis.pictures = [];
      const { view } = globalThis.fracture, show = view.show.bind(view);
      view.show = (answer, isNew) => (globalThis.pictures.push(answer.parameters.fragments), show(answer, isNew));
    });
    const slider = page.locator('.control:has(#p-fragments) input[type=range]');
    await slider.scrollIntoViewIfNeeded();
    const { x, y, width, height } = await slider.boundingBox();
    await page.mouse.move(x + 12, y + height / 2);
    await page.mouse.down();
    for (let k = 1; k <= 30; ++k) {
      await page.mouse.move(x + 12 + (width - 40) * k / 30, y + height / 2);
      await page.waitForTimeout(16);  // pause: a hand that moves
    }
    await page.mouse.up();
    await shown(page);
    const wanted = await state(page, s => s.wish.settings.fragments), seen = await page.evaluate(() => globalThis.pictures);
    bench.site.delay = 0;
    console.log(`${seen.length} pictures of 30 values: ${seen.join(' ')}; at most ${bench.site.most} requests in flight`);
    assert.ok(bench.site.most <= 3, `${bench.site.most} in flight`);
    assert.equal(seen.at(-1), wanted, 'the last value is in the picture');
    assert.deepEqual(seen, [...seen].sort((a, b) => a - b), 'never an older picture after a newer one');
    assert.equal(await state(page, s => s.shown.answer.parameters.fragments), wanted);
    assert.ok(seen.length >= 3, 'pictures came while it was dragged');
    await clean(opened);
    await opened.close();
  });

  test('every panel, look and sheet; the keyboard is enough', async () => {
    const opened = await bench.open(), { page } = opened;
    for (const key of ['1', '3', '4', '2', 'c', 'c', 'w', 'w', 'b', 'b', 'k', 'k', 'k', 'e', 'e', 'f', '?', 'Escape', ']', '[', 's', 'a', 'h']) await page.keyboard.press(key);
    await page.focus('canvas');
    await page.keyboard.press('ArrowLeft');
    await page.keyboard.press('+');
    await page.keyboard.press('Enter');
    await page.waitForFunction(() => globalThis.fracture.state.wish.settings.impacts);
    await shown(page);
    await page.keyboard.press('3');
    await page.getByRole('button', { name: 'Smallest' }).click();
    const smallest = await state(page, s => s.shown.answer.fragments.reduce((a, b) => (b.volume < a.volume ? b : a)).id);
    await eventually(() => state(page, s => [...s.look.chosen]), chosen => assert.deepEqual(chosen, [smallest]));
    await page.keyboard.press('4');
    await eventually(() => page.locator('textarea.code').inputValue(), line => assert.match(line, /^curl --fail-with-body -F mesh=@vase\.glb/));
    const [file] = await Promise.all([page.waitForEvent('download'), page.keyboard.press('d')]);
    assert.equal(fs.readFileSync(await file.path()).subarray(0, 4).toString(), 'glTF');
    await clean(opened);
    await opened.close();
  });

  test('parameters are those of the server: one that is new appears', async () => {
    const opened = await bench.open({ wait: false }), { page } = opened;
    await page.route('**/limits', async route => {
      const answer = await route.fetch(), json = await answer.json();
      json.parameters.push({ name: 'quite_new', type: 'number', minimum: 0, maximum: 1, default: 0.25, description: 'Something that this page has never heard of.' });
      await route.fulfill({ response: answer, json });
    });
    await page.reload();
    await shown(page);
    await page.getByRole('button', { name: /All parameters/ }).click();
    await page.fill('input[type=search]', 'never heard');
    await eventually(() => page.locator('#p-quite_new').inputValue(), value => assert.equal(value, '0.25'));
    await clean(opened);
    await opened.close();
  });

  test('the seal says what it stands for, and a red one what is wrong', async () => {
    const opened = await bench.open(), { page } = opened, sheet = page.getByRole('dialog');
    await page.locator('.status').getByRole('button', { name: 'Proved' }).click();
    await sheet.getByText(/Every fragment is closed/).first().waitFor();
    assert.equal(await sheet.locator('.red').count(), 0);
    await sheet.getByRole('button', { name: 'Close' }).click();
    // The server sends only proved answers, so the test makes an unproved one.
    await page.evaluate(() => {
      const { state, set } = globalThis.fracture, { shown } = state, answer = Object.create(shown.answer, { certificate: { value: { ...shown.answer.certificate, open_edges: 2 } } });
      set.call(globalThis.fracture, { shown: { ...shown, answer } });
    });
    await page.locator('.status').getByRole('button', { name: 'Not proved' }).click();
    await sheet.locator('.red').first().waitFor();
    await eventually(() => sheet.locator('.red').allTextContents(), said => assert.equal(said.join().replace(/\s+/g, ' ').trim(), '2 must be 0'));
    await clean(opened);
    await opened.close();
  });

  test('a link shows the same again', async () => {
    const opened = await bench.open({ hash: '#sample=torus&set={"material":"ceramic","fragments":33,"seed":5}' }), { page } = opened;
    assert.deepEqual(await state(page, s => [s.source.label, s.shown.answer.parameters.fragments, s.shown.answer.parameters.seed]), ['torus', 33, 5]);
    await page.mouse.click(...await onMesh(page));
    await shown(page);
    await page.waitForFunction(() => location.hash.includes('impacts'));
    const digest = await state(page, s => s.shown.answer.head.etag), again = await bench.open({ hash: new URL(page.url()).hash });
    assert.equal(await state(again.page, s => s.shown.answer.head.etag), digest);
    await clean(again);
    await again.close();
    await opened.close();
  });

  test('no serious complaint of axe, dark and light, wide and narrow', async () => {
    const axe = fs.readFileSync(require.resolve('axe-core/axe.min.js'), 'utf8');
    for (const [colorScheme, width, height] of [['dark', 1024, 700], ['light', 360, 740]]) {
      const { page, close } = await bench.open({ colorScheme, width, height, bypassCSP: true });
      await page.evaluate(axe);
      const check = async what => {
        const { violations } = await page.evaluate(() => globalThis.axe.run(document, { resultTypes: ['violations'] }));
        const bad = violations.filter(({ impact }) => impact === 'serious' || impact === 'critical');
        assert.deepEqual(bad.map(({ id, nodes }) => `${id}: ${nodes.map(({ html }) => html.slice(0, 160)).join(' | ')}`), [], `${what}, ${colorScheme}`);
      };
      for (const tab of ['Mesh', 'Break', 'Fragments', 'Export']) {
        await page.getByRole('tab', { name: tab }).click();
        if (tab === 'Break') await page.getByRole('button', { name: /All parameters/ }).click();
        await page.waitForFunction(name => document.querySelector('[role=tab][aria-selected=true]').textContent === name, tab);
        await check(tab);
      }
      await page.keyboard.press('?');
      await check('keys');
      const across = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
      assert.ok(across <= 0, `${across} pixels wider than the screen`);
      await close();
    }
  });

  test('the way back from the documents leads to what was there, and without one to a new page', async () => {
    const opened = await bench.open({ hash: '#sample=cube&set={"material":"stone","fragments":20}' }), { page } = opened;
    await page.evaluate(() => globalThis.fracture.breaking.setParameter('fragments', 23));
    await shown(page);
    await page.waitForFunction(() => location.hash.includes('23'));
    const address = page.url();
    await page.getByRole('link', { name: 'Documentation' }).click();
    await page.locator('.docs-nav').getByRole('link', { name: 'HTTP interface' }).click();
    // Links that are followed there add entries to the history.
    await page.locator('.docs-nav').getByRole('link', { name: 'POST /fracture', exact: true }).click();
    await page.locator('.docs-nav').getByRole('link', { name: /^Parameters \(/ }).click();
    await page.getByRole('link', { name: 'Back to the main page' }).click();
    await page.waitForURL(address);
    await shown(page);
    assert.deepEqual(await state(page, s => [s.source.label, s.shown.answer.fragments.length]), ['cube', 23]);
    assert.deepEqual(opened.complaints, []);
    await opened.close();
    const direct = await bench.open({ path: '/docs', wait: false });
    await direct.page.getByRole('link', { name: 'Back to the main page' }).click();
    await direct.page.waitForURL(url => url.pathname === '/');
    await shown(direct.page);
    await direct.close();
  });

  test('dark or light as it was chosen, also after a reload and in the interface for people', async () => {
    const opened = await bench.open({ colorScheme: 'dark' }), { page } = opened, ground = () => page.evaluate(() => getComputedStyle(document.body).backgroundColor);
    const dark = await ground();
    await page.getByRole('button', { name: 'Dark or light' }).click();
    const light = await ground();
    assert.notEqual(light, dark);
    await page.reload();
    await shown(page);
    assert.equal(await ground(), light);
    await page.goto(`${bench.site.url}/docs`);
    await page.waitForSelector('article');
    assert.equal(await ground(), light);
    await page.goto(bench.site.url);
    await shown(page);
    await page.getByRole('button', { name: 'Dark or light' }).click();
    assert.equal(await ground(), dark);
    await clean(opened);
    await opened.close();
  });

  test('a browser that keeps nothing shows the page all the same', async () => {
    const opened = await bench.open({ wait: false, colorScheme: 'dark' }), { page } = opened;
    await page.addInitScript(() => Object.defineProperty(globalThis, 'localStorage', { get: () => {
      throw new DOMException('', 'SecurityError');
    } }));
    await page.reload();
    await shown(page);
    await page.getByRole('button', { name: 'Dark or light' }).click();
    assert.equal(await page.evaluate(() => document.documentElement.dataset.theme), 'light');
    await clean(opened);
    await opened.close();
  });

  test('a number of pieces that is another one than was asked for is explained, and so is a hit that nobody made', async () => {
    const opened = await bench.open({ hash: '#sample=vase&set={"material":"terracotta","fragments":40}' }), { page } = opened, panel = page.locator('#panel');
    assert.equal(await panel.getByText(/requested/).count(), 0);
    await page.getByRole('tab', { name: 'Fragments' }).click();
    assert.equal(await panel.getByText('Warnings').count(), 0);
    await panel.getByText('Notes').click();
    await panel.getByText(/^No impact point is set/).waitFor();
    await page.getByRole('tab', { name: 'Break' }).click();
    await page.mouse.click(...await onMesh(page));
    await shown(page);
    const made = await state(page, s => s.shown.answer.fragments.length);
    await panel.getByText(`40 requested, ${made} made: the hit broke off additional pieces.`).waitFor();
    await clean(opened);
    await opened.close();
  });

  test('what these tests allow the page is what the server allows it', async () => {
    for (const at of ['/', '/docs']) {
      const [own, real] = await Promise.all([bench.site.url, bench.server.url].map(url => fetch(url + at, { headers: { Accept: 'text/html' } })));
      for (const name of ['content-security-policy', 'referrer-policy', 'x-content-type-options', 'cache-control'])
        assert.equal(own.headers.get(name), real.headers.get(name), `${name} of ${at}`);
    }
  });

  test('files are asked for again by their ETag', async () => {
    const first = await fetch(`${bench.site.url}/page/app.js`), tag = first.headers.get('etag');
    await first.arrayBuffer();
    assert.equal((await fetch(`${bench.site.url}/page/app.js`, { headers: { 'If-None-Match': tag } })).status, 304);
  });
});
