// Parameters for points, regions and directions, which belong to one mesh and can be dragged in its view. They are recognized by the
// server's description, so that new ones are found: spheres (x_center with x_radius), boxes (x_box), planes (x_plane: a point and a
// normal), directions (three numbers without a unit), and families of planes (lists of such).
import type { ParameterDescription, ParameterValue } from 'fracture-client';
import type { Settings } from './request';

export type PlaceKind = 'sphere' | 'box' | 'plane' | 'direction' | 'normals';
type Triple = [number, number, number];
/** The mesh, in metres, in the answer's frame. */
export interface Bounds {
  low: Triple;
  high: Triple;
}

const POINT = 'x,y,z', POINTS = 'x,y,z;x,y,z';

/** Returns the kind of each place, by the name of the parameter that contains its position (for a sphere, its centre). */
export function placesIn(parameters: readonly ParameterDescription[]): Map<string, PlaceKind> {
  const names = new Set(parameters.map(({ name }) => name)), places = new Map<string, PlaceKind>();
  for (const { name, type, text, unit } of parameters) {
    if (type !== 'array') continue;
    if (name.endsWith('_center') && names.has(radiusOf(name))) places.set(name, 'sphere');
    else if (name.endsWith('_box') && text === POINTS) places.set(name, 'box');
    else if (name.endsWith('_plane') && text === POINTS) places.set(name, 'plane');
    else if (text === POINT && !unit) places.set(name, 'direction');
    else if (text === POINTS && !unit) places.set(name, 'normals');
  }
  return places;
}

export const radiusOf = (center: string): string => center.replace(/_center$/, '_radius');

/** Returns the settings that also apply to other meshes: no lists in metres, no planes, and no radius without its centre. */
export function withoutPlaces(settings: Settings, parameters: readonly ParameterDescription[]): Settings {
  const places = placesIn(parameters), gone = new Set(['local_radius', 'local_sites', 'broken', 'fragment', 'fragment_sites', 'fragment_seed']);  // for hits and fragments
  for (const { name, type, unit } of parameters) {
    const kind = places.get(name);
    if (type !== 'array' || (unit !== 'm' && kind !== 'plane')) continue;
    gone.add(name);
    if (kind === 'sphere') gone.add(radiusOf(name));
  }
  return Object.fromEntries(Object.entries(settings).filter(([name]) => !gone.has(name)));
}

/** Returns the initial position, before any dragging: a sphere in the upper half, a box at the bottom, or a plane at the ground. */
export function firstPlace(name: string, kind: PlaceKind, { low, high }: Bounds, known: ParameterValue | undefined): Settings {
  const size = Math.hypot(...low.map((value, k) => high[k]! - value)), round = rounding(size);
  const at = (share: Triple): Triple => low.map((value, k) => round(value + share[k]! * (high[k]! - value))) as Triple;
  switch (kind) {
    case 'sphere': return { [name]: at([0.5, 0.75, 0.5]), [radiusOf(name)]: round(0.22 * size) };
    case 'box': return { [name]: [at([-0.02, -0.02, -0.02]), at([1.02, 0.4, 1.02])] };
    case 'plane': return { [name]: [at([0.5, 0, 0.5]), [0, 1, 0]] };
    case 'direction': return { [name]: known ?? [0, 1, 0] };
    case 'normals': return { [name]: known ?? [[0, 1, 0]] };
  }
}

/** Returns the settings with their places moved by `by`. Places in parameters are measured from the file's origin, and the view shows
 * those below the answer's root node (Answer.offset). */
export function moved(settings: Settings, places: ReadonlyMap<string, PlaceKind>, by: readonly number[]): Settings {
  if (by.every(value => value === 0)) return settings;
  const point = (at: unknown) => (Array.isArray(at) ? at.map((value: number, k) => Number((value + by[k]!).toPrecision(15))) : at) as number[];
  const result: Record<string, ParameterValue> = { ...settings };
  for (const [name, kind] of places) {
    const value = settings[name];
    if (!Array.isArray(value)) continue;
    if (kind === 'sphere') result[name] = point(value);
    else if (kind === 'box') result[name] = value.map(point);
    else if (kind === 'plane') result[name] = [point(value[0]), value[1] as number[]];
  }
  return result;
}

/** Returns the settings without those of a region. */
export function withoutPlace(settings: Settings, name: string): Settings {
  return Object.fromEntries(Object.entries(settings).filter(([each]) => each !== name && each !== radiusOf(name)));
}

/** Returns a function that rounds to about a ten-thousandth of the mesh size. That is finer than a hand can move, and it keeps links
 * short. */
export function rounding(size: number): (value: number) => number {
  const digits = Math.max(0, Math.min(12, 4 - Math.floor(Math.log10(Math.max(1e-9, size)))));
  return value => Number(value.toFixed(digits)) + 0;
}
