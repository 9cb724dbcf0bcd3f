// Handles that drag points, regions and directions. A handle is pure geometry: it converts a pointer ray to settings.
import type { ParameterValue } from 'fracture-client';
import { Box3, CanvasTexture, type Color, Group, Plane, type Ray, Sphere, Sprite, SpriteMaterial, Vector3 } from 'three';
import { type PlaceKind, radiusOf, rounding } from '../state/places';
import type { Settings } from '../state/request';

export interface Handle {
  /** Stays the same while the handle is dragged. */
  key: string;
  at: Vector3;
  /** Converts a pointer ray to the settings after the drag. `facing`: the direction in which the camera looks. */
  drag(ray: Ray, facing: Vector3): Settings;
}

/** The mesh's centre, and the length of its diagonal. */
export interface Extent {
  middle: Vector3;
  size: number;
}

/** The distance of a direction's tip from the centre, as a fraction of the mesh size. */
export const TIP = 0.55;

export function handlesOf(settings: Settings, places: ReadonlyMap<string, PlaceKind>, extent: Extent): Handle[] {
  return [...places].flatMap(([name, kind]) => (settings[name] === undefined ? [] : MAKERS[kind](name, settings, extent)));
}

type Maker = (name: string, settings: Settings, extent: Extent) => Handle[];

const MAKERS: Record<PlaceKind, Maker> = {
  sphere(name, settings, { size }) {
    const center = vectorOf(settings[name]), radius = settings[radiusOf(name)], round = rounding(size);
    if (!center || typeof radius !== 'number') return [];
    return [
      { key: `${name} middle`, at: center, drag: (ray, facing) => ({ [name]: rounded(across(ray, center, facing), round) }) },
      {
        key: `${name} radius`, at: center.clone().add(new Vector3(radius, 0, 0)),
        drag: (ray, facing) => ({ [radiusOf(name)]: Math.max(round(size * 0.01), round(across(ray, center, facing).distanceTo(center))) }),
      },
    ];
  },

  box(name, settings, { size }) {
    const [low, high] = rows(settings[name]), round = rounding(size);
    if (!low || !high) return [];
    const middle = new Box3(low, high).getCenter(new Vector3()), handles: Handle[] = [{
      key: `${name} middle`, at: middle,
      drag: (ray, facing) => {
        const by = across(ray, middle, facing).sub(middle);
        return { [name]: [rounded(low.clone().add(by), round), rounded(high.clone().add(by), round)] };
      },
    }];
    for (const axis of [0, 1, 2])
      for (const end of [0, 1]) {
        const at = middle.clone().setComponent(axis, [low, high][end]!.getComponent(axis)), along = new Vector3().setComponent(axis, 1);
        handles.push({
          key: `${name} ${axis}${end}`, at,
          drag: ray => {
            const value = at.getComponent(axis) + amountAlong(ray, at, along), corners = [low.clone(), high.clone()] as const, thin = size * 0.005;
            // A face stops before it reaches the opposite one.
            corners[end]!.setComponent(axis, end === 0 ? Math.min(value, high.getComponent(axis) - thin) : Math.max(value, low.getComponent(axis) + thin));
            return { [name]: corners.map(corner => rounded(corner, round)) };
          },
        });
      }
    return handles;
  },

  plane(name, settings, extent) {
    const [point, normal] = rows(settings[name]), { size } = extent, round = rounding(size);
    if (!point || !normal || normal.lengthSq() === 0) return [];
    const unit = normal.clone().normalize(), at = footOf(point, unit, extent.middle);
    return [
      {
        key: `${name} middle`, at,
        drag: ray => ({ [name]: [rounded(at.clone().addScaledVector(unit, amountAlong(ray, at, unit)), round), normal.toArray()] }),
      },
      {
        key: `${name} normal`, at: at.clone().addScaledVector(unit, 0.3 * size),
        drag: ray => ({ [name]: [rounded(at, round), turned(ray, at, unit, 0.3 * size)] }),
      },
    ];
  },

  direction(name, settings, { middle, size }) {
    const along = vectorOf(settings[name]);
    if (!along || along.lengthSq() === 0) return [];
    const unit = along.normalize();
    return [{ key: name, at: middle.clone().addScaledVector(unit, TIP * size), drag: ray => ({ [name]: turned(ray, middle, unit, TIP * size) }) }];
  },

  normals(name, settings, { middle, size }) {
    const list = rows(settings[name]);
    return list.flatMap((normal, k) => {
      if (!normal || normal.lengthSq() === 0) return [];
      const unit = normal.clone().normalize();
      return [{
        key: `${name} ${k}`, at: middle.clone().addScaledVector(unit, TIP * size),
        drag: (ray: Ray) => ({ [name]: list.map((other, j) => (j === k ? turned(ray, middle, unit, TIP * size) : other!.toArray())) }),
      }];
    });
  },
};

