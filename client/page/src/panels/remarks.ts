// Remarks on an answer or a mesh: warnings, what was dropped, notes, and why the number of fragments differs from the request.
import type { Dropped } from 'fracture-client';
import { html, nothing, type TemplateResult } from 'lit';
import type { Shown } from '../app/state';
import { words } from '../words/words';

/** Draws warnings, which are always visible, and collapsed lists of dropped items and of notes. */
export function remarkLists(warnings: readonly string[], notes: readonly string[], dropped: readonly Dropped[] = []): TemplateResult {
  const list = (texts: readonly string[]) => html`<ul class="notes">${texts.map(text => html`<li>${text}</li>`)}</ul>`;
  const collapsed = (title: string, texts: readonly string[]) => texts.length === 0 ? nothing
    : html`<details><summary>${title} <span class="hint">${texts.length.toLocaleString('en')}</span></summary>${list(texts)}</details>`;
  return html`
    ${warnings.length > 0 ? html`<div class="warnings"><h3>${words.remarks.warnings}</h3>${list(warnings)}</div>` : nothing}
    ${collapsed(words.remarks.dropped, dropped.map(({ what, name, reason }) => `${what}${name === '' ? '' : ` ${name}`}: ${reason}`))}
    ${collapsed(words.remarks.notes, notes)}`;
}

/** Explains why there are more or fewer fragments than requested; undefined if the number matches or none was requested. */
export function countRemark({ answer, wish: { hits } }: Shown): string | undefined {
  const asked = Number(answer.parameters['fragments'] ?? 0), made = answer.fragments.length;
  if (asked === 0 || asked === made) return undefined;
  return words.break.made(asked, made, reason(answer, asked, made, hits.length));
}

/** Returns the reason, which follows from the numbers. It does not parse the server's sentences, because their wording changes. */
function reason({ report, certificate, parameters }: Shown['answer'], asked: number, made: number, hits: number): string | undefined {
  if (hits > 0) return made > asked ? words.break.brokenOff(hits) : undefined;
  if (10 * made <= 11 * asked && 10 * made >= 9 * asked) return words.break.withinTenth;
  const { parts = 1, united = 0 } = (report['size'] ?? {}) as { parts?: number; united?: number };
  if (made > asked) return parts > asked ? words.break.separateParts(parts) : words.break.apart;
  if (made === parameters['max_fragments']) return words.break.atMost;
  return Number(certificate['united'] ?? 0) > united ? words.break.crossesItself : words.break.noMoreCells;
}
