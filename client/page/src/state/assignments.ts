// Entries of the parameter `assign`, with their selectors as text: a node's name, node=NAME, slot=NAME or part=NUMBER.
import type { Assignment } from 'fracture-client';

const KINDS = ['node', 'slot', 'part'] as const;

/** Returns the entry with this selector instead of its own. */
export function entryOf(text: string, entry: Assignment): Assignment {
  const { node: _node, slot: _slot, part: _part, ...rest } = entry, kind = KINDS.find(known => text.startsWith(`${known}=`)), name = kind ? text.slice(kind.length + 1) : text;
  return { ...rest, [kind ?? 'node']: kind === 'part' ? Number(name) : name };
}

/** Returns the entry's selector as text. Further names of a list are left out. */
export function selectorOf(entry: Assignment): string {
  const kind = KINDS.find(known => entry[known] !== undefined);
  if (!kind) return '';
  const value = entry[kind], first = String(Array.isArray(value) ? value[0] : value);
  return kind === 'node' && !KINDS.some(known => first.startsWith(`${known}=`)) ? first : `${kind}=${first}`;
}
