// Changes that the server offers and does not make by itself: another unit, walls for a room. A button requests them, and Undo goes back.
import type { Choice } from 'fracture-client';
import { html, nothing, type TemplateResult } from 'lit';
import type { App } from '../app/app';
import type { Wish } from '../state/request';
import { words } from '../words/words';

/** Returns the request with the choice's parameters. Another unit moves the mesh away from its hits, so they are left out. */
export function withChoice({ settings, hits }: Wish, { kind, parameters }: Choice): Wish {
  return { settings: { ...settings, ...parameters }, hits: kind === 'unit' ? [] : hits };
}

/** A button for each choice. It opens the mesh again if the solid changes. */
export function choiceButtons(app: App, choices: readonly Choice[]): TemplateResult | typeof nothing {
  if (choices.length === 0) return nothing;
  const named = ({ parameters }: Choice) => Object.entries(parameters).map(([name, value]) => `${name} ${value}`).join(', ');
  return html`<div class="choices"><h3>${words.choices.title}</h3><ul class="notes">${choices.map(choice => html`<li>${choice.text}
    <button class="wide" @click=${() => app.breaking.wishFor(withChoice(app.state.wish, choice), '', true)}>${words.choices.apply(named(choice))}</button></li>`)}</ul></div>`;
}
