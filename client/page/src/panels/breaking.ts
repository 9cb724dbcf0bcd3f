// The breaking panel: material, pattern, common parameters, and all other parameters of the server behind "more".
import type { ParameterDescription } from 'fracture-client';
import { html, nothing, type TemplateResult } from 'lit';
import { live } from 'lit/directives/live.js';
import type { App } from '../app/app';
import { placesIn } from '../state/places';
import { words } from '../words/words';
import { assignRows } from './assign';
import { control } from './controls';
import { bytes, metric, title } from './format';
import { countRemark } from './remarks';
import { swatch } from './swatch';

/** These parameters are shown first if the server has them. All others follow automatically. */
const OFTEN = ['fragments', 'seed', 'rough_amplitude', 'stretch', 'shell_fraction'];
/** Parameters that have a separate control on this page, or that the page sets itself. */
const ELSEWHERE = new Set(['material', 'pattern', 'assign', 'of', 'delta', 'local_new', 'local_point', 'local_radius', 'local_rest', 'format', 'unit', 'up', 'fragment', 'fragment_sites', 'fragment_seed', 'broken']);

export function breakPanel(app: App): TemplateResult {
  const { knowledge } = app.service, { settings } = app.state.wish;
  if (!knowledge) return html`<p class="hint">${words.header.connecting}</p>`;
  const { materials, patterns } = knowledge.patterns, all = app.service.parameters;
  // The pictures of the materials are drawn only after the first picture of the mesh, because they would delay it.
  const { bringing, inFlight, shown } = app.state, waits = app.marks.at['picture'] === undefined && (bringing !== undefined || inFlight > 0 || shown !== undefined);
  const often = OFTEN.flatMap(name => all.find(parameter => parameter.name === name) ?? []);
  return html`
    <section aria-label=${words.break.material}>
      <h3>${words.break.material}</h3>
      <div class="swatches" role="group" aria-label=${words.break.material}>${materials.map(material => html`<button class="swatch" aria-pressed=${settings['material'] === material.name}
        title="${material.description} ${material['use'] ? `(${material['use']})` : ''}"
        @click=${() => app.breaking.chooseMaterial(settings['material'] === material.name ? undefined : material.name)}>
        <img alt="" width="44" height="44" src=${waits ? nothing : swatch(material, String(material.parameters['pattern'] ?? ''))}><span>${title(material.name)}</span></button>`)}</div>
      <div class="control"><label for="p-pattern">${words.break.pattern}</label>
        <select id="p-pattern" .value=${live(String(settings['pattern'] ?? ''))} @change=${(event: Event) => app.breaking.setParameter('pattern', (event.target as HTMLSelectElement).value || undefined)}>
          <option value="">${settings['material'] ? words.break.ofMaterial : `${all.find(({ name }) => name === 'pattern')?.['default'] ?? words.break.none}`}</option>
          ${patterns.map(({ name, description }) => html`<option value=${name} title=${description.replaceAll('`', '')} ?selected=${settings['pattern'] === name}>${name}</option>`)}
        </select></div>
    </section>
    <section aria-label=${words.break.hits}>${hits(app)}</section>
    <section>${often.map(parameter => html`${control(app, parameter)}${parameter.name === 'fragments' ? remark(app) : nothing}`)}</section>
    ${all.some(({ name }) => name === 'assign') ? html`<section aria-label=${words.break.assign}>${assignRows(app)}</section>` : nothing}
    <section aria-label=${words.break.places}>${places(app)}</section>
    <section>
      <button class="wide" aria-expanded=${app.state.more} @click=${() => app.set({ more: !app.state.more })}>${app.state.more ? words.break.fewer : `${words.break.more} (${all.length})`}</button>
      ${app.state.more ? others(app, all.filter(({ name }) => !OFTEN.includes(name))) : nothing}
    </section>`;
}

function remark(app: App): TemplateResult | typeof nothing {
  const { shown } = app.state, said = shown && !app.isOfEarlier ? countRemark(shown) : undefined;
  return said ? html`<p class="hint">${said}</p>` : expected(app);
}

/** Draws the server's estimate for the request in flight. */
function expected(app: App): TemplateResult | typeof nothing {
  const { expected: made, inFlight, job } = app.state;
  if (!made || (inFlight === 0 && !job)) return nothing;
  const count = (number: number) => Number(number.toPrecision(2)).toLocaleString('en');
  return html`<p class="hint" id="expected">${words.break.expected(count(made.fragments), count(made.triangles), bytes(made.bytes), bytes(made.working_bytes))}</p>`;
}

