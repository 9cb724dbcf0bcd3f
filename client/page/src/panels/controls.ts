// A control for any parameter that the server describes: its type, range, choices, default and unit.
import type { ParameterDescription, ParameterValue } from 'fracture-client';
import { html, nothing, type TemplateResult } from 'lit';
import { live } from 'lit/directives/live.js';
import type { App } from '../app/app';
import { words } from '../words/words';
import { digits, title } from './format';
import { icons } from './icons';
import { parseNumbers, textOf } from './lists';

/** The largest range with a slider. A wider range gets only a field, because a slider cannot select one value among millions. */
const SLIDER_RANGE = 1000;
/** The end of the slider for counts. The server allows far larger counts than people need; the field accepts them all. */
const COUNT_END = 400;

/** Returns the value that applies if the user sets none: the material's, or else the default. */
export function effective(app: App, parameter: ParameterDescription): ParameterValue | undefined {
  const { settings } = app.state.wish, material = app.service.knowledge?.patterns.materials.find(({ name }) => name === settings['material']);
  return settings[parameter.name] ?? material?.parameters[parameter.name] ?? parameter['default'];
}

/** Returns the special meaning of 0 from the server's description; undefined if 0 is an ordinary amount. */
export function zeroOf({ description = '' }: ParameterDescription): string | undefined {
  if (/\b0: `\w+` determines\b/.test(description)) return words.break.auto;
  return /\b0: no limit\b/.test(description) ? words.break.noLimit : undefined;
}

/** Rejected numbers by parameter name, with the limits that they exceed. */
const refused = new Map<string, string>();

