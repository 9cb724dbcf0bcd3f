// All parameters under the headings of the documents, and a search by their names, descriptions and synonyms.
import type { ParameterDescription } from 'fracture-client';
import { html, nothing, type TemplateResult } from 'lit';
import { live } from 'lit/directives/live.js';
import type { App } from '../app/app';
import type { Tab } from '../app/state';
import { words } from '../words/words';
import { control } from './controls';
import { title } from './format';

type Listed = ParameterDescription & { patterns?: string[] };

/** Parameters that have their own control on a tab of the page. Maps each to that tab. */
const PLACES: Readonly<Record<string, Tab>> = {
  unit: 'mesh', up: 'mesh', material: 'break', pattern: 'break', local_point: 'break', local_radius: 'break', local_sites: 'break', fragment: 'pieces', fragment_sites: 'pieces', fragment_seed: 'pieces',
};
/** Parameters that the page sets itself. */
const OWN = new Set(['of', 'delta', 'local_new', 'local_rest', 'format', 'broken']);

/** Returns whether each word of the search occurs in the parameter's name, description or synonyms. */
export function matches({ name, description, ...more }: ParameterDescription, search: string): boolean {
  const text = `${name} ${name.replaceAll('_', ' ')} ${description} ${((more['synonyms'] ?? []) as string[]).join(' ')}`.toLowerCase();
  return search.toLowerCase().split(/\s+/).every(word => text.includes(word));
}
/** Returns the found parameters, best first: a name or a synonym that begins with the search, then descriptions. */
export function found<T extends ParameterDescription>(parameters: readonly T[], search: string): T[] {
  const wanted = search.trim().toLowerCase(), names = (each: T) => [each.name, each.name.replaceAll('_', ' '), ...((each['synonyms'] ?? []) as string[])].map(name => name.toLowerCase());
  const rank = (each: T) => (names(each).includes(wanted) ? 0 : names(each).some(name => name.startsWith(wanted)) ? 1 : names(each).some(name => name.includes(wanted)) ? 2 : 3);
  return parameters.filter(each => matches(each, wanted)).map((each, k) => ({ each, k, at: rank(each) })).sort((a, b) => a.at - b.at || a.k - b.k).map(({ each }) => each);
}

/** The search field, and its results or the groups. `shown`: parameters that stand elsewhere in this panel. */
export function finding(app: App, shown: ReadonlySet<string>): TemplateResult {
  const { filter, more } = app.state, all = app.service.parameters.filter(({ name }) => !OWN.has(name)), search = filter.trim();
  return html`<input type="search" class="wide" placeholder=${words.break.filter} aria-label=${words.break.filter} .value=${live(filter)}
      @input=${(event: Event) => app.set({ filter: (event.target as HTMLInputElement).value })}>
    ${search !== '' ? results(app, found(all, search))
    : html`<button class="wide" aria-expanded=${more} @click=${() => app.set({ more: !more })}>${more ? words.break.fewer : `${words.break.more} (${app.service.parameters.length})`}</button>
      ${more ? groups(app, all.filter(({ name }) => !shown.has(name) && !(name in PLACES))) : nothing}`}`;
}

function results(app: App, list: readonly Listed[]): TemplateResult {
  if (list.length === 0) return html`<p class="hint">${words.break.noMatch}</p>`;
  return html`${list.map(parameter => (parameter.name in PLACES ? elsewhere(app, parameter) : one(app, parameter)))}`;
}

/** A parameter whose control is elsewhere, with a button that leads there. */
function elsewhere(app: App, { name, description }: Listed): TemplateResult {
  const tab = PLACES[name]!;
  return html`<div class="control"><span class="name" title=${description.replaceAll('`', '')}>${title(name)}</span>
    <button @click=${() => app.set({ filter: '', tab })}>${words.break.isOn(words.tabs[tab])}</button></div>`;
}

function one(app: App, parameter: Listed): TemplateResult {
  const { patterns } = parameter, foreign = patterns && !patterns.includes(app.service.patternOf(app.state.wish.settings)) && app.state.wish.settings[parameter.name] === undefined;
  return html`${control(app, parameter)}${foreign ? html`<p class="hint">${words.break.onlyWith(patterns)}</p>` : nothing}`;
}

function groups(app: App, parameters: readonly Listed[]): TemplateResult {
  const { settings } = app.state.wish, pattern = app.service.patternOf(settings), left = new Map(parameters.map(each => [each.name, each]));
  const lists = app.service.groups.map(({ title: name, parameters: names }) => {
    const list = names.flatMap(each => left.get(each) ?? []);
    names.forEach(each => left.delete(each));
    // The parameters of the chosen pattern come first.
    return { name, list: [...list.filter(({ patterns }) => !patterns || patterns.includes(pattern)), ...list.filter(({ patterns }) => patterns && !patterns.includes(pattern))] };
  });
  return html`${[...lists, { name: words.break.other, list: [...left.values()] }].filter(({ list }) => list.length > 0).map(({ name, list }) => html`<details ?open=${list.some(each => settings[each.name] !== undefined)}>
      <summary>${name} <span class="hint">${list.length}</span></summary>${list.map(parameter => one(app, parameter))}</details>`)}`;
}
