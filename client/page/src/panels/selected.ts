// The actions for the selected fragments: name, frame, hide, break again, save alone.
import type { Fragment } from 'fracture-client';
import { html, nothing, type TemplateResult } from 'lit';
import { live } from 'lit/directives/live.js';
import type { App } from '../app/app';
import { saveChosen } from '../take/files';
import { words } from '../words/words';
import { control } from './controls';
import { kilograms, metric } from './format';
import { icons } from './icons';

export function selected(app: App): TemplateResult | typeof nothing {
  const { shown, look: { chosen, hidden } } = app.state, [first] = chosen, one = chosen.size === 1 && first !== undefined ? shown?.answer.fragment(first) : undefined;
  if (chosen.size === 0 && hidden.size === 0) return nothing;
  return html`<section aria-label=${words.pieces.selection}>
    ${chosen.size > 1 ? html`<p class="hint">${words.pieces.selected(chosen.size)}</p>` : nothing}
    ${one ? about(app, one) : nothing}
    <div class="chips">
      ${chosen.size > 0 ? html`
        <button ?disabled=${!app.stage} title=${words.pieces.frameHint} @click=${() => app.frameChosen()}>${icons.fit} ${words.pieces.frame}</button>
        <button ?disabled=${!app.stage} @click=${() => app.hideChosen()}>${words.pieces.hide}</button>
        ${one && app.breaking.onlyOne === undefined ? html`<button title=${words.pieces.againHint} @click=${() => app.breaking.again(one.id)}>${words.pieces.again}</button>` : nothing}
        <button title=${words.pieces.saveHint} @click=${() => saveChosen(app)}>${icons.down} ${words.pieces.save}</button>
        <button @click=${() => app.choose([])}>${words.pieces.unselect}</button>` : nothing}
      ${hidden.size > 0 ? html`<button @click=${() => app.showAll()}>${words.pieces.showAll(hidden.size)}</button>` : nothing}
    </div></section>`;
}

function about(app: App, fragment: Fragment): TemplateResult {
  const { id, name, volume, mass, area, exteriorArea, hulls, anchored } = fragment;
  return html`<div class="control"><label for="piece-name">${words.pieces.name}</label>
      <input type="text" id="piece-name" spellcheck="false" autocomplete="off" maxlength="60" placeholder=${name} .value=${live(app.nameOf(fragment))}
        @change=${(event: Event) => app.nameFragment(id, (event.target as HTMLInputElement).value)}></div>
    <p class="hint"><b>${app.nameOf(fragment)}</b> ${words.pieces.details(metric(volume, 3), kilograms(mass), metric(area, 2), metric(exteriorArea, 2))}, ${words.pieces.hulls(hulls.length)}${anchored ? `, ${words.pieces.anchored}` : ''}</p>`;
}

/** Shown while only the pieces of one fragment are in the view. */
export function onlyOneNotice(app: App): TemplateResult | typeof nothing {
  if (app.breaking.onlyOne === undefined) return nothing;
  const own = ['fragment_sites', 'fragment_seed'].flatMap(name => app.service.parameters.find(each => each.name === name) ?? []);
  return html`<section aria-label=${words.pieces.onlyOne}><div class="notice">${words.pieces.onlyOne}
    <div class="row"><button @click=${() => app.breaking.allFragments()}>${words.pieces.all}</button></div></div>
    ${own.map(parameter => control(app, parameter))}</section>`;
}
