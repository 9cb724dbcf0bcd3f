// The fragments as bodies: mass, inertia, hulls and friction come from the file (KHR_physics_rigid_bodies), bonds hold until a
// blow breaks them (see fracture-client/three), and the engine is Rapier, which is loaded with this file.
import RAPIER from '@dimforge/rapier3d-compat';
import type { Answer } from 'fracture-client';
import { type Pieces, place } from 'fracture-client/three';
import { Group, Mesh, MeshStandardMaterial, Plane, SphereGeometry, Vector3 } from 'three';
import type { App } from '../app/app';
import { disposeOf } from '../scene/overlays';
import { pick } from '../scene/picking';
import { words } from '../words/words';

/** The build that this file belongs to. app.js may belong to another one. */
declare const BUILD: string;
export const build: string = BUILD;

const STEP = 1 / 60, SLOW = 0.15;
const MOST_STEPS = 6;      // per frame; slower machines play in slow motion
const DROP = 0.12;         // start height above the ground, as a fraction of the size
const BALL_DENSITY = 7200; // kg/m³: cast iron
const QUIET_FRAMES = 20;   // frames without an awake body, after which everything is at rest

const RETREAT = 1.5;
const CALM_AFTER = 4;     // seconds
const TREMBLE = 0.06;     // m/s, for an object one metre in size

/** Ensures that the engine is loaded only once. Two loads in progress would each create an engine, and the second would replace the
 * one in use. */
let loaded: Promise<void> | undefined;

/** Loads the engine and starts to play. `wanted` returns the answer to play once the engine is ready, if there is one. `made` is
 * called before the first frame. */
export async function startPlay(app: App, wanted: () => Answer | undefined, made: (physics: Physics) => void): Promise<void> {
  await (loaded ??= RAPIER.init().catch((error: unknown) => {
    loaded = undefined;
    throw error;
  }));
  const answer = wanted();
  if (!answer) return;
  if (!answer.fragments.some(({ motion, hulls }) => motion?.inertiaDiagonal && hulls.length > 0)) throw new Error(words.play.noBodies);
  const physics = new Physics(app, answer);
  made(physics);
  physics.reset();
}

export class Physics {
  private world!: RAPIER.World;
  private pieces!: Pieces;
  private readonly events = new RAPIER.EventQueue(true);
  private readonly balls: { body: RAPIER.RigidBody; mesh: Mesh }[] = [];
  private readonly ballGroup = new Group();
  private held: { body: RAPIER.RigidBody; local: Vector3; plane: Plane; target: Vector3; moved: boolean } | undefined;
  private slow = false;
  private running = true;
  private behind = 0;
  private quiet = 0;
  /** Simulated seconds. */
  private untouched = 0;
  private shown = '';

  constructor(private readonly app: App, private readonly answer: Answer) {
    app.view!.hold();
    app.stage!.add(this.ballGroup);
    app.stage!.retreat(RETREAT);
  }

  /** Resets everything to the start: above the ground, in one piece. */
  reset(): void {
    const { view, stage } = this.app, size = view!.size, ground = stage!.groundHeight;
    this.clear();
    this.world = new RAPIER.World({ x: 0, y: -9.81, z: 0 });
    // The engine uses this length to decide which bodies touch and which are slow.
    this.world.lengthUnit = Math.max(1e-3, size / 2);
    this.world.createCollider(RAPIER.ColliderDesc.cuboid(100 * size, size, 100 * size).setTranslation(0, ground - size, 0).setFriction(0.7));
    const setup = { rapier: RAPIER, world: this.world, parent: new Group(), materials: [] };
    this.pieces = place(this.answer, setup, { bonded: true, position: [0, DROP * size, 0] });
    this.behind = this.quiet = this.untouched = 0;
    this.running = true;
    this.draw();
    stage!.animate(seconds => this.safely(seconds));
  }

