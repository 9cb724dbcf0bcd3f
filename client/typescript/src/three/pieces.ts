// Fragments in a Rapier world, drawn by three.js. Fragments that are held together by bonds form one compound body. If bonds break,
// several bodies replace it. Each body gets the velocity v + ω × r, and then all get a common rigid motion, so that linear and
// angular momentum stay exactly the same even if the masses differ.
import { Group, type Material, type Mesh, type Object3D } from 'three';
import type { Answer } from '../answer.js';
import { localError } from '../problems.js';
import { type Blow, brokenBy, components, energyOf } from './bonds.js';
import { add, combine, cross, massOf, momentumOf, principalAxes, rotate, setMomentum, sub } from './mass.js';
import type { MassProperties, Momentum, MovingBody, Quat, Vec3 } from './mass.js';
import { meshesOf } from './meshes.js';
import { product } from '../turn.js';
import { colliders, movingBody, quat, setMotion, vec, xyz, xyzw } from './rapier.js';
import type { ContactForce, Rapier, RapierBody, RapierCollider, RapierWorld } from './rapier.js';

export interface World {
  /** The Rapier module. */
  rapier: Rapier;
  world: RapierWorld;
  /** The object whose frame is the world's frame, usually the scene. */
  parent: Object3D;
  /** The materials of the answer (materialsOf()), or your own. */
  materials: readonly Material[];
}

export interface PieceOptions {
  /** Whether bonds hold fragments together until a blow breaks them. Default: false, so every fragment is a body. */
  bonded?: boolean;
  /** Metres by which a bond stretches before it breaks (bonds.ts). Default: GIVE. */
  give?: number;
}

export interface Pose {
  position?: readonly [number, number, number];
  /** x, y, z, w */
  rotation?: readonly [number, number, number, number];
}

/** The replacement of a body by other bodies. Both momenta are about the same point. */
export interface SwapRecord {
  before: Momentum;
  after: Momentum;
  /** True if the old body was fixed or a new one is anchored. The ground then absorbed momentum. */
  held: boolean;
  /** Number of new bodies. */
  bodies: number;
}

interface Body {
  rigid: RapierBody;
  members: number[];
  /** Origin of the body's frame, in the frame of the mesh. */
  origin: Vec3;
  /** True if the body sleeps and its meshes are already in position. */
  settled: boolean;
}

/** A contact force counts as a blow only if it exceeds this multiple of a group's weight. */
const QUIET = 4;

export class Pieces {
  /** The parent of the fragments' meshes; its userData.pieces is this object. */
  readonly object3D = new Group();
  readonly meshes: Mesh[];
  /** All replacements of bodies so far, newest last. */
  readonly swaps: SwapRecord[] = [];
  private readonly bodies = new Set<Body>();
  private readonly bodyOfMember = new Map<number, Body>();
  private readonly memberOfCollider = new Map<number, number>();
  private readonly indexOf: Map<number, number>;
  /** Indices of the unbroken bonds. */
  private readonly holding = new Set<number>();
  private cutsShown = true;
  private blows: { member: number; energy: number }[] = [];

  /** Called by place() and swap(), which are the public functions. @internal */
  constructor(readonly answer: Answer, private readonly setup: World, private readonly options: PieceOptions) {
    this.indexOf = new Map(answer.fragments.map(({ id }, k) => [id, k]));
    if (options.bonded) answer.bonds.forEach((_, k) => this.holding.add(k));
    this.meshes = meshesOf(answer, setup.materials);
    this.object3D.name = 'Fracture';
    this.object3D.userData['pieces'] = this;
    this.object3D.add(...this.meshes);
  }

  /** One body for each loose fragment and each connected group. */
  get rigidBodies(): RapierBody[] {
    return [...this.bodies].map(body => body.rigid);
  }
  /** Returns the body that contains the fragment with this id. */
  bodyOf(id: number): RapierBody | undefined {
    return this.bodyOfMember.get(this.indexOf.get(id) ?? -1)?.rigid;
  }
  /** Returns the ids of the fragments in a body. */
  fragmentsIn(rigid: RapierBody): number[] {
    const body = [...this.bodies].find(({ rigid: { handle } }) => handle === rigid.handle);
    return (body?.members ?? []).map(member => this.answer.fragments[member]!.id);
  }
  /** Number of unbroken bonds. */
  get bondsLeft(): number {
    return this.holding.size;
  }
  /** Returns the momentum of all moving bodies, about their common centre of mass or another point. */
  momentum(about?: Vec3): Momentum {
    return momentumOf(this.rigidBodies.filter(rigid => rigid.isDynamic()).map(movingBody), about);
  }
  /** Converts a point on a fragment from world space to the point's original place in the mesh's frame, which Answer.hit() needs. Throws
   * FractureError (bad-argument) for an unknown id. */
  pointOf(id: number, point: Vec3): Vec3 {
    const body = this.bodyOfMember.get(this.indexOf.get(id) ?? -1);
    if (!body) throw localError('bad-argument', `None of these pieces has the id ${id}.`, { parameter: 'id' });
    const [x, y, z, w] = quat(body.rigid.rotation());
    return add(body.origin, rotate([-x, -y, -z, w], sub(point, vec(body.rigid.translation()))));
  }

