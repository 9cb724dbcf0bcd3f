// Pictures of materials, drawn from the settings that the server reports: cut colour, pattern, stretch. New materials on the server
// get a picture, too.
import type { Patterns } from 'fracture-client';

type Material = Patterns['materials'][number];
const SIZE = 72, made = new Map<string, string>();

/** Returns a random number generator (mulberry32). The same seed always gives the same picture of a material. */
function random(seed: number): () => number {
  return () => {
    seed = seed + 0x6d2b79f5 | 0;
    let t = Math.imul(seed ^ seed >>> 15, 1 | seed);
    t = t + Math.imul(t ^ t >>> 7, 61 | t) ^ t;
    return ((t ^ t >>> 14) >>> 0) / 4294967296;
  };
}

/** Returns the address of the picture: a data: URL that the page creates. */
export function swatch(material: Material, pattern: string): string {
  const key = `${material.name} ${JSON.stringify(material.parameters)}`;
  let url = made.get(key);
  if (!url) made.set(key, url = draw(material, pattern));
  return url;
}

function draw({ name, parameters }: Material, pattern: string): string {
  const canvas = document.createElement('canvas'), next = random([...name].reduce((sum, letter) => sum * 31 + letter.charCodeAt(0) | 0, 7));
  canvas.width = canvas.height = SIZE;
  const context = canvas.getContext('2d');
  if (!context) return '';
  const sites: [number, number][] = [];
  const stretch = Math.max(0.3, Math.min(5, Number(parameters['stretch'] ?? 1)));
  if (pattern === 'brick')
    for (let row = 0; row < 5; ++row) for (let k = -1; k < 4; ++k) sites.push([(k + (row % 2 ? 0.5 : 0) + 0.5) * 26, (row + 0.5) * SIZE / 5]);
  else if (pattern === 'radial')
    for (let ring = 0; ring < 4; ++ring)
      for (let k = 0; k < 9; ++k) {
        const angle = (k + 0.5 * next() + (ring % 2) * 0.3) * 2 * Math.PI / 9, r = 4 + ring * ring * 5 + 6 * next();
        sites.push([SIZE * 0.42 + r * Math.cos(angle), SIZE * 0.45 + r * Math.sin(angle)]);
      }
  else
    for (let k = 0; k < 22; ++k) {
      const near = pattern !== 'uniform' && k % 2 === 0 ? 0.45 : 1;
      sites.push([SIZE * (0.5 + near * (next() - 0.5) * 1.2), SIZE * (0.5 + near * (next() - 0.5) * 1.2)]);
    }
  const rough = Number(parameters['rough_amplitude'] ?? 0) * 60, sx = pattern === 'brick' || pattern === 'radial' ? 1 : 1 / Math.sqrt(stretch), sy = 1 / sx;
  const [r, g, b] = [1, 3, 5].map(at => parseInt(String(parameters['interior_color'] ?? '#9a9a9a').slice(at, at + 2), 16));
  const metal = Number(parameters['interior_metallic'] ?? 0), clear = 1 - Number(parameters['interior_opacity'] ?? 1);
  const image = context.createImageData(SIZE, SIZE), shades = sites.map(() => 0.72 + 0.42 * next());
  for (let y = 0; y < SIZE; ++y)
    for (let x = 0; x < SIZE; ++x) {
      const wx = x + rough * Math.sin(y * 0.45 + x * 0.1), wy = y + rough * Math.sin(x * 0.4);
      let first = Infinity, second = Infinity, owner = 0;
      sites.forEach(([px, py], k) => {
        const d = Math.hypot((wx - px) / sx, pattern === 'brick' ? (wy - py) * 1.8 : (wy - py) / sy);
        if (d < first) [second, first, owner] = [first, d, k];
        else if (d < second) second = d;
      });
      const crack = Math.min(1, (second - first) / 2.2);
      const light = (0.35 + 0.65 * crack) * shades[owner]! * (1 + metal * 0.35 * Math.sin((x + y) * 0.12 + owner) + clear * 0.2 * (1 - y / SIZE));
      image.data.set([r! * light, g! * light, b! * light, 255], 4 * (y * SIZE + x));
    }
  context.putImageData(image, 0, 0);
  return canvas.toDataURL('image/png');
}