  private clear(): void {
    this.held = undefined;
    for (const { mesh } of this.balls.splice(0)) disposeOf(mesh);
    (this.pieces as Pieces | undefined)?.remove();
    (this.world as RAPIER.World | undefined)?.free();
  }

  stop(): void {
    this.app.stage!.animate(undefined);
    try {
      this.clear();
      this.events.free();
    } catch (error) {
      // An engine that failed in a step cannot be released, either.
      console.warn(error);
    }
    this.ballGroup.removeFromParent();
    this.app.stage!.retreat(1 / RETREAT);
  }

  /** Runs a frame. If a step fails, shows the error and stops playing. */
  private safely(seconds: number): boolean {
    try {
      return this.frame(seconds);
    } catch (error) {
      this.app.playing.failed(error);
      return false;
    }
  }

  /** Advances the physics. Returns true while something moves. */
  private frame(seconds: number): boolean {
    if (!this.running || this.quiet >= QUIET_FRAMES) return false;
    this.behind = Math.min(MOST_STEPS * STEP, this.behind + seconds);
    this.world.timestep = this.slow ? STEP * SLOW : STEP;
    for (; this.behind >= STEP; this.behind -= STEP) {
      this.pull();
      this.untouched += this.world.timestep;
      this.world.step(this.events);
      this.events.drainContactForceEvents(contact => this.pieces.onContact(contact));
      this.pieces.breakBonds();
    }
    this.damp();
    this.draw();
    const awake = this.held !== undefined || [...this.pieces.rigidBodies as RAPIER.RigidBody[], ...this.balls.map(({ body }) => body)].some(body => this.moves(body));
    this.quiet = awake ? 0 : this.quiet + 1;
    return this.quiet < QUIET_FRAMES;
  }

  /** Returns whether a body moves visibly. Chips that wedge each other may tremble forever, too little to be seen; they count as
   * resting. */
  private moves(body: RAPIER.RigidBody): boolean {
    if (!body.isDynamic() || body.isSleeping()) return false;
    const { x, y, z } = body.linvel(), { x: u, y: v, z: w } = body.angvel();
    return this.untouched < 2 * CALM_AFTER || Math.hypot(x, y, z) > TREMBLE * Math.sqrt(this.app.view!.size) || Math.hypot(u, v, w) > 20 * TREMBLE;
  }

  /** Damps all bodies a little, so that round pieces stop rolling on a level floor. After some seconds without input it damps them
   * strongly, so that chips stop trembling. */
  private damp(): void {
    const calm = this.untouched > CALM_AFTER, [linear, angular] = calm ? [3, 10] : [0.1, 1.2];
    for (const body of [...this.pieces.rigidBodies as RAPIER.RigidBody[], ...this.balls.map(({ body }) => body)])
      if (Math.abs(body.angularDamping() - angular) > 0.01) {
        body.setAngularDamping(angular);
        body.setLinearDamping(linear);
      }
  }

  private draw(): void {
    const { view } = this.app, poses = view!.batch!.poses;
    this.pieces.update();
    this.pieces.meshes.forEach(({ position, quaternion }, k) => {
      poses.place(k, position.x, position.y, position.z);
      poses.turn(k, quaternion.x, quaternion.y, quaternion.z, quaternion.w);
    });
    for (const { body, mesh } of this.balls) {
      mesh.position.copy(body.translation());
      mesh.quaternion.copy(body.rotation());
    }
    view!.moved();
    this.tell();
  }

  private tell(): void {
    const resting = this.quiet >= QUIET_FRAMES - 1, bodies = this.pieces.rigidBodies.length, said = `${resting} ${bodies} ${this.slow} ${this.running}`;
    if (said === this.shown) return;
    this.shown = said;
    this.app.set({ play: { loading: false, running: this.running, slow: this.slow, bodies, resting } });
  }

  private wake(): void {
    this.quiet = this.untouched = 0;
    this.running = true;
    this.app.stage!.animate(seconds => this.safely(seconds));
  }