  /** Moves the meshes to their bodies. Call it before each frame. */
  update(): void {
    for (const body of this.bodies) {
      const { rigid, members, origin, settled } = body;
      body.settled = rigid.isSleeping();
      if (settled && body.settled) continue;
      const at = vec(rigid.translation()), turn = quat(rigid.rotation());
      for (const member of members) {
        const mesh = this.meshes[member]!, fragment = this.answer.fragments[member]!;
        mesh.position.set(...add(at, rotate(turn, sub(fragment.translation, origin))));
        mesh.quaternion.set(...(fragment.turn ? product(turn, fragment.turn.rotation) : turn));
      }
    }
  }

  /** Records a contact. Call it after each step: events.drainContactForceEvents(event => pieces.onContact(event)). Only groups of
   * fragments can break. */
  onContact(event: ContactForce): void {
    const { world } = this.setup, impulse = event.totalForceMagnitude() * world.timestep;
    const [a, b] = [event.collider1(), event.collider2()];
    const moves = (handle: number) => {
      const parent = (world.getCollider(handle) as RapierCollider | null)?.parent();
      return parent?.isDynamic() ? parent.mass() : 0;
    };
    for (const own of [a, b]) {
      const member = this.memberOfCollider.get(own);
      if (member === undefined || this.bodyOfMember.get(member)!.members.length < 2) continue;
      // A resting body presses on its contacts in each step, so only a force above a multiple of its weight is a blow.
      const weight = Math.max(moves(a), moves(b)) * Math.hypot(world.gravity.x, world.gravity.y, world.gravity.z) * world.timestep;
      const rest = impulse - QUIET * weight;
      if (rest > 0) this.blows.push({ member, energy: energyOf(rest, moves(a), moves(b)) });
    }
  }

  /** Breaks bonds according to the contacts of a step, and separates groups that no longer hold together. Call it after onContact().
   * Returns the number of broken bonds. */
  breakBonds(): number {
    const blows = this.blows;
    this.blows = [];
    let broken = 0;
    for (const { member, energy } of blows) {
      const { centerOfMass, id } = this.answer.fragments[member]!;
      broken += this.strike(centerOfMass, energy, id);
    }
    return broken;
  }

  /** Hits a fragment's group and breaks bonds. `point`: in the mesh's frame (m). `energy`: J. `id`: the fragment; default: the
   * nearest one. A loose fragment does not break. Returns the number of broken bonds. */
  strike(point: Vec3, energy: number, id?: number): number {
    const body = this.bodyOfMember.get(id === undefined ? this.nearest(point) : this.indexOf.get(id) ?? -1);
    if (!body || body.members.length < 2) return 0;
    const broken = this.broken({ point, energy }, body.members);
    for (const bond of broken) this.holding.delete(bond);
    const parts = components(body.members, this.holding, this.ends);
    if (parts.length > 1) this.replace(body.rigid, body.origin, parts, body);
    return broken.length;
  }

  /** Like remove(), for bodies that were already removed from the world. @internal */
  release(): void {
    this.bodies.clear();
    this.remove();
  }

  /** Removes bodies and meshes from world and scene, and frees their buffers on the graphics card. Does not dispose of materials. */
  remove(): void {
    for (const { rigid } of this.bodies) this.setup.world.removeRigidBody(rigid);
    this.bodies.clear();
    this.bodyOfMember.clear();
    this.memberOfCollider.clear();
    this.object3D.removeFromParent();
    for (const mesh of this.meshes) mesh.traverse(part => (part as Mesh).geometry.dispose());  // with the sheets that it carries
  }

  /** @internal */
  start(pose: Required<Pose>, whole: boolean): void {
    const all = this.answer.fragments.map((_, k) => k);
    const parts = whole ? [all] : components(all, this.holding, this.ends);
    for (const members of parts) this.add(members, vec3(pose.position), quaternion(pose.rotation), undefined);
    this.enter();
  }

  /** Replaces a body whose frame is at `origin` in the mesh's frame. @internal */
  startAs(rigid: RapierBody, origin: Vec3, blow: Blow | undefined): void {
    const all = this.answer.fragments.map((_, k) => k);
    if (blow) for (const bond of this.broken(blow, all)) this.holding.delete(bond);
    this.replace(rigid, origin, components(all, this.holding, this.ends), undefined);
    this.enter();
  }

  /** Returns the only body and the origin of its frame. Throws FractureError (bad-argument) if there are several. @internal */
  only(): { rigid: RapierBody; origin: Vec3 } {
    const [body, ...others] = this.bodies;
    if (!body || others.length > 0)
      throw localError('bad-argument', `swap() replaces one body, but these pieces have ${this.bodies.size} bodies. Place the answer with ` +
        '`whole: true` to get one body.', { parameter: 'object' });
    return body;
  }

