// Lists of numbers as people write them: x,y,z;x,y,z as in a query.
import type { ParameterValue } from 'fracture-client';

export function textOf(value: ParameterValue | undefined): string {
  if (!Array.isArray(value)) return value === undefined ? '' : String(value);
  if (typeof value[0] === 'object' && !Array.isArray(value[0])) return JSON.stringify(value);  // the entries of `assign`
  return Array.isArray(value[0]) ? (value as number[][]).map(row => row.join(',')).join(';') : value.join(',');
}

/** Parses numbers; returns null if the text is not a list. `shape`: the server's notation. If it contains a semicolon, the result is
 * a list of lists. */
export function parseNumbers(text: string, shape: string): number[] | number[][] | null {
  const rows = text.split(';').map(row => row.split(/[,\s]+/).filter(Boolean).map(Number)).filter(row => row.length > 0);
  if (rows.length === 0 || rows.flat().some(value => !Number.isFinite(value))) return null;
  return shape.includes(';') ? rows : rows[0]!;
}
