// Finds the point of the mesh's surface under the pointer. In the exploded view there are cracks between the fragments, and a ray through a
// crack reaches nothing or the far side of the mesh. So the ray is also cast at the assembled surface, scaled about the centre as the
// fragments' centres are. This surface has no cracks.
import { Quaternion, Ray, Vector3 } from 'three';
import type { Batch } from './batch';
import { pick, type Picked } from './picking';

/** `explode`: as in the look; 0 is assembled. `middle`: the point from which fragments move away. */
export function pickOnSurface(batch: Batch, ray: Ray, sees: { exterior: boolean; interior: boolean }, explode: number, middle: Vector3): Picked | undefined {
  const drawn = pick(batch, ray, sees);
  if (!(explode > 0) || !sees.exterior) return drawn;
  const scale = 1 + explode, scaled = (point: Vector3) => point.clone().sub(middle).multiplyScalar(scale).add(middle);
  const back = new Ray(ray.origin.clone().sub(middle).divideScalar(scale).add(middle), ray.direction.clone());
  const whole = pick(batch, back, { exterior: true, interior: false }, piece => ({ at: piece.origin, turn: STILL }));
  if (!whole) return drawn;
  const world = scaled(new Vector3(...whole.point));
  if (drawn) {
    // A fragment is drawn somewhat before or behind its place on the scaled surface. A point that is farther behind was seen through a crack.
    const off = scaled(new Vector3(...drawn.point)).distanceTo(drawn.world), behind = ray.origin.distanceTo(drawn.world) - ray.origin.distanceTo(world);
    if (behind <= 2 * off) return drawn;
  }
  return { ...whole, world };
}
const STILL = new Quaternion();
