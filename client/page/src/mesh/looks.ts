// The outer appearance of samples. Generated shapes have no meaningful colours, so each sample looks like its material.
import { Color } from 'three';
import type { Patterns } from 'fracture-client';
import type { Look } from './glb';

/** The range of factors by which the outside may be darker or paler than a fresh cut, and the maximum linear brightness of a surface. */
const AGED = [0.8, 1.35], WHITE = 0.85;

/** Returns the look of a sample, derived from the colour that the server gives for the material's cuts; undefined if there is none. */
export function lookOf(material: Patterns['materials'][number] | undefined): Look | undefined {
  const { interior_color: color, interior_opacity: opacity = 1, interior_roughness: roughness = 0.8, interior_metallic: metallic = 0, interior_mix: mix = 0,
    interior_shade: shade = 0.8 } = material?.parameters ?? {};
  if (typeof color !== 'string') return undefined;
  const fresh = new Color(color), most = WHITE / Math.max(fresh.r, fresh.g, fresh.b);
  // Cuts take on some of the outside colour, so choose the factor that makes the two easier to tell apart.
  const told = (aged: number) => Math.abs(Math.log((1 - Number(mix) + Number(mix) * Number(shade) * aged) / aged));
  const aged = AGED.map(by => Math.min(by, most)).reduce((best, by) => (told(by) > told(best) ? by : best));
  const { r, g, b } = fresh.multiplyScalar(Number(opacity) < 1 ? 1 : aged);
  return { color: [r, g, b, Number(opacity)], roughness: Number(roughness), metallic: Number(metallic) };
}
