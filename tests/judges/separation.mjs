// Tests whether convex hulls overlap, by the separating axis theorem in double and without a physics engine.
import { collide } from './files.mjs';

const sub = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const cross = (u, v) => [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
const AXES = [0, 1, 2];

/** A hull in the world's frame: corners, normals of faces, edges, box. */
function placed(body, { points, triangles }) {
  const corners = [], normals = [], edges = [];
  for (let i = 0; i < points.length; i += 3) corners.push(AXES.map(k => points[i + k] + body.translation[k]));
  for (let t = 0; t < triangles.length; t += 3) {
    const [a, b, c] = AXES.map(k => corners[triangles[t + k]]), u = sub(b, a), v = sub(c, a);
    normals.push(cross(u, v));
    edges.push(u, sub(c, b));
  }
  return { body, corners, normals, edges, low: AXES.map(k => Math.min(...corners.map(p => p[k]))), high: AXES.map(k => Math.max(...corners.map(p => p[k]))) };
}

/** The gap along a direction. It is negative if the projections overlap. */
function gapAlong(n, a, b) {
  const length = Math.hypot(...n);
  if (!(length > 1e-30)) return -Infinity;
  const range = ({ corners }) => {
    let low = Infinity, high = -Infinity;
    for (const p of corners) {
      const h = (n[0] * p[0] + n[1] * p[1] + n[2] * p[2]) / length;
      if (h < low) low = h;
      if (h > high) high = h;
    }
    return [low, high];
  };
  const [la, ha] = range(a), [lb, hb] = range(b);
  return Math.max(lb - ha, la - hb);
}

/** The largest gap along a face's normal. If there is none, the largest gap along the products of edges. */
function gapBetween(a, b) {
  let best = -Infinity;
  for (const n of [...a.normals, ...b.normals]) best = Math.max(best, gapAlong(n, a, b));
  for (let i = 0; best <= 0 && i < a.edges.length; ++i)
    for (let j = 0; best <= 0 && j < b.edges.length; ++j) best = Math.max(best, gapAlong(cross(a.edges[i], b.edges[j]), a, b));
  return best;
}

/**
 * The smallest gap over all pairs of hulls that may collide. Pairs whose boxes are farther apart than the smallest gap so far are skipped.
 */
export function leastGap(bodies) {
  const hulls = bodies.flatMap(body => body.hulls.map(hull => placed(body, hull)));
  let gap = Infinity, between = '', pairs = 0;
  hulls.forEach((a, i) => {
    for (const b of hulls.slice(0, i)) {
      if (a.body === b.body || !collide(a.body, b.body)) continue;
      if (AXES.some(k => Math.max(a.low[k], b.low[k]) - Math.min(a.high[k], b.high[k]) > Math.min(gap, 1e30))) continue;
      ++pairs;
      const g = gapBetween(a, b);
      if (g < gap) [gap, between] = [g, `${a.body.name} and ${b.body.name}`];
    }
  });
  return { gap, between, pairs };
}

/** m: overlaps that are allowed. */
export function toleranceOf(bodies) {
  const hulls = bodies.flatMap(body => body.hulls.map(hull => placed(body, hull)));
  return 2e-4 * Math.max(0, ...AXES.map(k => Math.max(...hulls.map(h => h.high[k])) - Math.min(...hulls.map(h => h.low[k]))));
}

/** The pairs of bodies that the filters exclude although no two of their hulls overlap by more than the tolerance. */
export function needlessFilters(bodies, tolerance) {
  const hulls = new Map(bodies.filter(body => body.filter).map(body => [body, body.hulls.map(hull => placed(body, hull))]));
  const overlap = (a, b) => AXES.every(k => a.low[k] < b.high[k] && b.low[k] < a.high[k]) && gapBetween(a, b) < -0.9 * tolerance;
  const listed = [...hulls.keys()], needless = [];
  listed.forEach((a, i) => {
    for (const b of listed.slice(0, i))
      if (!collide(a, b) && !hulls.get(a).some(x => hulls.get(b).some(y => overlap(x, y)))) needless.push(`${a.name} and ${b.name}`);
  });
  return needless;
}
