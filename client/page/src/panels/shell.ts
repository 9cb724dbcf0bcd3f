// The whole page: header, viewport with its overlays, panel, sheets.
import { html, nothing, type TemplateResult } from 'lit';
import { live } from 'lit/directives/live.js';
import type { App } from '../app/app';
import type { Tab, Tool } from '../app/state';
import { colourModes } from '../scene/colours';
import { words } from '../words/words';
import { breakPanel } from './breaking';
import { sealButton } from './certificate';
import { css } from './css';
import { milliseconds } from './format';
import { icons } from './icons';
import { meshPanel } from './mesh';
import { chooser, sampleBar } from './opening';
import { piecesPanel } from './pieces';
import { playBar } from './playing';
import { problemNotice } from './problem';
import { sheets } from './sheets';
import { takePanel } from './taking';

const TABS: readonly [Tab, (app: App) => TemplateResult][] = [['mesh', meshPanel], ['break', breakPanel], ['pieces', piecesPanel], ['take', takePanel]];

/** Draws the whole page. `canvas` is created once and never moves. */
export function shell(app: App, canvas: HTMLCanvasElement): TemplateResult {
  const { tab } = app.state, panel = TABS.find(([name]) => name === tab)![1];
  return html`
    ${header(app)}
    ${sampleBar(app)}
    <main class=${app.state.play ? 'playing' : ''}>
      <div class="viewport ${app.isOfEarlier ? 'earlier' : ''}" id="viewport">
        ${canvas}
        ${instead(app)}
        ${app.state.play ? nothing : toolbar(app)}
        ${status(app)}
        ${problemNotice(app)}
        ${app.state.play ? playBar(app) : dock(app)}
      </div>
      <aside class="panel">
        <div class="tabs" role="tablist" @keydown=${(event: KeyboardEvent) => turnTab(app, event)}>${TABS.map(([name]) => html`<button role="tab" id="tab-${name}" aria-selected=${tab === name}
          aria-controls="panel" tabindex=${tab === name ? 0 : -1} @click=${() => app.set({ tab: name })}>${words.tabs[name]}</button>`)}</div>
        <div class="panel-body" id="panel" role="tabpanel" tabindex="0" aria-labelledby="tab-${tab}">${panel(app)}</div>
      </aside>
    </main>
    ${sheets(app)}`;
}

/** Shows a message in place of the picture: why there is none, and what the user can do. */
function instead({ service, state: { webgl, lost, source, bringing, problem } }: App): TemplateResult | typeof nothing {
  if (!webgl) return html`<p class="instead">${words.noWebgl}</p>`;
  if (lost) return html`<p class="instead" role="status">${words.lost}</p>`;
  if (service.state === 'connecting' || source || bringing || problem) return nothing;
  return service.state === 'absent' ? html`<p class="instead" role="status">${words.header.away}</p>` : html`<p class="instead">${words.mesh.drop}<br><span class="hint">${words.mesh.dropMore}</span></p>`;
}

function turnTab(app: App, event: KeyboardEvent): void {
  const by = event.key === 'ArrowRight' ? 1 : event.key === 'ArrowLeft' ? -1 : 0;
  if (by === 0) return;
  event.preventDefault();
  const names = TABS.map(([name]) => name), next = names[(names.indexOf(app.state.tab) + by + names.length) % names.length]!;
  app.set({ tab: next });
  requestAnimationFrame(() => document.getElementById(`tab-${next}`)?.focus());
}

function header(app: App): TemplateResult {
  const { state, knowledge } = app.service;
  const text = state === 'ready' ? words.header.ready(knowledge!.version.version, knowledge!.version.algorithm) : state === 'absent' ? words.header.away
    : state === 'token' ? words.header.token : words.header.connecting;
  return html`<header>
    <h1><img src="/page/icon.svg" alt="" width="20" height="20"><span>${words.title}</span></h1>
    ${chooser(app, words.mesh.open, false, 'primary')}
    <span class="mesh-name">${app.state.source?.label ?? ''}</span>
    <span class="server ${state}" role="status"><i></i><span>${text}</span></span>
    <span class="spring"></span>
    <button class="plain" title="${words.header.undo} (Ctrl Z)" aria-label=${words.header.undo} ?disabled=${!app.breaking.canUndo} @click=${() => app.breaking.step(-1)}>${icons.undo}</button>
    <button class="plain" title="${words.header.redo} (Ctrl Y)" aria-label=${words.header.redo} ?disabled=${!app.breaking.history.canRedo} @click=${() => app.breaking.step(1)}>${icons.redo}</button>
    <a class="button plain" href="/docs" title=${words.header.docs} aria-label=${words.header.docs}>${icons.docs}</a>
    <button class="plain" title=${words.header.theme} aria-label=${words.header.theme} @click=${() => app.turnTheme()}>${icons.theme}</button>
    <button class="plain" title="${words.header.keys} (?)" aria-label=${words.header.keys} aria-haspopup="dialog" @click=${() => app.set({ sheet: 'keys' })}>${icons.keys}</button>
  </header>`;
}

