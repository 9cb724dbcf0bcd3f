// Converts the repository's documents to HTML for /docs. The build writes them into dist/page/documents.json. The
// output contains only the HTML that Markdown generates, because raw HTML other than comments aborts the build.
import fs from 'node:fs';
import path from 'node:path';
import { Marked } from 'marked';

const GUIDES = 'proto/guides';
/** In list order. A missing document aborts the build, because links to it would silently become text. */
const LISTED = {
  tutorial: ['README.md', 'client/python/README.md', 'client/typescript/README.md', 'client/blender/README.md', 'client/README.md'],
  'how-to': ['client/ENGINES.md', 'server/bake/README.md', 'docker/README.md'],
  reference: ['proto/interface.md', 'proto/parameters.md', 'proto/materials.md', 'server/README.md', 'client/OPERATIONS.md', 'CHANGELOG.md'],
  explanation: ['proto/README.md', 'client/page/README.md'],
};
/** Names in the list, instead of the first heading. */
const NAMES = { 'README.md': 'Quick start' };
/** Shown in the page's own way. */
const INTERFACE = 'proto/openapi.yaml';

/** Returns the paths of all documents, by kind. */
export function listed(root) {
  const guides = fs.readdirSync(path.join(root, GUIDES)).filter(name => name.endsWith('.md') && name !== 'README.md').sort().map(name => `${GUIDES}/${name}`);
  return { ...LISTED, 'how-to': [`${GUIDES}/README.md`, ...guides, ...LISTED['how-to']] };
}

/** Returns [{path, kind, name, html, pictures}]. `pictures`: true if the document has pictures, which are omitted. */
export function documents(root) {
  const paths = listed(root), known = new Set(Object.values(paths).flat());
  return Object.entries(paths).flatMap(([kind, files]) => files.map(file => {
    const { title, html, pictures } = rendered(file, fs.readFileSync(path.join(root, file), 'utf8'), known);
    return { path: file, kind, name: NAMES[file] ?? title, html, pictures };
  }));
}

const escaped = text => text.replace(/[&<>"]/g, letter => ({ '&': '&amp;', '<': '&lt;', '>': '&gt;', '"': '&quot;' })[letter]);
const plain = html => html.replace(/<[^>]*>/g, '');

/** Returns the anchor that GitHub generates for a heading. `seen` counts identical anchors. */
export function anchorOf(text, seen) {
  const base = text.trim().toLowerCase().replace(/[^\p{L}\p{M}\p{N}\p{Pc}\- ]/gu, '').replaceAll(' ', '-');
  let name = base;
  while (seen.has(name)) {
    seen.set(base, seen.get(base) + 1);
    name = `${base}-${seen.get(base)}`;
  }
  seen.set(name, 0);
  return name;
}

/**
 * Returns whether these tokens are only pictures, which are omitted because they would be larger than all of the text.
 */
function isPicture(tokens = []) {
  const solid = tokens.filter(({ type, raw }) => type !== 'text' || raw.trim() !== '');
  return solid.length > 0 && solid.every(({ type, tokens: inner }) => type === 'image' || (type === 'link' && isPicture(inner)));
}

/** Converts one document. Headings get the ids `path:anchor`, and links between documents become `#path:anchor`. */
export function rendered(file, markdown, known) {
  const seen = new Map();
  let title = '', pictures = false;
  const renderer = {
    heading({ tokens, depth }) {
      const html = this.parser.parseInline(tokens), text = this.parser.parseInline(tokens, this.parser.textRenderer);
      const anchor = anchorOf(text, seen);
      if (depth === 1 && title === '') title = text;
      return `<h${depth} id="${escaped(file)}:${anchor}">${html}</h${depth}>\n`;
    },
    html({ text }) {
      if (/^\s*<!--(?:(?!-->)[^])*-->\s*$/.test(text)) return '';
      throw new Error(`${file}: contains HTML, which /docs does not support: ${text.slice(0, 80)}`);
    },
    image() {
      pictures = true;
      return '';
    },
    link({ href, tokens }) {
      return linked(file, href, this.parser.parseInline(tokens), known);
    },
    paragraph({ tokens }) {
      const html = this.parser.parseInline(tokens);
      return isPicture(tokens) ? '' : `<p>${html}</p>\n`;
    },
    table({ header, rows }) {
      // A column that contains only pictures is omitted, too.
      const bare = cells => cells.some(({ tokens }) => isPicture(tokens)) && cells.every(({ text, tokens }) => text === '' || isPicture(tokens));
      const columns = header.map((_, k) => k).filter(k => !bare(rows.map(row => row[k])));
      if (columns.length < header.length) pictures = true;
      if (columns.length === 0) return '';
      const line = cells => `<tr>${columns.map(k => this.tablecell(cells[k])).join('').replaceAll('\n', '')}</tr>\n`;
      return `<div class="table"><table><thead>${line(header)}</thead><tbody>${rows.map(line).join('')}</tbody></table></div>\n`;
    },
    code: ({ text }) => `<pre><code>${escaped(text)}</code></pre>\n`,
  };
  const html = new Marked({ gfm: true, renderer }).parse(markdown);
  return { title, html: html.trim(), pictures };
}

function linked(file, href, html, known) {
  if (/^https?:\/\//.test(href)) return /^https?:\/\/(127\.0\.0\.1|localhost)\b/.test(href) ? html : `<a href="${escaped(href)}" rel="noopener">${html}</a>`;
  if (/^[a-z][a-z0-9+.-]*:/i.test(href)) throw new Error(`${file}: links to ${href}, but /docs allows only http and https`);
  const [place, anchor] = href.split('#'), full = place === '' ? file : path.posix.normalize(path.posix.join(path.posix.dirname(file), place));
  if (full === INTERFACE) return `<a href="#interface">${html}</a>`;
  if (known.has(full)) return `<a href="#${escaped(full)}${anchor ? `:${escaped(anchor)}` : ''}">${html}</a>`;
  // A source file is only in the repository, so its path is shown.
  const text = plain(html);
  if (text.includes(full)) return html;
  return text === path.posix.basename(full) ? `<code>${escaped(full)}</code>` : `${html} (<code>${escaped(full)}</code>)`;
}
