// The certificate of an answer: a seal, and its explanation.
import type { Answer } from 'fracture-client';
import { html, nothing, type TemplateResult } from 'lit';
import type { App } from '../app/app';
import { words } from '../words/words';
import { digits } from './format';
import { icons } from './icons';

/** Maximum relative difference of volumes that rounding in double precision may cause. The server's own limit is stricter. */
const MOST_ERROR = 1e-9;

export function judge(answer: Answer): 'good' | 'bad' | 'softer' {
  const { open_edges, unmirrored_caps, relative_error } = answer.certificate;
  if (answer.parameters['dual'] === 'barycenter') return open_edges === 0 ? 'softer' : 'bad';
  return open_edges === 0 && unmirrored_caps === 0 && !(relative_error > MOST_ERROR) ? 'good' : 'bad';
}

export function sealButton(app: App): TemplateResult {
  const { shown } = app.state;
  if (!shown) return html``;
  const verdict = judge(shown.answer), old = app.isOfEarlier;
  return html`<button class="seal ${old ? 'old' : verdict}" title=${old ? words.status.earlierHint : ''} aria-haspopup="dialog" @click=${() => app.set({ sheet: 'seal' })}>${verdict === 'good' ? icons.seal : icons.unsealed}${words.seal[verdict]}</button>`;
}

export function certificate(answer: Answer): TemplateResult {
  const verdict = judge(answer), figures = answer.certificate, same = verdict !== 'softer';
  const row = (name: string, value: unknown, fine: boolean, must = '') => html`<div><dt>${name}</dt><dd class=${fine ? '' : 'red'}>${value}${must && !fine ? html` <span class="hint">${must}</span>` : nothing}</dd></div>`;
  return html`<p>${verdict === 'good' ? words.seal.goodText : verdict === 'bad' ? words.seal.badText : words.seal.softerText}</p><dl class="figures">
    ${row(words.seal.openEdges, figures.open_edges, figures.open_edges === 0, words.seal.must)}
    ${row(words.seal.unmirrored, figures.unmirrored_caps, !same || figures.unmirrored_caps === 0, words.seal.must)}
    ${row(words.seal.volumeIn, `${figures.volume_in} m³`, true)}
    ${row(words.seal.volumeOut, `${figures.volume_out} m³`, true)}
    ${row(words.seal.error, digits(figures['relative_error'] ?? 0), !same || !(figures['relative_error'] > MOST_ERROR), words.seal.mustSmall)}
    ${'area_in' in figures ? row(words.seal.areaIn, `${digits(figures['area_in'], 6)} m²`, true) : nothing}
    ${'area_out' in figures ? row(words.seal.areaOut, `${digits(figures['area_out'], 6)} m²`, true) : nothing}
    ${'sheet_area_in' in figures ? row(words.seal.sheetIn, `${digits(figures['sheet_area_in'], 6)} m²`, true) : nothing}
    ${'sheet_area_out' in figures ? row(words.seal.sheetOut, `${digits(figures['sheet_area_out'], 6)} m²`, true) : nothing}
    ${'crossing_caps' in figures ? row(words.seal.crossing, figures['crossing_caps'], true) : nothing}
  </dl>`;
}
