// The search in documents and interface. All words must be found; a title ranks higher than a heading, and a heading higher than text.
export interface Entry {
  /** The target of the entry. */
  at: string;
  /** The document that contains it. Its words count as found, but they do not affect the rank, because a title would otherwise raise
   * all sections of its document. */
  of: string;
  title: string;
  heading: string;
  text: string;
}
export interface Found {
  entry: Entry;
  score: number;
}

const FIELDS = [['title', 300], ['heading', 200], ['text', 100], ['of', 0]] as const;
const LETTER = /[\p{L}\p{N}_]/u;

export const wordsOf = (query: string): string[] => [...new Set(query.toLowerCase().split(/[\s,;]+/).filter(Boolean))];

/** Returns how well a word fits. 0: not found; 1: inside a word; 2: at the start of a word; 3: a whole word. */
function fit(text: string, word: string): number {
  let best = 0;
  for (let at = text.indexOf(word); at >= 0 && best < 3; at = text.indexOf(word, at + 1)) {
    const starts = !LETTER.test(text[at - 1] ?? ' ') || !LETTER.test(word[0]!), ends = !LETTER.test(text[at + word.length] ?? ' ');
    best = Math.max(best, starts ? (ends ? 3 : 2) : 1);
  }
  return best;
}

/** Returns the results, best first. Results of equal rank keep their order. */
export function search(entries: Entry[], query: string): Found[] {
  const words = wordsOf(query), phrase = words.join(' ');
  if (words.length === 0) return [];
  const found: Found[] = [];
  for (const entry of entries) {
    const fields = FIELDS.map(([name, weight]) => ({ text: entry[name].toLowerCase(), weight }));
    let score = 0;
    for (const word of words) {
      const best = Math.max(...fields.map(({ text, weight }) => {
        const how = fit(text, word);
        return how === 0 ? -1 : weight + 10 * how;
      }));
      score = best < 0 ? -Infinity : score + best;
    }
    if (score === -Infinity) continue;
    for (const { text, weight } of fields) {
      if (weight === 0 || text === '') continue;
      // Adjacent words rank higher, as does a title or heading that consists only of the search words.
      if (words.length > 1 && text.includes(phrase)) score += 20;
      if (text === phrase) score += 30;
    }
    found.push({ entry, score: score / words.length });
  }
  return found.sort((a, b) => b.score - a.score);
}

/** Returns the text around the first search word, split into parts; every second part is a search word. */
export function excerptOf(text: string, query: string, length = 150): string[] {
  const words = wordsOf(query), lower = text.toLowerCase(), first = Math.min(...words.map(word => lower.indexOf(word)).filter(at => at >= 0));
  let from = Number.isFinite(first) ? Math.max(0, first - 50) : 0;
  if (from > 0) from = text.indexOf(' ', from) + 1;
  const to = from + length < text.length ? text.lastIndexOf(' ', from + length) : text.length;
  const shown = `${from > 0 ? '… ' : ''}${text.slice(from, to > from ? to : from + length)}${to < text.length ? ' …' : ''}`;
  return partsOf(shown, query);
}

/** Splits a text into parts; every second part is a search word. */
export function partsOf(text: string, query: string): string[] {
  const words = wordsOf(query).map(word => word.replace(/[.*+?^${}()|[\]\\]/g, '\\$&'));
  return words.length === 0 ? [text] : text.split(new RegExp(`(${words.join('|')})`, 'gi'));
}
