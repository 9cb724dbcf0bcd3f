// The HTTP interface as a document, from /openapi.json of the server that sent this page.
import { html, nothing, type TemplateResult } from 'lit';
import { words } from '../words/docs';
import { examplesOf, type Operation, type Schema, typeOf } from './document';
import type { Entry } from './search';

export interface Document {
  info: { title: string; version: string; summary?: string; description?: string };
  tags?: { name: string; description?: string }[];
  paths: Record<string, Record<string, Operation>>;
  components: { schemas?: Record<string, Schema>; parameters?: Record<string, any>; responses?: Record<string, any> };
}
interface Call {
  path: string;
  method: string;
  operation: Operation;
}

const METHODS = ['get', 'put', 'post', 'delete', 'head', 'patch'];

export class Interface {
  readonly calls: Call[];
  readonly parameters: [string, Schema][];

  constructor(private readonly document: Document) {
    this.calls = Object.entries(document.paths).flatMap(([path, item]) => Object.entries(item).filter(([method]) => METHODS.includes(method))
      .map(([method, operation]) => ({ path, method, operation })));
    this.parameters = Object.entries(document.components.schemas?.['Parameters']?.properties ?? {});
  }

  /** Returns the object to which a $ref points. */
  private resolve<T>(value: any): T {
    let at = value;
    for (let depth = 0; typeof at?.$ref === 'string' && depth < 8; ++depth)
      at = (at.$ref as string).slice(2).split('/').reduce((node: any, key) => node?.[key.replaceAll('~1', '/').replaceAll('~0', '~')], this.document);
    return at as T;
  }

  private callsOf(tag: string): Call[] {
    return this.calls.filter(({ operation }) => operation.tags?.[0] === tag);
  }

  /** Returns entries for the search: operations and parameters. */
  entries(): Entry[] {
    const of = words.title, text = (...parts: (string | undefined)[]) => parts.filter(Boolean).join(' ').replaceAll('`', '').replace(/\s+/g, ' ');
    const calls = this.calls.map(({ path, method, operation }) => ({
      at: `${method} ${path}`, of, title: `${method.toUpperCase()} ${path}`, heading: operation.summary ?? '',
      text: text(operation.description, ...(operation.parameters ?? []).map(each => this.resolve<any>(each)).map(({ name, description }) => `${name}: ${description ?? ''}`)),
    }));
    const parameters = this.parameters.map(([name, source]) => {
      const schema = this.resolve<Schema>(source);
      return { at: `parameter ${name}`, of, title: name, heading: '', text: text(schema.description, typeOf(schema)) };
    });
    return [{ at: 'interface', of, title: of, heading: '', text: text(this.document.info.description) }, ...calls, ...parameters];
  }

  /** Draws the interface's part of the table of contents. */
  contents(): TemplateResult {
    return html`${(this.document.tags ?? []).map(({ name }) => html`<small>${name}</small>${this.callsOf(name).map(({ path, method }) => html`<a href="#${method} ${path}"><code>${method.toUpperCase()}</code> ${path}</a>`)}`)}
      ${this.parameters.length > 0 ? html`<a href="#parameters">${words.parameters} (${this.parameters.length})</a>` : nothing}`;
  }

  shown(): TemplateResult {
    const { info, tags = [] } = this.document;
    return html`<h1>${info.title} <small>${info.version}</small></h1><p>${info.description}</p>
      <p>${words.raw} <a href="/openapi.json">/openapi.json</a></p>
      ${tags.map(({ name, description }) => html`<h2>${name} <small>${description}</small></h2>${this.callsOf(name).map(each => this.one(each))}`)}
      ${this.parameters.length > 0 ? html`<h2 id="parameters">${words.parameters}</h2><dl class="docs-parameters">${this.parameters.map(([name, schema]) => this.parameter(name, schema))}</dl>` : nothing}`;
  }

  private one({ path, method, operation }: Call): TemplateResult {
    const parameters = (operation.parameters ?? []).map(each => this.resolve<any>(each)), few = parameters.filter(({ in: where }) => where !== 'query');
    const queries = parameters.filter(({ in: where }) => where === 'query'), body = Object.keys(this.resolve<any>(operation.requestBody)?.content ?? {});
    const shared = new Set(this.parameters.map(([name]) => name)), own = queries.filter(({ name }) => !shared.has(name));
    return html`<article id="${method} ${path}"><h3><code class="method">${method.toUpperCase()}</code> <code>${path}</code></h3>
      <p><b>${operation.summary}</b></p>${(operation.description ?? '').split('\n\n').filter(Boolean).map(text => html`<p>${marked(text)}</p>`)}
      ${few.length + own.length > 0 ? html`<dl class="docs-parameters">${[...few, ...own].map(({ name, in: where, description, schema }) => html`<div><dt><code>${name}</code> <small>${where}</small></dt>
        <dd>${marked(description)} <small>${typeOf(this.resolve<Schema>(schema))}</small></dd></div>`)}</dl>` : nothing}
      ${queries.length > own.length ? html`<p><a href="#parameters">${words.allParameters(queries.length - own.length)}</a></p>` : nothing}
      ${body.length > 0 ? html`<p>${words.body} ${body.map(type => html`<code>${type}</code> `)}</p>` : nothing}
      <table class="docs-answers"><tbody>${Object.entries(operation.responses).map(([status, answer]) => {
        const { description, content, headers } = this.resolve<any>(answer);
        return html`<tr><th scope="row">${status}</th><td>${marked(description)} ${Object.keys(content ?? {}).map(type => html`<code>${type}</code> `)}
          ${headers ? html`<details><summary>${words.headers}</summary><dl>${Object.entries<any>(headers).map(([name, header]) => html`<div><dt><code>${name}</code></dt><dd>${header.description}</dd></div>`)}</dl></details>` : nothing}</td></tr>`;
      })}</tbody></table>
      ${examplesOf(method, path, location.origin).map(text => html`<pre><code>${text}</code></pre>`)}</article>`;
  }

  private parameter(name: string, source: unknown): TemplateResult {
    const schema = this.resolve<Schema>(source);
    return html`<div id="parameter ${name}"><dt><code>${name}</code></dt><dd>${marked(schema.description)} <small>${typeOf(schema)}</small></dd></div>`;
  }
}

/** Shows `code` in descriptions as an element. */
const marked = (text = '') => text.split('`').map((part, k) => (k % 2 === 1 ? html`<code>${part}</code>` : part));
