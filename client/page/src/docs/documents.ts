// The repository's documents, converted to HTML by the build (documents.mjs).
import type { Entry } from './search';

export type Kind = 'tutorial' | 'how-to' | 'reference' | 'explanation';
export const KINDS: Kind[] = ['tutorial', 'how-to', 'reference', 'explanation'];
export interface Page {
  path: string;
  kind: Kind;
  name: string;
  html: string;
  /** True if the document has pictures, which are omitted here. */
  pictures: boolean;
}
export interface Heading {
  id: string;
  level: number;
  text: string;
}

const HEADING = /<h([1-6]) id="([^"]+)">([^]*?)<\/h\1>/g;
const LETTERS: Record<string, string> = { '&lt;': '<', '&gt;': '>', '&quot;': '"', '&#39;': "'", '&amp;': '&' };

/** Converts HTML to text. Inline elements are joined without a space; blocks are separated. */
export function textOf(html: string): string {
  return html.replace(/<\/?(?:a|code|del|em|strong)\b[^>]*>/g, '').replace(/<[^>]*>/g, ' ').replace(/&(?:lt|gt|quot|#39|amp);/g, found => LETTERS[found]!)
    .replace(/\s+/g, ' ').trim();
}

export function headingsOf({ html }: Page): Heading[] {
  return [...html.matchAll(HEADING)].map(([, level, id, inner]) => ({ id: id!, level: Number(level), text: textOf(inner!) }));
}

/** Returns the document as it is shown. Each heading links to itself, so that users can share the link. */
export function shownOf({ html }: Page): string {
  return html.replace(HEADING, (all, level: string, id: string, inner: string) => (level === '1' || inner.includes('<a ') ? all
    : `<h${level} id="${id}"><a href="#${id}">${inner}</a></h${level}>`));
}

/** Returns entries for the search: the document and each of its sections. */
export function entriesOf(page: Page): Entry[] {
  const found = [...page.html.matchAll(HEADING)];
  return found.map((match, k) => {
    const [all, , id, inner] = match, text = textOf(page.html.slice(match.index + all.length, found[k + 1]?.index));
    return k === 0 ? { at: page.path, of: page.name, title: page.name, heading: '', text } : { at: id!, of: page.name, title: '', heading: textOf(inner!), text };
  });
}
