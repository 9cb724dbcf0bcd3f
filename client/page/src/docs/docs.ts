// The page /docs: the repository's documents and the HTTP interface, with a common search.
import { html, nothing, render, type TemplateResult } from 'lit';
import { unsafeHTML } from 'lit/directives/unsafe-html.js';
import { takeTheme } from '../app/theme';
import { words } from '../words/docs';
import { backToPage } from './back';
import { entriesOf, headingsOf, KINDS, type Page, shownOf } from './documents';
import { Finder } from './finder';
import { type Document, Interface } from './interface';
import { documentOf, INTERFACE, keepScroll, placeOf, scrollTo } from './places';
import type { Entry } from './search';

const root = document.getElementById('docs')!;
let pages: Page[] | undefined, service: Interface | undefined, entries: Entry[] = [], token = '', open = false, settled = false;
/** The reasons why the documents or the interface are missing: an HTTP status or a sentence. */
const missing = { documents: '', service: '' };
const finder = new Finder(() => entries, show);

const current = (): string => documentOf(placeOf(location.hash), (pages ?? []).map(({ path }) => path));

function show(): void {
  const at = current(), page = pages?.find(({ path }) => path === at);
  document.title = `${page?.name ?? words.title} - fracture`;
  render(html`<div class="docs-side"><div class="docs-top" role="banner">
      <a class="home" href="/" aria-label=${words.home} @click=${backToPage}>← <span>${words.home}</span></a>${finder.shown()}
      <button class="docs-menu" aria-expanded=${open} aria-controls="contents" @click=${() => {
        open = !open;
        show();
      }}>${words.contents}</button></div>
      <nav id="contents" class="docs-nav ${open ? 'open' : ''}" aria-label=${words.contents} @click=${(event: Event) => {
        if ((event.target as Element).closest('a')) open = false;
      }}>${KINDS.map(kind => html`<b>${words.kinds[kind]}</b>
        ${kind === 'reference' ? one(INTERFACE, words.title, at, () => service?.contents()) : nothing}
        ${(pages ?? []).filter(each => each.kind === kind).map(each => one(each.path, each.name, at, () => headingsOf(each).filter(({ level }) => level === 2)
          .map(({ id, text }) => html`<a href="#${id}">${text}</a>`)))}`)}</nav></div>
    <main class="docs-body" tabindex="-1">${page ? html`<p class="docs-path">${words.kinds[page.kind]} · <code>${page.path}</code>${page.pictures ? ` · ${words.pictures}` : ''}</p>
      <article class="docs-text">${unsafeHTML(shownOf(page))}</article>` : at === INTERFACE && pages ? html`${missing.documents ? html`<p role="status">${words.noDocuments} (${missing.documents})</p>` : nothing}${asked()}` : html`<p role="status">${words.loading}</p>`}</main>`, root);
}

/** Draws a document in the list, with its table of contents if it is open. */
function one(place: string, name: string, at: string, contents: () => unknown): TemplateResult {
  return html`<a href="#${place}" aria-current=${place === at ? 'page' : nothing}>${name}</a>${place === at ? html`<div class="docs-parts">${contents()}</div>` : nothing}`;
}

/** Draws the interface, or the reason why it is missing. */
function asked(): TemplateResult {
  if (service) return service.shown();
  return html`<h1>${words.title}</h1>${missing.service === '401' ? html`<form @submit=${(event: Event) => {
    event.preventDefault();
    token = String(new FormData(event.target as HTMLFormElement).get('token'));
    void loadInterface();
  }}><label>${words.token} <input name="token" type="password" autocomplete="off"></label> <button class="primary">${words.use}</button></form>`
  : html`<p role="status">${missing.service || words.loading}</p>`}`;
}

/** Fetches the JSON at an address. If that fails, returns undefined and stores the reason in `missing`. */
async function load<T>(address: string, what: keyof typeof missing): Promise<T | undefined> {
  try {
    const answer = await fetch(address, { headers: { Accept: 'application/json', ...(token ? { Authorization: `Bearer ${token}` } : {}) } });
    if (answer.ok) return await answer.json() as T;
    missing[what] = answer.status === 401 ? '401' : `${answer.status} ${answer.statusText}`;
  } catch {
    missing[what] = words.absent;
  }
  return undefined;
}

/** Returns whether the target of the address is available. */
function ready(): boolean {
  const at = current();
  return pages !== undefined && (at === INTERFACE ? service !== undefined : true);
}

/** Called after something has arrived. Goes to the target of the address, if the page was waiting for it. */
function arrived(): void {
  entries = [...(pages ?? []).flatMap(entriesOf), ...(service?.entries() ?? [])];
  finder.again();
  if (!settled && ready()) move();
  else show();
}

function move(): void {
  settled = ready();
  show();
  document.querySelector('.docs-nav [aria-current]')?.scrollIntoView({ block: 'nearest' });
  if (settled) scrollTo(placeOf(location.hash));
  reachable();
}

/** Makes tables and code that scroll sideways reachable with the keyboard. */
function reachable(): void {
  for (const each of document.querySelectorAll<HTMLElement>('.docs-body pre, .docs-body .table')) {
    if (each.scrollWidth > each.clientWidth) each.tabIndex = 0;
    else each.removeAttribute('tabindex');
  }
}

async function loadInterface(): Promise<void> {
  const found = await load<Document>('/openapi.json', 'service');
  if (found) service = new Interface(found);
  arrived();
}

takeTheme();
keepScroll();
addEventListener('hashchange', move);
// A link to the address that is already open fires no event for a new address, but must still go to its place.
addEventListener('click', event => {
  const link = (event.target as Element).closest?.<HTMLAnchorElement>('a[href^="#"]');
  if (link?.hash !== location.hash) return;
  event.preventDefault();
  history.replaceState(null, '');
  move();
});
addEventListener('resize', reachable);
show();
void loadInterface();
void load<Page[]>('/page/documents.json', 'documents').then(found => {
  pages = found ?? [];
  arrived();
});