/** Returns the point of a plane that is nearest to the mesh's centre. The handle is drawn there, because a plane has no centre of
 * its own. */
export const footOf = (point: Vector3, unit: Vector3, middle: Vector3): Vector3 =>
  middle.clone().addScaledVector(unit, -unit.dot(middle.clone().sub(point)));

/** Returns the point where the ray meets the plane through `at` that faces the camera; `at` if they do not meet. */
function across(ray: Ray, at: Vector3, facing: Vector3): Vector3 {
  return ray.intersectPlane(new Plane().setFromNormalAndCoplanarPoint(facing, at), new Vector3()) ?? at.clone();
}

/** Returns where the line through `at` along a unit vector is nearest to the ray, as a distance from `at`; 0 if they are parallel. */
function amountAlong({ origin, direction }: Ray, at: Vector3, along: Vector3): number {
  const between = at.clone().sub(origin), b = along.dot(direction), determinant = 1 - b * b;
  return determinant < 1e-6 ? 0 : (b * direction.dot(between) - along.dot(between)) / determinant;
}

/** Returns the direction from `center` to the point where the ray meets the sphere, on the same side as the tip. If the ray misses,
 * it is the direction to the sphere's rim. */
function turned(ray: Ray, center: Vector3, unit: Vector3, radius: number): number[] {
  const near = ray.closestPointToPoint(center, new Vector3()), beside = near.distanceTo(center), found = near.clone();
  if (new Sphere(center, radius).containsPoint(near)) {
    const half = Math.sqrt(radius * radius - beside * beside), away = unit.dot(ray.direction) > 0 ? half : -half;
    found.addScaledVector(ray.direction, away);
  }
  const next = found.sub(center);
  return next.lengthSq() === 0 ? unit.toArray() : rounded(next.normalize(), value => Number(value.toFixed(3)) + 0);
}

const rounded = (at: Vector3, round: (value: number) => number): number[] => at.toArray().map(round);

export function vectorOf(value: unknown): Vector3 | undefined {
  if (!Array.isArray(value) || value.length !== 3 || !value.every(Number.isFinite)) return undefined;
  return new Vector3(...value as [number, number, number]);
}
export const rows = (value: ParameterValue | undefined): (Vector3 | undefined)[] => (Array.isArray(value) ? value.map(vectorOf) : []);

let dot: CanvasTexture | undefined;
/** Draws handles as dots of constant size on the screen, in front of everything. */
export function dotsOf(handles: readonly Handle[], color: Color): Group {
  if (!dot) {
    const canvas = document.createElement('canvas'), context = canvas.getContext('2d')!;
    canvas.width = canvas.height = 64;
    context.arc(32, 32, 24, 0, 2 * Math.PI);
    context.fillStyle = '#fff';
    context.fill();
    context.lineWidth = 7;
    context.strokeStyle = '#1a1d21';
    context.stroke();
    dot = new CanvasTexture(canvas);
  }
  const group = new Group();
  for (const { at } of handles) {
    const sprite = new Sprite(new SpriteMaterial({ map: dot, color, depthTest: false, sizeAttenuation: false }));
    sprite.position.copy(at);
    sprite.scale.setScalar(0.026);
    sprite.renderOrder = 21;
    group.add(sprite);
  }
  return group;
}