  private enter(): void {
    this.showCuts(this.bodies.size > 1);
    this.setup.parent.add(this.object3D);
    this.update();
  }

  /** Shows or hides the cut faces. They are hidden in an unbroken body, because their edges would show where it will break. */
  private showCuts(shown: boolean): void {
    if (shown === this.cutsShown) return;
    this.cutsShown = shown;
    this.meshes.forEach(({ geometry }, k) => geometry.groups.forEach((group, part) => {
      const { interior, triangles } = this.answer.fragments[k]!.primitives[part]!;
      if (interior) group.count = shown ? triangles.length : 0;
    }));
  }

  private readonly ends = (bond: number): readonly [number, number] => {
    const { a, b } = this.answer.bonds[bond]!;
    return [this.indexOf.get(a) ?? -1, this.indexOf.get(b) ?? -1];
  };

  private broken(blow: Blow, members: readonly number[]): number[] {
    const inside = new Set(members), candidates = [...this.holding].filter(bond => inside.has(this.ends(bond)[0]));
    return brokenBy(blow, this.answer.bonds, candidates, this.options.give);
  }

  private nearest(point: Vec3): number {
    const distance = (k: number) => Math.hypot(...sub(this.answer.fragments[k]!.centerOfMass, point));
    return this.answer.fragments.reduce((best, _, k) => (distance(k) < distance(best) ? k : best), 0);
  }

  private replace(old: RapierBody, origin: Vec3, parts: number[][], own: Body | undefined): void {
    const field = movingBody(old), turn = quat(old.rotation());
    const frame = sub(vec(old.translation()), rotate(turn, origin));  // where the frame of the mesh is now
    if (own) {
      this.bodies.delete(own);
      for (const [collider, member] of this.memberOfCollider) if (own.members.includes(member)) this.memberOfCollider.delete(collider);
    }
    const made = parts.map(members => this.add(members, frame, turn, field)), moving = made.filter(rigid => rigid.isDynamic());
    const held = !old.isDynamic() || moving.length < made.length;
    const before = momentumOf(old.isDynamic() ? [field] : []);
    // This runs twice, because the second round corrects errors from rounding to floats.
    for (let round = 0; round < 2 && !held; ++round) {
      const bodies = moving.map(movingBody);
      setMomentum(bodies, before);
      bodies.forEach((body, k) => setMotion(moving[k]!, body));
    }
    this.swaps.push({ before, after: momentumOf(moving.map(movingBody), before.center), held, bodies: made.length });
    this.setup.world.removeRigidBody(old);
    if (this.bodies.size > 1) this.showCuts(true);
  }

  private add(members: number[], frame: Vec3, turn: Quat, field: MovingBody | undefined): RapierBody {
    const { rapier, world } = this.setup, fragments = members.map(member => this.answer.fragments[member]!);
    const parts = fragments.map(({ motion, translation }): MassProperties => {
      if (!motion?.inertiaDiagonal)
        throw localError('bad-argument', 'The answer has no rigid bodies. Fracture the mesh with physics=khr.', { parameter: 'physics' });
      return massOf(motion, translation);
    });
    const whole = combine(parts), origin = fragments.length === 1 ? fragments[0]!.translation : whole.center;
    const { moments, axes } = principalAxes(whole.inertia), held = fragments.some(({ anchored }) => anchored);
    const at = add(frame, rotate(turn, origin));
    const description = (held ? rapier.RigidBodyDesc.fixed() : rapier.RigidBodyDesc.dynamic())
      .setTranslation(...at).setRotation(xyzw(turn))
      .setAdditionalMassProperties(whole.mass, xyz(sub(whole.center, origin)), xyz(moments), xyzw(axes));
    const rigid: RapierBody = world.createRigidBody(description);
    // Only a group can break. Contacts below a multiple of its weight are not reported.
    const { x, y, z } = world.gravity, threshold = members.length > 1 ? QUIET * whole.mass * Math.hypot(x, y, z) : undefined;
    members.forEach((member, k) => this.addColliders(member, sub(fragments[k]!.translation, origin), rigid, threshold));
    rigid.recomputeMassPropertiesFromColliders();
    if (field && !held) {
      const { velocity, spin, center } = field;
      setMotion(rigid, { velocity: add(velocity, cross(spin, sub(vec(rigid.worldCom()), center))), spin });
    }
    const body = { rigid, members, origin, settled: false };
    this.bodies.add(body);
    for (const member of members) this.bodyOfMember.set(member, body);
    return rigid;
  }

  private addColliders(member: number, offset: Vec3, rigid: RapierBody, threshold: number | undefined): void {
    const { rapier, world } = this.setup;
    for (const shape of colliders(rapier, this.answer.fragments[member]!, offset, threshold))
      this.memberOfCollider.set((world.createCollider(shape, rigid) as RapierCollider).handle, member);
  }
}

const vec3 = (value: readonly number[]): Vec3 => [value[0]!, value[1]!, value[2]!];
const quaternion = (value: readonly number[]): Quat => [value[0]!, value[1]!, value[2]!, value[3]!];
