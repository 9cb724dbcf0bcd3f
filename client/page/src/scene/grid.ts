// Lines on the ground. They fade out, because far away they would only be noise.
import { BufferAttribute, BufferGeometry, type Color, LineBasicMaterial, LineSegments } from 'three';

const LINES = 48, PARTS = 24;

/** Returns lines in the plane y = 0. Their spacing is a power of ten in metres that suits a mesh of this radius. */
export function gridOf(radius: number, { r, g, b }: Color): LineSegments<BufferGeometry, LineBasicMaterial> {
  const step = 10 ** Math.floor(Math.log10(radius * 0.9)), end = step * LINES / 2, positions: number[] = [], colours: number[] = [];
  const point = (along: number, beside: number, turned: boolean) => {
    positions.push(turned ? beside : along, 0, turned ? along : beside);
    colours.push(r, g, b, Math.max(0, 1 - (along * along + beside * beside) / (end * end)) ** 2);
  };
  for (let line = 0; line <= LINES; ++line)
    for (let part = 0; part < PARTS; ++part)
      for (const turned of [false, true]) {
        point(end * (2 * part / PARTS - 1), end * (2 * line / LINES - 1), turned);
        point(end * (2 * (part + 1) / PARTS - 1), end * (2 * line / LINES - 1), turned);
      }
  const geometry = new BufferGeometry().setAttribute('position', new BufferAttribute(new Float32Array(positions), 3))
    .setAttribute('color', new BufferAttribute(new Float32Array(colours), 4));
  return new LineSegments(geometry, new LineBasicMaterial({ vertexColors: true, transparent: true, depthWrite: false }));
}