  setSlow(slow: boolean): void {
    this.slow = slow;
    this.tell();
    if (this.running) this.wake();
  }
  pause(): void {
    this.running = !this.running;
    this.tell();
    if (this.running) this.wake();
  }

  /** Throws a ball from the camera towards the point under the pointer. */
  throwAt(x: number, y: number): void {
    const { stage, view } = this.app, { origin, direction } = stage!.ray(x, y), size = view!.size, radius = 0.07 * size;
    const from = stage!.controls.target.distanceTo(origin), start = origin.clone().addScaledVector(direction, Math.max(0, from - 2.5 * size));
    const speed = 11 * Math.sqrt(size), velocity = direction.clone().multiplyScalar(speed);
    // Aims higher, by the distance that the ball falls on the way.
    velocity.y += 9.81 * Math.min(2.5 * size, from) / speed / 2;
    const body = this.world.createRigidBody(RAPIER.RigidBodyDesc.dynamic().setTranslation(start.x, start.y, start.z)
      .setLinvel(velocity.x, velocity.y, velocity.z).setCcdEnabled(true));
    this.world.createCollider(RAPIER.ColliderDesc.ball(radius).setDensity(BALL_DENSITY).setRestitution(0.3).setFriction(0.5), body);
    const mesh = new Mesh(new SphereGeometry(radius, 24, 16), new MeshStandardMaterial({ color: 0x30343a, roughness: 0.35, metalness: 0.4 }));
    mesh.castShadow = true;
    this.ballGroup.add(mesh);
    this.balls.push({ body, mesh });
    this.wake();
  }
  throwMiddle(): void {
    const { left, top, width, height } = this.app.stage!.renderer.domElement.getBoundingClientRect();
    this.throwAt(left + width / 2, top + height * 0.52);
  }

  /** Grabs the piece under the pointer. Returns false if there is none. */
  grab(x: number, y: number): boolean {
    const { view, stage } = this.app, ray = stage!.ray(x, y), picked = view!.batch && pick(view!.batch, ray, { exterior: true, interior: true });
    const body = picked?.id === undefined ? undefined : this.pieces.bodyOf(picked.id) as RAPIER.RigidBody | undefined;
    if (!picked || !body?.isDynamic()) return false;
    const { x: bx, y: by, z: bz } = body.translation(), local = picked.world.clone().sub(new Vector3(bx, by, bz));
    local.applyQuaternion(stage!.camera.quaternion.clone().copy(body.rotation()).invert());
    this.held = { body, local, plane: new Plane().setFromNormalAndCoplanarPoint(ray.direction.clone().negate(), picked.world), target: picked.world.clone(), moved: false };
    return true;
  }
  drag(x: number, y: number): void {
    if (!this.held) return;
    this.app.stage!.ray(x, y).intersectPlane(this.held.plane, this.held.target);
    this.held.moved = true;
    this.wake();
  }
  /** Releases the dragged piece. Returns true if something was dragged. */
  release(): boolean {
    const dragged = this.held?.moved ?? false;
    this.held = undefined;
    return dragged;
  }

  /** Makes the dragged piece follow the pointer like a heavy object on a short rope. */
  private pull(): void {
    if (!this.held?.moved) return;
    const { body, local, target } = this.held;
    if (!body.isValid()) {
      this.held = undefined;  // it broke
      return;
    }
    const { x, y, z } = body.translation(), turn = this.app.stage!.camera.quaternion.clone().copy(body.rotation());
    const at = local.clone().applyQuaternion(turn).add(new Vector3(x, y, z)), wanted = target.clone().sub(at).multiplyScalar(12);
    const most = 12 * Math.sqrt(this.app.view!.size);
    if (wanted.length() > most) wanted.setLength(most);
    body.setLinvel(wanted, true);
    const { x: ax, y: ay, z: az } = body.angvel();
    body.setAngvel({ x: 0.9 * ax, y: 0.9 * ay, z: 0.9 * az }, true);
  }
}
