// Formats numbers for people.
const SUPERSCRIPT: Record<number, string> = { 1: '', 2: '²', 3: '³' };

export function digits(value: number, most = 3): string {
  if (value === 0) return '0';
  if (!Number.isFinite(value)) return '–';
  const size = Math.abs(value);
  return size >= 1e6 || size < 1e-4 ? value.toExponential(most - 1) : Number(value.toPrecision(most)).toLocaleString('en', { maximumSignificantDigits: most });
}

/** Formats metres, square metres or cubic metres (`power` 1, 2, 3) in a suitable unit: 12 cm³, 3.4 m². */
export function metric(value: number, power: 1 | 2 | 3): string {
  const units: [string, number][] = [['m', 1], ['cm', 0.01], ['mm', 0.001]];
  const size = Math.abs(value);
  const [unit, metres] = units.find(([, metres]) => size >= 0.1 ** (power - 1) * metres ** power) ?? units[2]!;
  return `${digits(value / metres ** power)} ${unit}${SUPERSCRIPT[power]}`;
}

export function kilograms(value: number): string {
  if (value >= 1000) return `${digits(value / 1000)} t`;
  return value >= 0.1 ? `${digits(value)} kg` : value >= 1e-4 ? `${digits(value * 1000)} g` : `${digits(value * 1e6)} mg`;
}

export const milliseconds = (value: number): string => (value >= 1000 ? `${digits(value / 1000)} s` : `${value < 10 ? value.toFixed(1) : Math.round(value)} ms`);
export const title = (name: string): string => (name.charAt(0).toUpperCase() + name.slice(1)).replaceAll('_', ' ');
export const bytes = (size: number): string => (size >= 1 << 20 ? `${digits(size / (1 << 20))} MiB` : `${Math.max(1, Math.round(size / 1024))} KiB`);
