// The mesh panel: choose a mesh, and see the report on it.
import { html, nothing, type TemplateResult } from 'lit';
import type { App } from '../app/app';
import { words } from '../words/words';
import { choiceButtons } from './choices';
import { bytes, digits, metric, title } from './format';
import { chooser, offersSamples, sampleChips } from './opening';
import { remarkLists } from './remarks';

export function meshPanel(app: App): TemplateResult {
  const { source, wanted, note } = app.state;
  return html`
    ${wanted ? html`<div class="notice"><b>${words.mesh.wanted(wanted.name)}</b> ${words.mesh.wantedHint}<div class="mono wrap">${wanted.mesh}</div></div>` : nothing}
    ${note === 'digest' ? html`<div class="notice">${words.mesh.otherDigest}</div>` : nothing}
    <section aria-label=${words.mesh.of}>
      <div class="row">${chooser(app, words.mesh.folder, true)}</div>
      <p class="hint">${words.mesh.drop}: ${words.mesh.dropMore}</p>
      ${offersSamples(app) ? nothing : html`<h3>${words.mesh.samples}</h3><div class="chips">${sampleChips(app)}</div>`}
      ${app.state.offered.length === 0 ? nothing : html`<h3>${words.mesh.offered}</h3>
      <div class="chips">${app.state.offered.map(offer => html`<button class="chip" aria-pressed=${source?.fetched === true && source.label === offer.name}
        title=${bytes(offer.bytes)} ?disabled=${app.service.state !== 'ready'} @click=${() => void app.bringing.offered(offer)}>${offer.name}</button>`)}</div>`}
    </section>
    ${source ? report(app) : nothing}`;
}

function report(app: App): TemplateResult {
  const { source, look } = app.state, { whole, mesh, label } = source!, { solid, frame, warnings = [], notes = [], dropped = [] } = whole.report as Record<string, any>;
  const { min, max } = app.view?.batch ? boundsOf(app) : { min: [0, 0, 0], max: [0, 0, 0] };
  const sides = max.map((value, k) => value - min[k]!);
  const clean = solid.open_edges === 0 && solid.holes_filled === 0 && solid.nonmanifold_edges === 0;
  const row = (name: string, value: unknown, tone = '') => html`<div><dt>${name}</dt><dd class=${tone}>${value}</dd></div>`;
  const settings = app.state.wish.settings;
  const frameRow = (name: 'unit' | 'up', label: string, aria: string, now: string, from: string) => {
    const parameter = app.service.parameters.find(each => each.name === name);
    return html`<div><dt>${label}</dt><dd class="choice"><span class="hint">${from === 'assumed' ? words.mesh.assumed : from === 'file' ? words.mesh.file_ : words.mesh.given}</span>
      <span class="segments" role="group" aria-label=${aria}>${((parameter?.['enum'] ?? []) as string[]).map(choice => html`<button
        aria-pressed=${(settings[name] ?? 'file') === choice} title=${choice === 'file' ? now : choice}
        @click=${() => app.breaking.setParameter(name, choice === 'file' ? undefined : choice)}>${choice}</button>`)}</span></dd></div>`;
  };
  return html`<section aria-label=${words.mesh.report}>
    <h3>${label} <span class="tag ${clean ? 'good' : 'warn'}">${clean ? words.mesh.closed : words.mesh.repaired}</span></h3>
    <dl>
      ${row(words.mesh.triangles, solid.source_triangles.toLocaleString('en'))}
      ${row(words.mesh.parts, solid.parts.toLocaleString('en'))}
      ${row(words.mesh.size, sides.map(side => metric(side, 1)).join(' × '))}
      ${row(words.mesh.volume, metric(solid.volume, 3))}
      ${row(words.mesh.area, metric(solid.area, 2))}
      ${row(words.mesh.openEdges, solid.open_edges.toLocaleString('en'), solid.open_edges > 0 ? 'red' : '')}
      ${row(words.mesh.holes, solid.holes_filled.toLocaleString('en'), solid.holes_filled > 0 ? 'amber' : '')}
      ${solid.nonmanifold_edges > 0 ? row(words.mesh.nonmanifold, solid.nonmanifold_edges.toLocaleString('en'), 'red') : nothing}
      ${solid.cavities > 0 ? row(words.mesh.cavities, solid.cavities.toLocaleString('en')) : nothing}
      ${frameRow('unit', words.mesh.unit, words.mesh.unitAria, `${digits(frame.metres_per_unit)} m`, frame.unit_from)}
      ${frameRow('up', words.mesh.up, words.mesh.upAria, frame.up, frame.up_from)}
      ${mesh.stored ? row(title(mesh.stored.format), bytes(mesh.stored.bytes)) : nothing}
      ${row(words.mesh.key, html`<code title=${mesh.id}>${mesh.id.slice(7, 19)}…</code>`)}
    </dl>
    <label class="check"><input type="checkbox" .checked=${look.repairs} ?disabled=${clean} @change=${(event: Event) => app.showRepairs((event.target as HTMLInputElement).checked)}>
      ${words.mesh.showRepairs}</label>
    <label class="check"><input type="checkbox" .checked=${look.person} @change=${(event: Event) => app.look({ person: (event.target as HTMLInputElement).checked })}>
      ${words.mesh.showPerson}</label>
    ${remarkLists(warnings, notes, dropped)}
    ${choiceButtons(app, whole.choices)}
  </section>`;
}

function boundsOf(app: App): { min: number[]; max: number[] } {
  const min = [Infinity, Infinity, Infinity], max = [-Infinity, -Infinity, -Infinity];
  for (const { document, fragments } of [app.state.source!.whole])
    for (const fragment of fragments) {
      const { rawPrimitives, translation, turn } = fragment;
      const accessor = document.accessorAt(rawPrimitives[0]!.attributes['POSITION']!);
      for (let k = 0; k < 3; ++k) {
        const along = turn ? fragment.positions.filter((_, i) => i % 3 === k) : [accessor.min![k]!, accessor.max![k]!];
        for (const value of along) {
          min[k] = Math.min(min[k]!, translation[k]! + value);
          max[k] = Math.max(max[k]!, translation[k]! + value);
        }
      }
    }
  return { min, max };
}
