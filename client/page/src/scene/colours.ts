// Colours with a meaning: by fragment, size, level or bond strength.
import type { Answer } from 'fracture-client';
import { Color } from 'three';

export type ColourMode = 'material' | 'fragment' | 'size' | 'level' | 'strength';
export const colourModes: readonly ColourMode[] = ['material', 'fragment', 'size', 'level', 'strength'];

/** Viridis (van der Walt and Smith 2015) in nine sRGB steps: perceptually uniform, even for colour-blind people. */
const RAMP = ['#440154', '#472d7b', '#3b528b', '#2c728e', '#21918c', '#28ae80', '#5ec962', '#addc30', '#fde725'].map(text => new Color(text));

export function ramp(t: number): Color {
  const at = Math.max(0, Math.min(1, Number.isFinite(t) ? t : 0)) * (RAMP.length - 1), k = Math.min(RAMP.length - 2, Math.floor(at));
  return RAMP[k]!.clone().lerp(RAMP[k + 1]!, at - k);
}

/** Hues a golden ratio apart, so that consecutive numbers have very different hues. */
export const distinct = (k: number): Color => new Color().setHSL((k * 0.618034) % 1, 0.55, 0.42 + 0.16 * ((k * 0.7548) % 1));

/** Returns the cluster of each fragment at a level. Level 0 is the coarsest. Returns undefined if the answer has no levels, or if
 * `level` is the level of the fragments themselves. */
export function clustersAt(answer: Answer, level: number): Map<number, number> | undefined {
  const levels = answer.figures.levels ?? [];
  if (level >= levels.length) return undefined;
  const parents = levels.slice(level + 1).map(({ id, parent }) => new Map<number, number>((id as number[]).map((own, k) => [own, parent[k] as number])));
  return new Map(answer.fragments.map(({ id, parent }) => {
    let at = parent ?? id;
    for (const up of [...parents].reverse()) at = up.get(at) ?? at;
    return [id, at];
  }));
}

/** Returns, for each fragment, the sum of the strengths of its bonds (N). */
export function strengthOf(answer: Answer): Map<number, number> {
  const sum = new Map<number, number>();
  for (const { a, b, strength } of answer.bonds) for (const id of [a, b]) sum.set(id, (sum.get(id) ?? 0) + strength);
  return sum;
}

/** Returns a colour for each fragment; undefined for a mode without colours. `level`: the level for colouring by level. */
export function coloursOf(answer: Answer, mode: ColourMode, level: number): Color[] | undefined {
  const { fragments } = answer;
  if (mode === 'material') return undefined;
  if (mode === 'fragment') return fragments.map((_, k) => distinct(k));
  if (mode === 'level') {
    const clusters = clustersAt(answer, level), numbers = new Map<number, number>();
    return fragments.map(({ id, part }) => {
      const key = clusters?.get(id) ?? part;
      if (!numbers.has(key)) numbers.set(key, numbers.size);
      return distinct(numbers.get(key)!);
    });
  }
  const strength = mode === 'strength' ? strengthOf(answer) : undefined;
  const values = fragments.map(({ id, volume }) => Math.log(Math.max(1e-30, strength ? strength.get(id) ?? 0 : volume)));
  const known = values.filter(value => value > Math.log(1e-30) + 1), low = known.reduce((a, b) => Math.min(a, b), Infinity);
  const high = known.reduce((a, b) => Math.max(a, b), -Infinity);
  return values.map(value => ramp(high > low ? (value - low) / (high - low) : 0.5));
}
