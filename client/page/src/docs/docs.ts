// The interface for people: /openapi.json of the server that sent this page, as text that can be read and searched.
import { html, nothing, render, type TemplateResult } from 'lit';
import { takeTheme } from '../app/theme';
import { words } from '../words/docs';
import { backToPage } from './back';
import { examplesOf, type Operation, type Schema, typeOf } from './document';

interface Document {
  info: { title: string; version: string; summary?: string; description?: string };
  tags?: { name: string; description?: string }[];
  paths: Record<string, Record<string, Operation>>;
  components: { schemas?: Record<string, Schema>; parameters?: Record<string, any>; responses?: Record<string, any> };
}

const METHODS = ['get', 'put', 'post', 'delete', 'head', 'patch'];
const root = document.getElementById('docs')!;
let filter = '', page: Document | undefined, problem = '', token = '';

function show(): void {
  render(page ? contents(page) : html`<div class="docs-body"><h1>${words.title}</h1>${problem === '401' ? html`<form @submit=${(event: Event) => {
    event.preventDefault();
    token = String(new FormData(event.target as HTMLFormElement).get('token'));
    void load();
  }}><label>${words.token} <input name="token" type="password" autocomplete="off"></label> <button class="primary">${words.use}</button></form>`
  : html`<p role="status">${problem || words.loading}</p>`}</div>`, root);
}

async function load(): Promise<void> {
  try {
    const answer = await fetch('/openapi.json', { headers: { Accept: 'application/json', ...(token ? { Authorization: `Bearer ${token}` } : {}) } });
    if (answer.ok) page = await answer.json() as Document;
    else problem = answer.status === 401 ? '401' : `${answer.status} ${answer.statusText}`;
  } catch {
    problem = words.absent;
  }
  show();
  if (page && location.hash) document.getElementById(decodeURIComponent(location.hash.slice(1)))?.scrollIntoView();
}

/** What a $ref stands for. */
function resolve<T>(value: any): T {
  let at = value;
  for (let depth = 0; typeof at?.$ref === 'string' && depth < 8; ++depth)
    at = (at.$ref as string).slice(2).split('/').reduce((node: any, key) => node?.[key.replaceAll('~1', '/').replaceAll('~0', '~')], page);
  return at as T;
}

function contents(document: Document): TemplateResult {
  const { info, tags = [], paths, components } = document, search = filter.trim().toLowerCase();
  const operations = Object.entries(paths).flatMap(([path, item]) => Object.entries(item).filter(([method]) => METHODS.includes(method))
    .map(([method, operation]) => ({ path, method, operation, text: `${method} ${path} ${operation.summary} ${operation.description ?? ''}`.toLowerCase() })));
  const found = operations.filter(({ text }) => text.includes(search)), properties = Object.entries(components.schemas?.['Parameters']?.properties ?? {});
  const parameters = properties.filter(([name, schema]) => `${name} ${resolve<Schema>(schema).description ?? ''}`.toLowerCase().includes(search));
  return html`<nav class="docs-nav" aria-label=${words.contents}><a class="home" href="/" @click=${backToPage}>${words.home}</a>
      <input type="search" aria-label=${words.search} placeholder=${words.search} @input=${(event: Event) => {
        filter = (event.target as HTMLInputElement).value;
        show();
      }}>
      ${tags.map(({ name }) => html`<b>${name}</b>${found.filter(({ operation }) => operation.tags?.[0] === name).map(({ path, method }) => html`<a href="#${method} ${path}"><code>${method.toUpperCase()}</code> ${path}</a>`)}`)}
      ${properties.length > 0 ? html`<b><a href="#parameters">${words.parameters} (${parameters.length})</a></b>` : nothing}</nav>
    <main class="docs-body"><h1>${info.title} <small>${info.version}</small></h1><p>${info.description}</p>
      <p>${words.raw} <a href="/openapi.json">/openapi.json</a></p>
      ${tags.map(({ name, description }) => {
        const own = found.filter(({ operation }) => operation.tags?.[0] === name);
        return own.length === 0 ? nothing : html`<h2>${name} <small>${description}</small></h2>${own.map(each => one(each.path, each.method, each.operation))}`;
      })}
      ${parameters.length > 0 ? html`<h2 id="parameters">${words.parameters}</h2><dl class="docs-parameters">${parameters.map(([name, schema]) => parameter(name, schema))}</dl>` : nothing}
    </main>`;
}

function one(path: string, method: string, operation: Operation): TemplateResult {
  const parameters = (operation.parameters ?? []).map(each => resolve<any>(each)), few = parameters.filter(({ in: where }) => where !== 'query');
  const queries = parameters.filter(({ in: where }) => where === 'query'), body = Object.keys(resolve<any>(operation.requestBody)?.content ?? {});
  const shared = new Set(Object.keys(page?.components.schemas?.['Parameters']?.properties ?? {})), own = queries.filter(({ name }) => !shared.has(name));
  return html`<article id="${method} ${path}"><h3><code class="method">${method.toUpperCase()}</code> <code>${path}</code></h3>
    <p><b>${operation.summary}</b></p>${(operation.description ?? '').split('\n\n').filter(Boolean).map(text => html`<p>${marked(text)}</p>`)}
    ${few.length + own.length > 0 ? html`<dl class="docs-parameters">${[...few, ...own].map(({ name, in: where, description, schema }) => html`<div><dt><code>${name}</code> <small>${where}</small></dt>
      <dd>${marked(description)} <small>${typeOf(resolve<Schema>(schema))}</small></dd></div>`)}</dl>` : nothing}
    ${queries.length > own.length ? html`<p><a href="#parameters">${words.allParameters(queries.length - own.length)}</a></p>` : nothing}
    ${body.length > 0 ? html`<p>${words.body} ${body.map(type => html`<code>${type}</code> `)}</p>` : nothing}
    <table><tbody>${Object.entries(operation.responses).map(([status, answer]) => {
      const { description, content, headers } = resolve<any>(answer);
      return html`<tr><th scope="row">${status}</th><td>${marked(description)} ${Object.keys(content ?? {}).map(type => html`<code>${type}</code> `)}
        ${headers ? html`<details><summary>${words.headers}</summary><dl>${Object.entries<any>(headers).map(([name, header]) => html`<div><dt><code>${name}</code></dt><dd>${header.description}</dd></div>`)}</dl></details>` : nothing}</td></tr>`;
    })}</tbody></table>
    ${examplesOf(method, path, location.origin).map(text => html`<pre><code>${text}</code></pre>`)}</article>`;
}

function parameter(name: string, source: unknown): TemplateResult {
  const schema = resolve<Schema>(source);
  return html`<div id="parameter ${name}"><dt><code>${name}</code></dt><dd>${marked(schema.description)} <small>${typeOf(schema)}</small></dd></div>`;
}

/** `code` as it stands in descriptions. */
const marked = (text = '') => text.split('`').map((part, k) => (k % 2 === 1 ? html`<code>${part}</code>` : part));

takeTheme();
show();
void load();
