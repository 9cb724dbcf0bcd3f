// The search field and its results: "/" focuses it, arrow keys select, Enter opens, Escape closes.
import { html, nothing, type TemplateResult } from 'lit';
import { words } from '../words/docs';
import { type Entry, excerptOf, type Found, partsOf, search } from './search';

/** Maximum number of results shown. Nobody reads more. */
const MOST = 40;

export class Finder {
  private all = 0;
  private query = '';
  private found: Found[] = [];
  private chosen = 0;
  private open = false;

  constructor(private readonly entries: () => Entry[], private readonly draw: () => void) {
    addEventListener('keydown', event => {
      if (event.key !== '/' || event.ctrlKey || event.metaKey || event.altKey || /^(?:INPUT|TEXTAREA|SELECT)$/.test(document.activeElement?.tagName ?? '')) return;
      event.preventDefault();
      this.field?.focus();
      this.field?.select();
    });
  }

  /** Repeats the search. Call it after entries were added. */
  again(): void {
    const found = search(this.entries(), this.query);
    this.all = found.length;
    this.found = found.slice(0, MOST);
    this.chosen = Math.min(this.chosen, Math.max(0, this.found.length - 1));
  }

  shown(): TemplateResult {
    const { open, query, found, chosen } = this, any = open && found.length > 0;
    return html`<div class="docs-find" role="search" @focusout=${(event: FocusEvent) => {
      if (!(event.currentTarget as Element).contains(event.relatedTarget as Node | null)) this.show(false);
    }}>
      <input type="search" role="combobox" aria-label=${words.search} placeholder=${words.hint} aria-expanded=${any} aria-controls="found" aria-autocomplete="list"
        aria-activedescendant=${any ? `found-${chosen}` : nothing} autocomplete="off" spellcheck="false" maxlength="200"
        @input=${(event: Event) => this.ask((event.target as HTMLInputElement).value)} @focus=${() => this.show(query !== '')} @keydown=${this.key}>
      <div class="docs-found" ?hidden=${!open || query.trim() === ''}>
        <p role="status">${!open || query.trim() === '' ? '' : words.found(this.all, found.length)}</p>
        <div id="found" role="listbox" aria-label=${words.search} ?hidden=${!any}>${open ? found.map(({ entry }, k) => this.one(entry, k)) : nothing}</div>
      </div></div>`;
  }

  private one({ at, of, title, heading, text }: Entry, k: number): TemplateResult {
    const where = title === '' || title === of ? of : `${of}${heading === '' ? '' : `: ${heading}`}`;
    return html`<a id="found-${k}" role="option" tabindex="-1" aria-selected=${k === this.chosen} href="#${at}" @click=${() => this.show(false)}>
      <b>${marked(title || heading, this.query)}</b>${title === of ? nothing : html` <small>${where}</small>`}<span>${marked(excerptOf(text, this.query))}</span></a>`;
  }

  private ask(query: string): void {
    this.query = query;
    this.chosen = 0;
    this.again();
    this.show(true);
  }

  private show(open: boolean): void {
    if (open === this.open && !open) return;
    this.open = open;
    this.draw();
  }

  private readonly key = (event: KeyboardEvent): void => {
    const step = { ArrowDown: 1, ArrowUp: -1 }[event.key], chosen = this.found[this.chosen];
    if (step && this.found.length > 0) {
      this.chosen = this.open ? (this.chosen + step + this.found.length) % this.found.length : 0;
      this.show(true);
      document.getElementById(`found-${this.chosen}`)?.scrollIntoView({ block: 'nearest' });
    } else if (event.key === 'Enter' && this.open && chosen) {
      document.getElementById(`found-${this.chosen}`)?.click();
      // After that, keys scroll the text.
      document.querySelector('main')?.focus({ preventScroll: true });
      this.show(false);
    } else if (event.key === 'Escape' && this.open) {
      this.show(false);
    } else {
      return;
    }
    event.preventDefault();
  };

  private get field(): HTMLInputElement | null {
    return document.querySelector('.docs-find input');
  }
}

const marked = (text: string | string[], query = '') => (typeof text === 'string' ? partsOf(text, query) : text).map((part, k) => (k % 2 === 1 ? html`<mark>${part}</mark>` : part));