const TOOLS: readonly [Tool, string, string][] = [
  ['hit', words.tools.hit, words.tools.hitHint], ['aim', words.tools.aim, words.tools.aimHint], ['select', words.tools.select, words.tools.selectHint],
];

function toolbar(app: App): TemplateResult {
  return html`<div class="toolbar floating" role="group" aria-label=${words.title}>${TOOLS.map(([tool, label, hint]) => html`<button aria-pressed=${app.state.tool === tool}
      title="${hint} (${label[0]})" aria-label=${label} @click=${() => app.set({ tool })}>${icons[tool]}<span>${label}</span></button>`)}</div>`;
}

function status(app: App): TemplateResult {
  const { shown, inFlight, job, bringing } = app.state;
  if (!bringing && !job && !shown && inFlight === 0) return html``;
  return html`<div class="status floating" role="status">
    ${bringing ? html`<span class="busy"></span>${words.mesh.reading(bringing)}`
    : job ? html`<progress max="100" value=${job.percent} aria-label=${words.status.job(job.stage, job.percent)}></progress>
        <span>${job.state === 'queued' && job.queue_position ? words.status.queue(job.queue_position) : words.status.job(job.stage, job.percent)}</span>
        <button @click=${() => app.breaking.giveUp()}>${words.status.cancel}</button>`
    : shown ? html`<b>${shown.answer.fragments.length.toLocaleString('en')}<span class="narrow-hide"> ${words.look.fragments(shown.answer.fragments.length)}</span></b>
        <span class="figure time">${app.isOfEarlier ? html`<span class="amber" title=${words.status.earlierHint}>${words.status.earlier}</span>` : inFlight > 0 ? words.status.asking : shown.toPicture > 0 ? html`${milliseconds(shown.toPicture)}<span class="narrow-hide"> ${words.status.toPicture}</span>` : ''}</span>${sealButton(app)}`
    : inFlight > 0 ? html`<span class="busy"></span>${words.status.asking}` : nothing}
  </div>`;
}

function dock(app: App): TemplateResult {
  const { look, shown } = app.state, levels = shown?.answer.figures.levels?.length ?? 0, level = Math.min(look.level, levels);
  if (!shown) return html``;
  const flip = (name: 'cutsOnly' | 'wireframe' | 'bonds', icon: TemplateResult, label: string, hint: string) => html`<button aria-pressed=${look[name]} title=${hint} aria-label=${label}
    @click=${() => app.look({ [name]: !look[name] })}>${icon}<span>${label}</span></button>`;
  return html`<div class="dock floating">
    <label class="explode"><span>${words.look.explode}</span><input id="explode" aria-label=${words.look.explode} type="range" min="0" max="1" step="0.001" .value=${live(String(Math.sqrt(look.explode / 3)))}
      @input=${(event: Event) => app.look({ explode: 3 * Number((event.target as HTMLInputElement).value) ** 2 })}></label>
    <label class="colours"><span>${words.look.colours}</span><select aria-label=${words.look.colours} .value=${live(look.colours)} @change=${(event: Event) => app.look({ colours: (event.target as HTMLSelectElement).value as typeof look.colours })}>
      ${colourModes.filter(mode => mode !== 'level' || levels > 0 || look.colours === 'level').map(mode => html`<option value=${mode} ?selected=${mode === look.colours}>${words.look.modes[mode]}</option>`)}</select>
      ${look.colours === 'size' || look.colours === 'strength' ? html`<span class="legend" aria-hidden="true">${look.colours === 'size' ? words.look.small : words.look.weak}<i ${css({})}></i>${look.colours === 'size' ? words.look.large : words.look.strong}</span>` : nothing}</label>
    ${levels > 0 ? html`<label><span>${words.look.level}</span><input aria-label=${words.look.level} type="range" min="0" max=${levels} step="1" .value=${live(String(level))}
      aria-valuetext=${level === levels ? words.look.fragments(2) : String(level + 1)} @input=${(event: Event) => app.look({ level: Number((event.target as HTMLInputElement).value) })}></label>` : nothing}
    <span class="flips">${flip('cutsOnly', icons.cuts, words.look.cuts, `${words.look.cutsHint} (C)`)}${flip('wireframe', icons.wire, words.look.wire, `${words.look.wireHint} (W)`)}${flip('bonds', icons.bonds, words.look.bonds, `${words.look.bondsHint} (B)`)}
    <button title="${words.look.fitHint} (F)" aria-label=${words.look.fit} @click=${() => app.fit()}>${icons.fit}<span>${words.look.fit}</span></button></span>
    ${app.stage ? html`<button class="primary play" title="${words.play.play} (P)" aria-label=${words.play.play} @click=${() => app.playing.toggle()}>${icons.play}<span>${words.play.play}</span></button>` : nothing}
  </div>`;
}
