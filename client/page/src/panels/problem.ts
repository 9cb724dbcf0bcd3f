// A problem in the server's words, with a remedy if the page knows one.
import type { FractureError } from 'fracture-client';
import { html, nothing, type TemplateResult } from 'lit';
import type { App } from '../app/app';
import { placesOf } from '../app/failures';
import { words } from '../words/words';
import { metric } from './format';
import { icons } from './icons';

export function problemNotice(app: App): TemplateResult {
  const { problem } = app.state;
  if (!problem) return leftOutNotice(app);
  const { title, detail, parameter, document } = problem;
  return html`<div class="problem floating" role="alert">
    <button class="plain small" aria-label=${words.problem.dismiss} title=${words.problem.dismiss} @click=${() => app.dismiss()}>${icons.reset}</button>
    <b>${app.state.refused ? html`${app.state.refused}: ` : nothing}${title}</b>
    ${detail && detail !== title ? html`<p>${detail}</p>` : nothing}
    ${document?.errors && document.errors.length > 1 ? html`<ul>${document.errors.map(each => html`<li>${each.detail}</li>`)}</ul>` : nothing}
    ${placesOf(problem).length > 0 && app.view && !app.state.source ? html`<p class="hint">${words.problem.marked}</p>` : nothing}
    ${wayOut(app, problem)}
    ${problem.problem === 'updated' ? html`<p><button class="primary" @click=${() => location.reload()}>${words.problem.reload}</button></p>` : nothing}
    ${app.bringing.replaced === undefined ? nothing : html`<p><button @click=${() => app.bringing.restore()}>${words.problem.back(app.bringing.replaced)}</button></p>`}
    <p class="hint">${problem.type.startsWith('/problems/') ? html`<a href=${problem.type} target="_blank" rel="noreferrer">${words.problem.explain}</a>` : nothing}
      ${parameter ? html`<code>${parameter}</code>` : nothing} ${document?.request_id ? html`${words.problem.id} <code>${document.request_id}</code>` : nothing}</p>
  </div>`;
}

/** Draws a notice that only one of several dropped meshes was opened. */
function leftOutNotice(app: App): TemplateResult {
  const { leftOut } = app.state;
  if (!leftOut) return html``;
  return html`<div class="problem remark floating" role="status">
    <button class="plain small" aria-label=${words.problem.dismiss} title=${words.problem.dismiss} @click=${() => app.dismiss()}>${icons.reset}</button>
    <b>${words.mesh.taken(leftOut.taken)}</b><p>${words.mesh.leftOut(leftOut.others)}</p></div>`;
}

/** Draws a remedy for sheets without volume: slabs of a thickness that suits their size. */
function wayOut(app: App, problem: FractureError): TemplateResult | typeof nothing {
  const again = app.bringing.refusedMesh;
  if (problem.problem !== 'mesh-not-closed' || !again) return nothing;
  const size = app.view?.size ?? 1, thick = [0.002, 0.01, 0.05].map(share => Number((share * size).toPrecision(1)));
  return html`<p>${words.mesh.thicken} ${thick.map(metres => html`<button @click=${() => again(metres)}>${words.mesh.thickenBy(metric(metres, 1))}</button> `)}</p>`;
}