export function control(app: App, parameter: ParameterDescription): TemplateResult {
  const { name, type, description } = parameter, set = app.state.wish.settings[name] !== undefined, id = `p-${name}`;
  const unit = parameter['unit'] as string | undefined;
  return html`<div class="control ${set ? 'is-set' : ''}">
    <label for=${id} title=${description.replaceAll('`', '')}>${title(name)}${unit ? html` <span class="unit">${unit}</span>` : nothing}</label>
    ${set ? html`<button class="plain small" title=${words.break.reset} aria-label="${words.break.reset}: ${title(name)}"
        @click=${() => {
          refused.delete(name);
          app.breaking.setParameter(name, undefined);
        }}>${icons.reset}</button>` : nothing}
    ${field(app, parameter, id, type)}
    ${refused.has(name) ? html`<p class="hint amber" role="status" id="${id}-beyond">${refused.get(name)}</p>` : nothing}
  </div>`;
}

function field(app: App, parameter: ParameterDescription, id: string, type: string): TemplateResult {
  const { name } = parameter, value = effective(app, parameter), put = (next: ParameterValue | undefined, settled = true) => app.breaking.setParameter(name, next, settled);
  const choices = parameter['enum'] as string[] | undefined;
  if (choices) {
    return html`<select id=${id} .value=${live(String(value ?? ''))} @change=${(event: Event) => put((event.target as HTMLSelectElement).value || undefined)}>
      ${value === undefined ? html`<option value="">${words.break.unset}</option>` : nothing}
      ${choices.map(choice => html`<option value=${choice} ?selected=${choice === value}>${choice}</option>`)}
    </select>`;
  }
  if (type === 'number' || type === 'integer') return numbers(app, parameter, id, value as number | undefined, put);
  if (type === 'boolean') {
    return html`<input type="checkbox" id=${id} .checked=${live(value === true)} @change=${(event: Event) => put((event.target as HTMLInputElement).checked)}>`;
  }
  if (type === 'array') {
    const shape = String(parameter['text'] ?? 'a,b,c'), text = textOf(value), point = /^x,y,z/.test(shape) && parameter['unit'] === 'm';
    return html`<span class="row"><input id=${id} type="text" spellcheck="false" placeholder=${shape} .value=${live(text)} @change=${(event: Event) => {
      const input = event.target as HTMLInputElement, read = input.value.trim() === '' ? undefined : parseNumbers(input.value, shape);
      input.setCustomValidity(read === null ? shape : '');
      input.reportValidity();
      if (read !== null) put(read);
    }}>${point ? html`<button class="plain small" title=${words.break.pickPoint} aria-label="${words.break.pickPoint}: ${title(name)}"
        aria-pressed=${app.breaking.pickingFor === name} @click=${() => app.breaking.pickFor(name)}>${icons.aim}</button>` : nothing}</span>`;
  }
  if (/#\[0-9a-fA-F\]/.test(String(parameter['pattern'] ?? ''))) {
    return html`<input type="color" id=${id} .value=${live(typeof value === 'string' ? value : '#808080')}
      @input=${(event: Event) => put((event.target as HTMLInputElement).value, false)} @change=${(event: Event) => put((event.target as HTMLInputElement).value)}>`;
  }
  return html`<input type="text" id=${id} spellcheck="false" .value=${live(String(value ?? ''))}
    @change=${(event: Event) => put((event.target as HTMLInputElement).value.trim() || undefined)}>`;
}

function numbers(app: App, parameter: ParameterDescription, id: string, value: number | undefined, put: (value: number | undefined, settled?: boolean) => void): TemplateResult {
  const { name, type } = parameter, whole = type === 'integer', low = Number(parameter['minimum'] ?? 0), high = Number(parameter['maximum'] ?? 1);
  const count = whole && high >= 10000 && low <= 1 && !/seed|id|fragment$/.test(name), range = high - low;
  const end = count ? COUNT_END : high;
  const given = (text: string) => {
    const read = Number(text);
    if (text.trim() === '' || !Number.isFinite(read)) return undefined;
    return whole ? Math.round(read) : read;
  };
  // A value that the server would refuse is rejected, and the old value stays.
  const taken = (input: HTMLInputElement) => {
    const next = given(input.value);
    if (next !== undefined && (next < low || next > high)) {
      refused.set(name, words.break.beyond(next, low, high));
      app.set({});
      return;
    }
    refused.delete(name);
    put(next);
    app.set({});
  };
  const zero = value === 0 ? zeroOf(parameter) : undefined;
  const box = html`<input type="number" id=${id} min=${low} max=${high} step=${whole ? 1 : 'any'} placeholder=${zero ?? words.break.unset} aria-describedby=${refused.has(name) ? `${id}-beyond` : nothing}
    .value=${live(value === undefined || zero ? '' : String(value))} @change=${(event: Event) => taken(event.target as HTMLInputElement)}>`;
  if (name === 'seed') {
    return html`<span class="row">${box}<button class="plain small" title=${words.break.reseed} aria-label=${words.break.reseed}
      @click=${() => app.breaking.reseed()}>${icons.dice}</button></span>`;
  }
  if (!count && range > SLIDER_RANGE) return box;
  // The scale is quadratic, because small values matter most.
  const bend = count || range > 20 || high / Math.max(1e-9, Number(value ?? low) || high) > 8 ? 2 : 1;
  const toSlider = (v: number) => 1000 * Math.max(0, Math.min(1, (v - low) / (end - low))) ** (1 / bend);
  const fromSlider = (s: number) => {
    const v = low + (end - low) * (s / 1000) ** bend;
    return whole ? Math.round(v) : Number(v.toPrecision(3));
  };
  const moved = (event: Event, settled: boolean) => {
    refused.delete(name);
    put(fromSlider(Number((event.target as HTMLInputElement).value)), settled);
  };
  // A key press adds 1 or a hundredth of the range, because the browser's own step may be lost in rounding.
  // It starts from the value requested last, because a repeating key is faster than the drawing of the panel.
  const pressed = (event: KeyboardEvent) => {
    const by = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1, PageUp: 10, PageDown: -10 }[event.key], now = Number(effective(app, parameter) ?? low);
    if (by === undefined) return;
    event.preventDefault();
    put(whole ? Math.max(low, Math.min(high, now + by)) : fromSlider(Math.max(0, Math.min(1000, toSlider(now) + 10 * by))), false);
  };
  return html`<span class="row"><input type="range" class="grow" @keydown=${pressed} @keyup=${() => app.breaking.letGo()} @blur=${() => app.breaking.letGo()} min="0" max="1000" step="1" aria-label=${title(name)} aria-valuetext=${zero ?? digits(value ?? low)}
      .value=${live(String(Math.round(toSlider(value ?? low))))} @input=${(event: Event) => moved(event, false)} @change=${(event: Event) => moved(event, true)}>${box}</span>`;
}
