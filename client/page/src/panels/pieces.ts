// The fragments panel: their number and sizes, the time taken, and whether the result is proved.
import type { Answer, Fragment } from 'fracture-client';
import { html, nothing, type TemplateResult } from 'lit';
import { repeat } from 'lit/directives/repeat.js';
import type { App } from '../app/app';
import type { Shown, State } from '../app/state';
import { words } from '../words/words';
import { sealButton } from './certificate';
import { choiceButtons } from './choices';
import { css } from './css';
import { digits, kilograms, metric, milliseconds } from './format';
import { remarkLists } from './remarks';
import { onlyOneNotice, selected } from './selected';

export function piecesPanel(app: App): TemplateResult {
  const { shown } = app.state;
  if (!shown) return html`<p class="hint">${words.pieces.none}</p>`;
  const { answer } = shown, { fragments } = answer;
  return html`
    ${onlyOneNotice(app)}
    <section aria-label=${words.pieces.list}>
      <div class="row between"><h2>${words.pieces.count(fragments.length)}</h2>${sealButton(app)}</div>
      ${remarkLists(answer.warnings, answer.notes, answer.dropped)}
      ${choiceButtons(app, answer.choices)}
    </section>
    <section aria-label=${words.pieces.sizes}>
      <h3>${words.pieces.sizes}</h3>${histogram(app, fragments)}
      <div class="row">
        <button @click=${() => find(app, extreme(fragments, -1))}>${words.pieces.smallest}</button>
        <button @click=${() => find(app, extreme(fragments, 1))}>${words.pieces.largest}</button>
      </div>
    </section>
    ${selected(app)}
    <section>${table(app, answer)}</section>
    <section aria-label=${words.pieces.timings}><h3>${words.pieces.timings}</h3>${timings(shown)}</section>`;
}

const extreme = (fragments: readonly Fragment[], sign: 1 | -1): number =>
  fragments.reduce((best, fragment) => (sign * fragment.volume > sign * best.volume ? fragment : best)).id;

/** Shows a fragment in the view and scrolls to it in the list, which is drawn in the next frame. */
function find(app: App, id: number): void {
  app.chooseAndShow(id);
  requestAnimationFrame(() => document.querySelector('.fragments tr.chosen')?.scrollIntoView({ block: 'nearest' }));
}

/** Draws a histogram of sizes with bars of equal width on a logarithmic scale. A click on a bar selects its fragments. */
function histogram(app: App, fragments: readonly Fragment[]): TemplateResult {
  const logs = fragments.map(({ volume }) => Math.log10(Math.max(1e-30, volume))), low = Math.min(...logs), high = Math.max(...logs);
  const count = Math.min(24, Math.max(1, Math.ceil(Math.sqrt(fragments.length) * 1.5))), step = (high - low || 1) / count;
  const bins = Array.from({ length: count }, (): number[] => []);
  logs.forEach((log, k) => bins[Math.min(count - 1, Math.max(0, Math.floor((log - low) / step)))]!.push(fragments[k]!.id));
  const most = Math.max(...bins.map(({ length }) => length)), { chosen } = app.state.look;
  return html`<div class="histogram" role="group" aria-label=${words.pieces.sizesHint} title=${words.pieces.sizesHint}>${bins.map((ids, k) => html`<button
      class=${ids.some(id => chosen.has(id)) ? 'chosen' : ''} ?disabled=${ids.length === 0} ${css({ '--share': String(ids.length / most) })}
      aria-pressed=${ids.length > 0 && ids.every(id => chosen.has(id))} title=${words.pieces.bar(ids.length, metric(10 ** (low + k * step), 3), metric(10 ** (low + (k + 1) * step), 3))}
      aria-label=${words.pieces.bar(ids.length, metric(10 ** (low + k * step), 3), metric(10 ** (low + (k + 1) * step), 3))}
      @click=${() => app.choose(ids.every(id => chosen.has(id)) ? [] : ids)}><i></i></button>`)}</div>
    <div class="row between hint"><span>${metric(10 ** low, 3)}</span><span>${metric(10 ** high, 3)}</span></div>`;
}

