// Samples to break without a file: in metres, standing on the ground, each with the material that suits it best.
import { glbOf, type Look, Surface } from './glb';

export interface Sample {
  name: string;
  /** The parameters of the first request, as far as the server knows them. */
  settings: Record<string, string | number>;
  /** Returns the sample as GLB, in the look of a material, or in its own look if none is given. */
  make(look?: Look): Uint8Array;
}

const CLAY: Look = { color: [0.42, 0.16, 0.08, 1], roughness: 0.75 };
const STONE: Look = { color: [0.36, 0.34, 0.31, 1], roughness: 0.85 };
const WOOD: Look = { color: [0.44, 0.25, 0.11, 1], roughness: 0.7 };
const PANE: Look = { color: [0.62, 0.80, 0.76, 0.35], roughness: 0.05 };
const MARBLE: Look = { color: [0.72, 0.70, 0.66, 1], roughness: 0.45 };
const BRICK: Look = { color: [0.36, 0.12, 0.07, 1], roughness: 0.9 };

/** Returns a Catmull–Rom curve through points of (radius, height). */
function smooth(points: readonly (readonly [number, number])[], steps: number): [number, number][] {
  const out: [number, number][] = [], at = (k: number) => points[Math.max(0, Math.min(points.length - 1, k))]!;
  for (let k = 0; k + 1 < points.length; ++k)
    for (let step = 0; step < steps; ++step) {
      const t = step / steps, p = [at(k - 1), at(k), at(k + 1), at(k + 2)] as const;
      const mix = (axis: 0 | 1) => 0.5 * (2 * p[1][axis] + (p[2][axis] - p[0][axis]) * t +
        (2 * p[0][axis] - 5 * p[1][axis] + 4 * p[2][axis] - p[3][axis]) * t * t +
        (3 * p[1][axis] - p[0][axis] - 3 * p[2][axis] + p[3][axis]) * t * t * t);
      out.push([Math.max(0, mix(0)), mix(1)]);
    }
  out.push([...at(points.length - 1)]);
  return out;
}

function vase(): Surface {
  const outside = smooth([[0.11, 0], [0.15, 0.06], [0.22, 0.24], [0.2, 0.42], [0.11, 0.55], [0.09, 0.62], [0.14, 0.7]], 6);
  const wall = 0.016, inside = outside.filter(([, y]) => y > 0.04).map(([r, y]): [number, number] => [r - wall, y + 0.002]).reverse();
  // From the centre of the foot up the outside, over the rim and down the inside, back to the centre.
  return new Surface().lathe([[0, 0], ...outside, ...inside, [0, 0.03]], 56);
}

function torus(radius: number, tube: number): Surface {
  const ring = Array.from({ length: 28 }, (_, k): [number, number] => {
    const angle = 2 * Math.PI * k / 28;
    return [radius + tube * Math.cos(angle), tube + tube * Math.sin(angle)];
  });
  return new Surface().lathe(ring, 64, true);
}

function sphere(radius: number): Surface {
  const profile = Array.from({ length: 33 }, (_, k): [number, number] => {
    const angle = Math.PI * k / 32;
    return [k === 0 || k === 32 ? 0 : radius * Math.sin(angle), radius - radius * Math.cos(angle)];
  });
  return new Surface().lathe(profile, 64);
}

function column(): Surface {
  const profile = smooth([[0.36, 0.12], [0.33, 0.25], [0.32, 1.1], [0.29, 2.0], [0.3, 2.1], [0.37, 2.22]], 4);
  return new Surface().lathe([[0, 0], [0.42, 0], [0.42, 0.11], ...profile, [0.42, 2.24], [0.42, 2.36], [0, 2.36]], 40);
}

const boxed = (w: number, h: number, d: number) => new Surface().box([0, h / 2, 0], [w, h, d]);

export const samples: readonly Sample[] = [
  { name: 'vase', settings: { material: 'terracotta', fragments: 40 }, make: (look = CLAY) => glbOf(vase(), 'vase', look) },
  { name: 'cube', settings: { material: 'stone', fragments: 40 }, make: (look = STONE) => glbOf(boxed(1, 1, 1), 'cube', look) },
  { name: 'sphere', settings: { material: 'ice', fragments: 60 }, make: (look = MARBLE) => glbOf(sphere(0.5), 'sphere', look) },
  { name: 'torus', settings: { material: 'ceramic', fragments: 60 }, make: (look = MARBLE) => glbOf(torus(0.5, 0.2), 'torus', look) },
  { name: 'column', settings: { material: 'sandstone', fragments: 50 }, make: (look = MARBLE) => glbOf(column(), 'column', look) },
  { name: 'plank', settings: { material: 'wood', fragments: 24 }, make: (look = WOOD) => glbOf(boxed(1.6, 0.12, 0.3), 'plank', look) },
  { name: 'pane', settings: { material: 'glass', fragments: 90 }, make: (look = PANE) => glbOf(boxed(1.2, 0.9, 0.012), 'pane', look) },
  { name: 'wall', settings: { material: 'brick', fragments: 80 }, make: (look = BRICK) => glbOf(boxed(2.4, 1.6, 0.22), 'wall', look) },
];

export const sampleOf = (name: string): Sample | undefined => samples.find(sample => sample.name === name);
