// The documents at /docs in a browser: lists, addresses, the search with the keyboard, small screens, servers with tokens.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import { after, before, describe, test } from 'node:test';
import { Bench, clean, eventually, require, serious, skip } from './support.mjs';

describe('the documents', { skip, timeout: 300_000 }, () => {
  let bench;
  before(async () => {
    bench = await Bench.start();
  });
  after(() => bench?.stop());

  test('the interface for people', async () => {
    const opened = await bench.open({ path: '/docs', hash: '#post /fracture', wait: false }), { page } = opened;
    await page.waitForSelector('article[id="post /fracture"]');
    assert.doesNotMatch(await page.locator('main > p').first().textContent(), /this file|edit/i, 'it is about the service, not about how its document is made');
    await page.keyboard.press('/');
    await page.keyboard.type('restitution');
    await page.locator('#found').getByRole('option', { name: /^restitution HTTP interface/ }).click();
    await page.waitForFunction(() => location.hash === '#parameter%20restitution' && scrollY > 0);
    await clean(opened);
    await opened.close();
  });

  test('documents are listed, searched with the keyboard, and kept in the history', async () => {
    const opened = await bench.open({ path: '/docs', wait: false }), { page } = opened, title = () => page.locator('main h1').textContent(), field = page.getByRole('combobox');
    await page.waitForSelector('article');
    assert.equal(await title(), 'fracture', 'the first document');
    await page.locator('.docs-nav').getByRole('link', { name: 'Install', exact: true }).click();
    await eventually(title, found => assert.equal(found, 'Install'));
    assert.equal(await page.locator('.docs-nav a[aria-current=page]').textContent(), 'Install');
    await page.keyboard.press('/');
    await page.keyboard.type('Keep a REGION');
    const chosen = page.locator('#found [aria-selected=true]'), best = await chosen.textContent();
    assert.match(best, /^\s*Keep a region whole/);
    assert.equal(await field.getAttribute('aria-activedescendant'), await chosen.getAttribute('id'));
    await page.keyboard.press('ArrowDown');
    assert.notEqual(await chosen.textContent(), best);
    await page.keyboard.press('ArrowUp');
    await page.keyboard.press('Enter');
    await page.waitForFunction(() => location.hash === '#proto/guides/keep-a-region-whole.md');
    await eventually(title, found => assert.equal(found, 'Keep a region whole'));
    assert.equal(await page.locator('#found').isVisible(), false);
    await page.keyboard.press('/');
    assert.equal(await page.locator('#found').isVisible(), true, 'what was searched is still there');
    await page.keyboard.press('Escape');
    assert.equal(await page.locator('#found').isVisible(), false);
    await page.goBack();
    await eventually(title, found => assert.equal(found, 'Install'));
    // A place in a document, and then back to the reader's position.
    await page.goto(`${bench.site.url}/docs#server/README.md:exit-codes`);
    await eventually(() => page.locator('[id="server/README.md:exit-codes"]').boundingBox(), box => assert.ok(box.y >= 0 && box.y < 500, `${box.y}`));
    await page.evaluate(() => scrollBy(0, -300));
    await page.waitForFunction(() => history.state?.scrolled === scrollY);  // stored when scrolling has stopped
    const before = await page.evaluate(() => scrollY);
    await page.locator('.docs-nav').getByRole('link', { name: 'Changelog' }).click();
    await eventually(title, found => assert.equal(found, 'Changelog'));
    assert.equal(await page.evaluate(() => scrollY), 0);
    await page.goBack();
    await eventually(() => page.evaluate(() => scrollY), found => assert.equal(found, before));
    await clean(opened);
    await opened.close();
  });

  test('the server itself sends documents and interface', async () => {
    const page = await bench.browser.newPage();
    await page.goto(`${bench.server.url}/docs#proto/interface.md`);
    await page.waitForSelector('article.docs-text');
    assert.equal(await page.locator('main h1').textContent(), 'Requests and answers');
    await page.goto(`${bench.server.url}/docs#post /fracture`);
    await page.waitForSelector('article[id="post /fracture"]');
    await page.close();
  });

  test('documents that cannot be loaded are missed aloud, and the interface is there', async () => {
    const opened = await bench.open({ path: '/docs', wait: false }), { page } = opened;
    await page.route('**/documents.json', route => route.fulfill({ status: 406 }));
    await page.reload();
    await page.getByText('The documents could not be loaded. (406').waitFor();
    await page.waitForSelector('article[id="post /fracture"]');
    await opened.close();
  });

  test('a link to the address that is open goes to its place again', async () => {
    const opened = await bench.open({ path: '/docs', hash: '#server/README.md:exit-codes', wait: false }), { page } = opened, seen = page.locator('[id="server/README.md:exit-codes"]');
    await eventually(() => seen.boundingBox(), box => assert.ok(box.y >= 0 && box.y < 500, `${box.y}`));
    await page.evaluate(() => globalThis.scrollTo(0, 0));
    await page.keyboard.press('/');
    await page.keyboard.type('exit codes');
    await page.waitForSelector('#found [aria-selected=true]');
    await page.keyboard.press('Enter');
    await eventually(() => seen.boundingBox(), box => assert.ok(box.y >= 0 && box.y < 500, `${box.y}`));
    // The reader leaves immediately after a movement, and returns to that position.
    await page.evaluate(() => {
      globalThis.scrollTo(0, 900);
      document.querySelector('.docs-nav a[href="#CHANGELOG.md"]').click();
    });
    await eventually(() => page.locator('main h1').textContent(), found => assert.equal(found, 'Changelog'));
    await page.goBack();
    await eventually(() => page.evaluate(() => scrollY), found => assert.equal(found, 900));
    await opened.close();
  });

  test('documents fit small screens and can be read by all', async () => {
    for (const colorScheme of ['dark', 'light']) {
      const { page, close } = await bench.open({ path: '/docs', hash: '#proto/parameters.md', wait: false, colorScheme, width: 360, height: 640, bypassCSP: true });
      await page.waitForSelector('article');
      await page.evaluate(fs.readFileSync(require.resolve('axe-core/axe.min.js'), 'utf8'));
      const check = async what => {
        const { violations } = await page.evaluate(() => globalThis.axe.run(document, { resultTypes: ['violations'] }));
        assert.deepEqual(violations.map(({ id, nodes }) => `${id}: ${nodes[0].html.slice(0, 160)}`), [], `${what}, ${colorScheme}`);
        const across = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
        assert.ok(across <= 0, `${what}: ${across} pixels wider than the screen`);
      };
      await check('a document');
      await page.getByRole('button', { name: 'Contents' }).click();
      await check('contents');
      await page.locator('.docs-nav').getByRole('link', { name: 'HTTP interface' }).click();
      await page.waitForSelector('article[id="post /fracture"]');
      assert.equal(await page.locator('.docs-nav').isVisible(), false, 'the list closes when something is chosen');
      await check('interface');
      await page.getByRole('combobox').fill('token');
      await page.waitForSelector('#found a');
      await check('search');
      await close();
    }
  });

  test('a server with tokens shows documents to everybody, and its interface to those with a token', async () => {
    const opened = await bench.open({ path: '/docs', wait: false }), { page } = opened;
    await page.route('**/openapi.json', (route, request) => (request.headers().authorization === 'Bearer right' ? route.continue() : route.fulfill({ status: 401 })));
    await page.reload();
    await page.waitForSelector('article');
    await page.locator('.docs-nav').getByRole('link', { name: 'HTTP interface' }).click();
    await page.getByLabel('This server needs a token').fill('right');
    await page.getByRole('button', { name: 'Use it' }).click();
    await page.waitForSelector('article[id="post /fracture"]');
    assert.deepEqual(serious(opened.complaints), []);
    await opened.close();
  });
});