const VALUES: Record<State['sort']['by'], (fragment: Fragment, app: App) => number | string> = {
  name: (fragment, app) => app.nameOf(fragment), volume: ({ volume }) => volume, mass: ({ mass }) => mass, triangles: ({ triangles }) => triangles.length,
};

function table(app: App, answer: Answer): TemplateResult {
  const { sort, rows, look: { chosen, hidden } } = app.state, value = VALUES[sort.by];
  const sorted = [...answer.fragments].sort((a, b) => {
    const [x, y] = [value(a, app), value(b, app)];
    return (sort.down ? -1 : 1) * (x < y ? -1 : x > y ? 1 : 0);
  });
  // A selected fragment is listed, however far down it is.
  const listed = sorted.filter(({ id }, k) => k < rows || (chosen.size === 1 && chosen.has(id)));
  const head = (by: State['sort']['by'], label: string) => html`<th aria-sort=${sort.by !== by ? 'none' : sort.down ? 'descending' : 'ascending'}>
    <button class="plain" @click=${() => app.set({ sort: { by, down: sort.by === by ? !sort.down : by !== 'name' } })}>${label}<span aria-hidden="true" class="arrow">${sort.by === by ? (sort.down ? '▾' : '▴') : ''}</span></button></th>`;
  return html`<div class="scroll"><table class="fragments">
    <thead><tr>${head('name', words.pieces.name)}${head('volume', words.pieces.volume)}${head('mass', words.pieces.mass)}${head('triangles', words.pieces.triangles)}</tr></thead>
    <tbody>${repeat(listed, ({ id }) => id, ({ id, name, volume, mass, triangles }, k) => html`<tr class="${chosen.has(id) ? 'chosen' : ''} ${hidden.has(id) ? 'hidden' : ''} ${k >= rows ? 'beyond' : ''}">
      <td><button class="plain" aria-pressed=${chosen.has(id)} @click=${(event: MouseEvent) => app.toggle(id, event.ctrlKey || event.metaKey || event.shiftKey)}>${app.nameOf({ id, name })}</button></td>
      <td>${metric(volume, 3)}</td><td>${kilograms(mass)}</td><td>${(triangles.length / 3).toLocaleString('en')}</td></tr>`)}</tbody>
  </table></div>
  ${sorted.length > listed.length ? html`<button class="wide" @click=${() => app.set({ rows: rows + 200 })}>${words.pieces.more(sorted.length - listed.length)}</button>` : nothing}`;
}

function timings({ answer, toAnswer, toPicture }: Shown): TemplateResult {
  const { timing, cacheStatus = '' } = answer.head, stages = Object.entries(timing).filter(([name, value]) => name !== 'work' && value > 0.005);
  const server = stages.reduce((sum, [, value]) => sum + value, 0);
  const all: [string, number][] = [...stages.map(([name, value]): [string, number] => [words.pieces.stages[name] ?? name, value])];
  if (toAnswer > server) all.push([words.pieces.transfer, toAnswer - server]);
  if (toPicture > toAnswer) all.push([words.pieces.drawn, toPicture - toAnswer]);
  const most = Math.max(1e-9, ...all.map(([, value]) => value));
  return html`<ul class="bars">${all.map(([name, value]) => html`<li><span>${name}</span><i ${css({ '--share': String(value / most) })}></i><span class="figure">${milliseconds(value)}</span></li>`)}</ul>
    <p class="hint">${toPicture > 0 ? `${milliseconds(toPicture)} ${words.pieces.total}` : ''}${/result; ?hit/.test(cacheStatus) ? `, ${words.pieces.cached}` : ''}. ${words.pieces.bonds}: ${digits(answer.bonds.length)}</p>`;
}
