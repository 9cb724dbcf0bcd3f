// Finds the fragment under the pointer: first by the fragments' spheres, then by their triangles, at their drawn positions.
import { Quaternion, Ray, Vector3 } from 'three';
import type { Batch, DrawnPiece } from './batch';

export interface Picked {
  /** The piece's index in its batch. */
  piece: number;
  id: number | undefined;
  /** The point in the drawn scene. */
  world: Vector3;
  /** The point in the answer's frame, before anything moved. */
  point: [number, number, number];
  normal: Vector3;
  interior: boolean;
}

/** The position of a piece. */
export interface Placed {
  at: readonly [number, number, number];
  turn: Quaternion;
}

/** `place` returns the position of a piece. By default, this is the position at which the piece is drawn. */
export function pick(batch: Batch, ray: Ray, sees: { exterior: boolean; interior: boolean }, place?: (piece: DrawnPiece) => Placed): Picked | undefined {
  const local = new Ray(), at = new Vector3(), turn = new Quaternion(), back = new Quaternion();
  const [a, b, c, found] = [new Vector3(), new Vector3(), new Vector3(), new Vector3()];
  let nearest = Infinity, picked: Picked | undefined;
  batch.pieces.forEach((piece, k) => {
    if (!batch.poses.visible(k)) return;
    const pose = batch.poses.get(k), own = place?.(piece);
    at.set(...(own?.at ?? pose.at));
    if (own) turn.copy(own.turn);
    else turn.set(...pose.turn);
    back.copy(turn).invert();
    local.origin.copy(ray.origin).sub(at).applyQuaternion(back);
    local.direction.copy(ray.direction).applyQuaternion(back);
    if (!local.intersectsSphere(piece.bounds)) return;
    for (const { start, count, interior } of piece.ranges) {
      if (!(interior ? sees.interior : sees.exterior)) continue;
      for (let t = start; t < start + count; t += 3) {
        a.fromArray(batch.positions, 3 * batch.index[t]!);
        b.fromArray(batch.positions, 3 * batch.index[t + 1]!);
        c.fromArray(batch.positions, 3 * batch.index[t + 2]!);
        if (!local.intersectTriangle(a, b, c, sees.exterior, found)) continue;
        const distance = found.distanceToSquared(local.origin);
        if (distance >= nearest) continue;
        nearest = distance;
        const normal = b.clone().sub(a).cross(c.clone().sub(a)).normalize().applyQuaternion(turn);
        picked = {
          piece: k, id: piece.id, world: found.clone().applyQuaternion(turn).add(at), normal, interior,
          point: [found.x + piece.origin[0], found.y + piece.origin[1], found.z + piece.origin[2]],
        };
      }
    }
  });
  return picked;
}
