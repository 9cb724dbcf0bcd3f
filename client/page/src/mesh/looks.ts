// What a sample is outside: shapes that the page makes have no colours that mean anything, so each looks like what it is made of.
import { Color } from 'three';
import type { Patterns } from 'fracture-client';
import type { Look } from './glb';

/** How much darker or paler than the colour of a fresh break it may be outside; and the brightest of linear light that a surface has. */
const AGED = [0.8, 1.35], WHITE = 0.85;

/** By what the server says of the cuts of a material; undefined where it says no colour of them. */
export function lookOf(material: Patterns['materials'][number] | undefined): Look | undefined {
  const { interior_color: color, interior_opacity: opacity = 1, interior_roughness: roughness = 0.8, interior_metallic: metallic = 0, interior_mix: mix = 0,
    interior_shade: shade = 0.8 } = material?.parameters ?? {};
  if (typeof color !== 'string') return undefined;
  const fresh = new Color(color), most = WHITE / Math.max(fresh.r, fresh.g, fresh.b);
  // Cuts take some of their colour from the outside: the one of both that they are told from more easily.
  const told = (aged: number) => Math.abs(Math.log((1 - Number(mix) + Number(mix) * Number(shade) * aged) / aged));
  const aged = AGED.map(by => Math.min(by, most)).reduce((best, by) => (told(by) > told(best) ? by : best));
  const { r, g, b } = fresh.multiplyScalar(Number(opacity) < 1 ? 1 : aged);
  return { color: [r, g, b, Number(opacity)], roughness: Number(roughness), metallic: Number(metallic) };
}
