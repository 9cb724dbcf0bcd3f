// Every control can be reached on screens of four sizes and with a finger: none is cut off or covered, none is too small for a thumb, and
// nothing scrolls sideways.
import assert from 'node:assert/strict';
import path from 'node:path';
import { after, before, describe, test } from 'node:test';
import { Bench, pictures, skip } from './support.mjs';

/** Pixels. Controls of the panel may be closer together if there is room and the pointer is exact. */
const LEAST = 32, CLOSE = 24;

describe('on a small screen', { skip, timeout: 300_000 }, () => {
  let bench;
  before(async () => {
    bench = await Bench.start();
  });
  after(() => bench?.stop());

  /** Returns the faults of the controls in a part of the page. */
  const wrong = (page, within, least) => page.evaluate(([part, size]) => {
    const out = [], root = document.querySelector(part), outer = root.getBoundingClientRect(), panel = root.classList.contains('panel-body');
    if (root.scrollWidth > root.clientWidth) out.push(`${part} is scrolled sideways`);
    if (document.documentElement.scrollWidth > innerWidth) out.push('the page is scrolled sideways');
    for (const control of root.querySelectorAll('button, select, input, a.button, label.button, label.check, summary, textarea')) {
      // The label is the target of a check box, the width of a bar has a meaning, and the file input is behind its label.
      if (control.matches('[type=checkbox], .hidden-input, .histogram button') || !control.checkVisibility()) continue;
      const name = `${control.tagName} ${(control.ariaLabel || control.id || control.textContent).trim().slice(0, 30)}`;
      if (panel) control.scrollIntoView({ block: 'center' });
      const { left, right, top, bottom, width, height } = control.getBoundingClientRect();
      const thin = control.matches('[type=range]') ? Math.min(height + 10, size) : height;  // its track can also be hit slightly above and below
      if (width < size || thin < size) out.push(`${name} is ${Math.round(width)} x ${Math.round(height)}`);
      if (left < outer.left - 0.5 || right > outer.right + 0.5 || (!panel && (top < outer.top - 0.5 || bottom > outer.bottom + 0.5))) out.push(`${name} is cut`);
      if (control.scrollWidth > control.clientWidth + 1 && control.matches('button, .button')) out.push(`${name}: its words are cut`);
      const hit = document.elementFromPoint((left + right) / 2, (top + bottom) / 2);
      if (!control.disabled && hit !== control && !control.contains(hit)) out.push(`${name} is covered by ${hit?.tagName} ${hit?.className}`);
    }
    const floating = [...root.querySelectorAll('.floating')].filter(each => each.checkVisibility()).map(each => ({ name: each.className, box: each.getBoundingClientRect() }));
    for (const [k, { name, box }] of floating.entries())
      for (const { name: other, box: of } of floating.slice(k + 1))
        if (box.left < of.right && of.left < box.right && box.top < of.bottom && of.top < box.bottom) out.push(`${name} lies over ${other}`);
    return out;
  }, [within, least]);

  for (const [width, height, finger] of [[360, 740, false], [360, 740, true], [400, 800, false], [768, 1024, false], [1280, 800, false]])
    test(`${width} x ${height}${finger ? ', with a finger' : ''}`, async () => {
      const touch = finger ? { hasTouch: true, isMobile: true } : {};
      // With levels the dock shows all its controls.
      const opened = await bench.open({ hash: '#sample=vase&set={"material":"terracotta","levels":[6,30]}', width, height, ...touch }), { page } = opened;
      const least = width <= 760 || finger ? LEAST : CLOSE, name = path.join(pictures, `small-${width}${finger ? '-finger' : ''}`);
      await page.getByRole('slider', { name: 'Level' }).waitFor();
      assert.deepEqual(await wrong(page, 'header', width <= 760 ? LEAST : 28), []);
      assert.deepEqual(await wrong(page, '.samples', least), [], 'the samples');
      assert.deepEqual(await wrong(page, '#viewport', LEAST), [], 'at the bench');
      await page.screenshot({ path: `${name}.png` });
      const under = await page.evaluate(() => {
        const { left, right, top, bottom } = document.querySelector('.status b').getBoundingClientRect();
        return document.elementFromPoint((left + right) / 2, (top + bottom) / 2).tagName;
      });
      assert.equal(under, 'CANVAS', 'a handle is dragged that lies under the words of the status');
      // With a selected and a hidden fragment the list has all its controls.
      await page.evaluate(() => {
        const { fracture } = globalThis, [one, other] = fracture.state.shown.answer.fragments;
        fracture.choose([other.id]);
        fracture.hideChosen();
        fracture.choose([one.id]);
      });
      for (const tab of ['Mesh', 'Fragments', 'Export', 'Break']) {
        await page.getByRole('tab', { name: tab }).click();
        await page.waitForFunction(said => document.querySelector('#panel').getAttribute('aria-labelledby') === said, `tab-${{ Fragments: 'pieces', Export: 'take' }[tab] ?? tab.toLowerCase()}`);
        if (tab === 'Break') await page.getByRole('button', { name: /All parameters/ }).click().then(() => page.getByRole('button', { name: 'Fewer' }).waitFor());
        assert.deepEqual(await wrong(page, '.panel-body', least), [], tab);
      }
      // Longer texts: a job, a request without a result, a long name.
      const say = change => page.evaluate(async given => {
        const { fracture } = globalThis;
        fracture.set(given === 'unmet' ? { wish: { settings: { fragments: 3 }, hits: [] }, unmet: undefined } : given);
        if (given === 'unmet') fracture.set({ unmet: fracture.state.wish });
        await new Promise(resolve => requestAnimationFrame(() => requestAnimationFrame(resolve)));
      }, change);
      for (const change of [{ job: { state: 'queued', queue_position: 12, percent: 0, stage: '' } }, { job: { state: 'running', percent: 45, stage: 'tetrahedralize' } },
        { job: null, bringing: `${'a_long_name_'.repeat(6)}.glb` }, { bringing: null }, 'unmet']) {
        await say(change);
        assert.deepEqual(await wrong(page, '#viewport', LEAST), [], JSON.stringify(change));
      }
      await page.keyboard.press('p');
      await page.waitForFunction(() => globalThis.fracture.physics);
      assert.deepEqual(await wrong(page, '#viewport', LEAST), [], 'at Play');
      await page.screenshot({ path: `${name}-play.png` });
      await page.getByRole('button', { name: 'Stop playing' }).click();
      assert.deepEqual(opened.complaints, []);
      await opened.close();
    });
});
