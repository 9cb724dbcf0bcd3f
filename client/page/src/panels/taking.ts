// The export panel: files, the same request elsewhere, a link, presets, a screenshot.
import { html, nothing, type TemplateResult } from 'lit';
import { live } from 'lit/directives/live.js';
import type { App } from '../app/app';
import { copy, saveAs } from '../take/browser';
import { debugInformation } from '../take/debug';
import { saveFigures, saveGlb, saveMesh, savePicture } from '../take/files';
import { linkOf } from '../take/link';
import { presetOf, readPreset } from '../take/presets';
import { snippets } from '../take/snippets';
import { words } from '../words/words';
import { bytes } from './format';
import { icons } from './icons';

let kind: keyof ReturnType<typeof snippets> = 'curl';
let copied = '';

export function takePanel(app: App): TemplateResult {
  const { shown, source } = app.state;
  const copyButton = (key: string, label: string, text: () => string) => html`<button @click=${async () => {
    if (!await copy(text())) return;
    copied = key;
    app.set({});
    setTimeout(() => {
      copied = '';
      app.set({});
    }, 1500);
  }}>${icons.copy} <span aria-live="polite">${copied === key ? words.take.copied : label}</span></button>`;
  const debug = html`<section>${copyButton('debug', words.take.debug, () => debugInformation(app))}<p class="hint">${words.take.debugHint}</p></section>`;
  if (!shown || !source) return html`<p class="hint">${words.take.none}</p>${presets(app)}${debug}`;
  const texts = snippets(app);
  return html`
    <section aria-label=${words.take.glb}>
      <button class="primary wide" @click=${() => saveGlb(app, {})}>${icons.down} ${words.take.glb} <span class="figure">${bytes(shown.answer.glb.length)}</span></button>
      <h3>${words.take.variants}</h3>
      <div class="chips">
        <button class="chip" @click=${() => saveGlb(app, { physics: 'omi' })}>${words.take.godot}</button>
        <button class="chip" @click=${() => saveGlb(app, { ue_collision: 'ucx' })}>${words.take.unreal}</button>
        <button class="chip" @click=${() => saveGlb(app, { physics: 'none' })}>${words.take.plain}</button>
        <button class="chip" @click=${() => saveFigures(app)}>${words.take.figures}</button>
      </div>
    </section>
    <section aria-label=${words.take.same}>
      <h3>${words.take.same}</h3>
      <div class="segments" role="group" aria-label=${words.take.same}>${(Object.keys(texts) as (keyof typeof texts)[]).map(name => html`<button aria-pressed=${name === kind} @click=${() => {
        kind = name;
        app.set({});
      }}>${words.take.kinds[name]}</button>`)}</div>
      <textarea class="code" readonly rows="9" spellcheck="false" aria-label=${words.take.kinds[kind]} .value=${live(texts[kind])}></textarea>
      <div class="row">${copyButton('snippet', words.take.copy, () => texts[kind])}
      ${source.fetched ? html`<button @click=${() => saveMesh(app)}>${icons.down} ${words.take.mesh}</button>` : nothing}</div>
      ${source.fetched ? html`<p class="hint">${words.take.meshHint(source.sample ? `${source.sample}.glb` : source.label)}</p>` : nothing}
    </section>
    <section>
      ${copyButton('link', words.take.link, () => linkOf(app))}<p class="hint">${words.take.linkHint}</p>
    </section>
    ${presets(app)}
    <section>${app.stage ? html`<button @click=${() => savePicture(app)}>${icons.down} ${words.take.picture}</button>` : nothing}</section>
    ${debug}`;
}

function presets(app: App): TemplateResult {
  return html`<section aria-label=${words.take.presets}><h3>${words.take.presets}</h3><div class="row">
    <button @click=${() => saveAs(new Blob([presetOf(app)], { type: 'application/json' }), `${app.state.wish.settings['material'] ?? words.take.preset}.fracture.json`)}>${words.take.save}</button>
    <label class="button">${words.take.load}<input class="hidden-input" type="file" accept=".json,application/json" @change=${async (event: Event) => {
      const input = event.target as HTMLInputElement, [file] = input.files ?? [];
      if (file) readPreset(app, await file.text());
      input.value = '';
    }}></label></div></section>`;
}
