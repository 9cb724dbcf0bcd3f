// The breaking panel: material, pattern, hits, common parameters, and all other parameters of the server behind "more".
import { html, nothing, type TemplateResult } from 'lit';
import { live } from 'lit/directives/live.js';
import type { App } from '../app/app';
import { placesIn } from '../state/places';
import { words } from '../words/words';
import { assignRows } from './assign';
import { control } from './controls';
import { finding } from './finding';
import { bytes, title } from './format';
import { hits, impactParameters } from './hits';
import { icons } from './icons';
import { onlyOneNotice } from './selected';
import { countRemark } from './remarks';
import { swatch } from './swatch';

/** These parameters are shown first if the server has them. All others follow automatically. */
const OFTEN = ['fragments', 'seed', 'rough_amplitude', 'stretch', 'shell_fraction'];

export function breakPanel(app: App): TemplateResult {
  const { knowledge } = app.service, { settings } = app.state.wish;
  if (!knowledge) return html`<p class="hint">${words.header.connecting}</p>`;
  const { materials, patterns } = knowledge.patterns, all = app.service.parameters, searches = app.state.filter.trim() !== '';
  // The pictures of the materials are drawn only after the first picture of the mesh, because they would delay it.
  const { bringing, inFlight, shown } = app.state, waits = app.marks.at['picture'] === undefined && (bringing !== undefined || inFlight > 0 || shown !== undefined);
  const often = OFTEN.flatMap(name => all.find(parameter => parameter.name === name) ?? []), near = impactParameters(app);
  return html`
    ${onlyOneNotice(app)}
    ${searches ? nothing : html`<section aria-label=${words.break.material}>
      <h3>${words.break.material}</h3>
      <div class="swatches" role="group" aria-label=${words.break.material}><button class="swatch" aria-pressed=${settings['material'] === undefined} title=${words.break.noMaterialHint}
        @click=${() => app.breaking.chooseMaterial(undefined)}>${icons.none}<span>${words.break.noMaterial}</span></button>${materials.map(material => html`<button class="swatch" aria-pressed=${settings['material'] === material.name}
        title="${material.description} ${material['use'] ? `(${material['use']})` : ''}"
        @click=${() => app.breaking.chooseMaterial(material.name)}>
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
    <section aria-label=${words.break.places}>${places(app)}</section>`}
    <section aria-label=${words.break.more}>${finding(app, new Set([...OFTEN, ...near.map(({ name }) => name)]))}</section>`;
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
