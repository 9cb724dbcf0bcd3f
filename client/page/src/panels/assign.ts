// Materials of single parts: one row for each entry of the parameter `assign`.
import type { Assignment } from 'fracture-client';
import { html, type TemplateResult } from 'lit';
import { live } from 'lit/directives/live.js';
import type { App } from '../app/app';
import { entryOf, selectorOf } from '../state/assignments';
import { words } from '../words/words';
import { title } from './format';
import { icons } from './icons';

/** Maximum number of entries that the server accepts. */
const MOST = 64;

export function assignRows(app: App): TemplateResult {
  const { settings } = app.state.wish, entries = (Array.isArray(settings['assign']) ? settings['assign'] : []) as readonly Assignment[];
  const materials = app.service.knowledge?.patterns.materials ?? [], report = app.state.source?.mesh.report ?? {};
  const nodes = [...new Set([...(report['nodes'] as string[] ?? []), ...(report['groups'] as string[] ?? [])])].filter(Boolean);
  const slots = [...new Set(report['materials'] as string[] ?? [])].filter(Boolean).map(name => `slot=${name}`);
  const put = (next: readonly Assignment[]) => app.breaking.setParameter('assign', next.length > 0 ? next : undefined);
  const replaced = (at: number, entry: Assignment | undefined) => put(entries.flatMap((old, k) => (k !== at ? [old] : entry ? [entry] : [])));
  const selector = (value: string, label: string, taken: (text: string) => void) => html`<input type="text" class="grow" list="assign-names" spellcheck="false"
    placeholder=${words.break.assignSelector} aria-label=${label} .value=${live(value)} @change=${(event: Event) => taken((event.target as HTMLInputElement).value.trim())}>`;
  return html`<h3 title=${words.break.assignHint}>${words.break.assign}</h3>
    <datalist id="assign-names">${[...nodes, ...slots].slice(0, 1000).map(name => html`<option value=${name}></option>`)}</datalist>
    ${entries.map((entry, k) => html`<div class="row">
      ${selector(selectorOf(entry), words.break.assignRow(k + 1), text => replaced(k, text === '' ? undefined : entryOf(text, entry)))}
      <select aria-label=${words.break.assignMaterial(k + 1)} @change=${(event: Event) => replaced(k, { ...entry, material: (event.target as HTMLSelectElement).value })}>
        ${materials.map(({ name }) => html`<option value=${name} ?selected=${name === entry.material}>${title(name)}</option>`)}</select>
      <button class="plain small" title=${words.break.assignRemove} aria-label="${words.break.assignRemove} ${k + 1}" @click=${() => replaced(k, undefined)}>${icons.reset}</button></div>`)}
    ${entries.length < MOST && materials.length > 0 ? html`<div class="row">${selector('', words.break.assignAdd, text => {
      if (text !== '') put([...entries, entryOf(text, { material: String(settings['material'] ?? materials[0]!.name) })]);
    })}</div>` : ''}`;
}
