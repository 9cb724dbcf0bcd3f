// The controls of hits: what was hit, and the radius, number and fineness of the pieces of the next hit.
import { html, nothing, type TemplateResult } from 'lit';
import { live } from 'lit/directives/live.js';
import type { App } from '../app/app';
import { HIT_SITES } from '../state/request';
import { words } from '../words/words';
import { control } from './controls';
import { metric, title } from './format';

/** The parameters of a pattern that say how large and how fine the pieces around an impact are. */
const OF_IMPACTS = ['radius', 'share', 'exponent', 'crushed'];
/** The most sites that the slider gives a hit; the field accepts all that the server allows. */
const END = 200;

export function hits(app: App): TemplateResult {
  const { wish: { settings, hits: made }, shown, tool, play } = app.state, impacts = settings['impacts'], any = impacts !== undefined || made.length > 0;
  const given = [impacts !== undefined ? words.break.impact : '', made.length > 0 ? words.break.again(made.length) : ''].filter(Boolean).join(', ');
  // A click is a hit only with the Hit tool, and not if it sets a parameter's point or throws a ball.
  const hitsNow = shown && app.stage && tool === 'hit' && !play && app.breaking.pickingFor === undefined && app.breaking.onlyOne === undefined;
  return html`<div class="row between"><h3>${words.break.hits}</h3>
      ${any ? html`<button class="plain" @click=${() => app.breaking.clearHits()}>${words.break.clear}</button>` : nothing}</div>
    ${any || hitsNow ? html`<p class="hint">${any ? `${given}. ` : ''}${hitsNow ? (any ? words.break.pickHint : words.break.noHits) : ''}</p>` : nothing}
    ${radius(app)}${sites(app)}${ofImpacts(app)}`;
}

function radius(app: App): TemplateResult {
  const { radius: now } = app.state, size = app.view?.size ?? 1, to = (value: number) => 1000 * Math.log(value / (size * 0.005)) / Math.log(100);
  return html`<div class="control"><label for="radius" title="${describe(app, 'local_radius')} ${words.break.nextHint}">${title('local_radius')}</label><span class="row">
      <input class="grow" type="range" id="radius" min="0" max="1000" .value=${live(String(Math.round(to(now))))} aria-valuetext=${metric(now, 1)}
        @input=${(event: Event) => app.set({ radius: Number((size * 0.005 * 100 ** (Number((event.target as HTMLInputElement).value) / 1000)).toPrecision(2)) })}>
      <output class="figure" for="radius">${metric(now, 1)}</output></span></div>`;
}

/** The number of cells of the next hit. More cells in the same radius are finer pieces. */
function sites(app: App): TemplateResult | typeof nothing {
  const parameter = app.service.parameters.find(({ name }) => name === 'local_sites');
  if (!parameter) return nothing;
  const { minimum = 1, maximum = 10_000 } = (parameter['items'] ?? {}) as { minimum?: number; maximum?: number }, value = app.state.sites ?? HIT_SITES;
  const put = (text: string) => {
    const given = Math.round(Number(text));
    app.set({ sites: Number.isFinite(given) && given >= minimum && given <= maximum ? given : app.state.sites });
  };
  return html`<div class="control"><label for="hit-sites" title="${describe(app, 'local_sites')} ${words.break.nextHint}">${title('local_sites')}</label><span class="row">
      <input class="grow" type="range" aria-label=${title('local_sites')} min=${minimum} max=${END} .value=${live(String(value))} @input=${(event: Event) => put((event.target as HTMLInputElement).value)}>
      <input type="number" id="hit-sites" min=${minimum} max=${maximum} .value=${live(String(value))} @change=${(event: Event) => put((event.target as HTMLInputElement).value)}></span></div>`;
}

/** The parameters of the pattern that concern impacts, if the pattern has any. */
function ofImpacts(app: App): TemplateResult | typeof nothing {
  const list = impactParameters(app);
  if (list.length === 0) return nothing;
  return html`<h3>${words.break.ofPattern(app.service.patternOf(app.state.wish.settings))}</h3>${list.map(parameter => control(app, parameter))}`;
}
/** Returns the parameters that this section shows instead of the list of all parameters. */
export function impactParameters(app: App): typeof app.service.parameters {
  const pattern = app.service.patternOf(app.state.wish.settings), all = app.service.parameters.filter(({ patterns }) => patterns?.includes(pattern));
  return all.some(({ name }) => name === 'impacts') ? OF_IMPACTS.flatMap(name => all.find(each => each.name === name) ?? []) : [];
}

const describe = (app: App, parameter: string): string => (app.service.parameters.find(({ name }) => name === parameter)?.description ?? '').replaceAll('`', '');