function hits(app: App): TemplateResult {
  const { wish: { settings, hits }, radius, shown, tool, play } = app.state, impacts = settings['impacts'], any = impacts !== undefined || hits.length > 0;
  const given = [impacts !== undefined ? words.break.impact : '', hits.length > 0 ? words.break.again(hits.length) : ''].filter(Boolean).join(', ');
  // A click is a hit only with the Hit tool, and not if it sets a parameter's point or throws a ball.
  const hitsNow = shown && app.stage && tool === 'hit' && !play && app.breaking.pickingFor === undefined;
  const size = app.view?.size ?? 1, to = (value: number) => 1000 * Math.log(value / (size * 0.005)) / Math.log(100);
  return html`<div class="row between"><h3>${words.break.hits}</h3>
      ${any ? html`<button class="plain" @click=${() => app.breaking.clearHits()}>${words.break.clear}</button>` : nothing}</div>
    ${any || hitsNow ? html`<p class="hint">${any ? `${given}. ` : ''}${hitsNow ? (any ? words.break.pickHint : words.break.noHits) : ''}</p>` : nothing}
    <div class="control"><label for="radius" title=${words.break.radiusHint}>${words.break.radius}</label><span class="row">
      <input class="grow" type="range" id="radius" min="0" max="1000" .value=${live(String(Math.round(to(radius))))} aria-valuetext=${metric(radius, 1)}
        @input=${(event: Event) => app.set({ radius: Number((size * 0.005 * 100 ** (Number((event.target as HTMLInputElement).value) / 1000)).toPrecision(2)) })}>
      <output class="figure" for="radius">${metric(radius, 1)}</output></span></div>`;
}

/** Draws the controls for points, regions and directions that the pattern uses. They can also be dragged in the view. */
function places(app: App): TemplateResult {
  const { settings } = app.state.wish, kinds = placesIn(app.service.parameters), pattern = app.service.patternOf(settings);
  const known = app.service.parameters.filter(({ name, patterns }) => kinds.has(name) && (!patterns || patterns.includes(pattern) || settings[name] !== undefined));
  const any = known.some(({ name }) => settings[name] !== undefined);
  return html`<h3>${words.break.places}</h3>
    <div class="chips" role="group" aria-label=${words.break.places}>${known.map(({ name, description }) => html`<button class="chip" aria-pressed=${settings[name] !== undefined} title=${description.replaceAll('`', '')}
      ?disabled=${!app.state.shown || !app.stage} @click=${() => app.breaking.togglePlace(name)}>${kinds.get(name) === 'sphere' ? words.break.sphere(title(name.replace(/_center$/, ''))) : title(name)}</button>`)}</div>
    ${any ? html`<p class="hint">${words.break.placesHint}</p>` : nothing}`;
}

/** Draws all other parameters, grouped by subject, then by the first word of their names if several share it. */
function others(app: App, parameters: (ParameterDescription & { patterns?: string[] })[]): TemplateResult {
  const { filter, wish: { settings } } = app.state, search = filter.trim().toLowerCase(), solid = app.service.solidParameters;
  const found = parameters.filter(({ name, description }) => !ELSEWHERE.has(name) && (search === '' || `${name.replaceAll('_', ' ')} ${name} ${description}`.toLowerCase().includes(search)));
  const pattern = app.service.patternOf(settings);
  const own = found.filter(({ patterns }) => patterns?.includes(pattern)), rest = found.filter(parameter => !own.includes(parameter));
  const firsts = new Map<string, number>();
  for (const { name } of rest) firsts.set(name.split('_')[0]!, (firsts.get(name.split('_')[0]!) ?? 0) + 1);
  const groups = new Map<string, typeof found>();
  if (own.length > 0) groups.set(words.break.ofPattern(pattern), own);
  for (const parameter of rest) {
    const first = parameter.name.split('_')[0]!;
    const key = parameter.patterns ? words.break.ofPattern(parameter.patterns.length > 2 ? `${parameter.patterns.slice(0, 2).join(', ')} …` : parameter.patterns.join(', '))
      : solid.has(parameter.name) ? words.break.solid : (firsts.get(first) ?? 0) > 1 ? title(first) : words.break.other;
    groups.set(key, [...(groups.get(key) ?? []), parameter]);
  }
  return html`<input type="search" class="wide" placeholder=${words.break.filter} aria-label=${words.break.filter} .value=${live(filter)}
      @input=${(event: Event) => app.set({ filter: (event.target as HTMLInputElement).value })}>
    ${found.length === 0 ? html`<p class="hint">${words.break.noMatch}</p>` : nothing}
    ${[...groups].map(([name, list]) => html`<details ?open=${search !== '' || name === words.break.ofPattern(pattern) || list.some(each => settings[each.name] !== undefined)}>
      <summary>${name} <span class="hint">${list.length}</span></summary>${list.map(parameter => control(app, parameter))}</details>`)}`;
}
