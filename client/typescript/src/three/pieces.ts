// Fragments in a world of Rapier, drawn by three.js. What bonds hold together is one compound body; where they break it is
// replaced by several that move as it did: each gets v + ω × r, and then all of them the one rigid motion that makes
// linear and angular momentum exactly what they were, whatever the masses.
import { Group, type Material, type Mesh, type Object3D } from 'three';
import type { Answer } from '../answer.js';
import { localError } from '../problems.js';
import { type Blow, brokenBy, components, energyOf } from './bonds.js';
import { add, combine, cross, massOf, momentumOf, principalAxes, rotate, setMomentum, sub } from './mass.js';
import type { MassProperties, Momentum, MovingBody, Quat, Vec3 } from './mass.js';
import { meshesOf } from './meshes.js';
import { colliders, movingBody, quat, setMotion, vec, xyz, xyzw } from './rapier.js';
import type { ContactForce, Rapier, RapierBody, RapierCollider, RapierWorld } from './rapier.js';

export interface World {
  /** The module of Rapier. */
  rapier: Rapier;
  world: RapierWorld;
  /** Whose frame is the world's: mostly the scene. */
  parent: Object3D;
  /** materialsOf() the answer, or your own. */
  materials: readonly Material[];
}

export interface PieceOptions {
  /** Do bonds hold until something breaks them? Default: no, every fragment is a body. */
  bonded?: boolean;
  /** Metres that a bond gives way before it breaks (bonds.ts). */
  give?: number;
}

export interface Pose {
  position?: readonly [number, number, number];
  /** x, y, z, w */
  rotation?: readonly [number, number, number, number];
}

/** Old bodies out, new ones in. Momenta are about the same point. */
export interface SwapRecord {
  before: Momentum;
  after: Momentum;
  /** Something is anchored, or was fixed: momentum went into the ground. */
  held: boolean;
  bodies: number;
}

interface Body {
  rigid: RapierBody;
  members: number[];
  /** Of the body's frame, in the frame of the mesh. */
  origin: Vec3;
  /** It sleeps, and is drawn where it sleeps. */
  settled: boolean;
}

/** So many times its weight may press on a group as long as it likes. */
const QUIET = 4;

export class Pieces {
  /** Holds the meshes of the fragments; userData.pieces is this. */
  readonly object3D = new Group();
  readonly meshes: Mesh[];
  /** The swaps that made and changed it; the last one at the end. */
  readonly swaps: SwapRecord[] = [];
  private readonly bodies = new Set<Body>();
  private readonly bodyOfMember = new Map<number, Body>();
  private readonly memberOfCollider = new Map<number, number>();
  private readonly indexOf: Map<number, number>;
  /** Bonds that hold. */
  private readonly holding = new Set<number>();
  private cutsShown = true;
  private blows: { member: number; energy: number }[] = [];

  /** Use place() or swap(). @internal */
  constructor(readonly answer: Answer, private readonly setup: World, private readonly options: PieceOptions) {
    this.indexOf = new Map(answer.fragments.map(({ id }, k) => [id, k]));
    if (options.bonded) answer.bonds.forEach((_, k) => this.holding.add(k));
    this.meshes = meshesOf(answer, setup.materials);
    this.object3D.name = 'Fracture';
    this.object3D.userData['pieces'] = this;
    this.object3D.add(...this.meshes);
  }

  /** One for each fragment or group that holds together. */
  get rigidBodies(): RapierBody[] {
    return [...this.bodies].map(body => body.rigid);
  }
  /** The body that a fragment is in, by its id. */
  bodyOf(id: number): RapierBody | undefined {
    return this.bodyOfMember.get(this.indexOf.get(id) ?? -1)?.rigid;
  }
  /** Ids of the fragments in a body. */
  fragmentsIn(rigid: RapierBody): number[] {
    const body = [...this.bodies].find(({ rigid: { handle } }) => handle === rigid.handle);
    return (body?.members ?? []).map(member => this.answer.fragments[member]!.id);
  }
  get bondsLeft(): number {
    return this.holding.size;
  }
  /** Of all that moves, about the common centre of mass or another point. */
  momentum(about?: Vec3): Momentum {
    return momentumOf(this.rigidBodies.filter(rigid => rigid.isDynamic()).map(movingBody), about);
  }
  /** A point of the world in the frame of the mesh, as its fragment stood before it moved: what hits are given in. */
  pointOf(id: number, point: Vec3): Vec3 {
    const body = this.bodyOfMember.get(this.indexOf.get(id) ?? -1);
    if (!body) throw localError('bad-argument', `There is no fragment ${id} here.`, { parameter: 'id' });
    const [x, y, z, w] = quat(body.rigid.rotation());
    return add(body.origin, rotate([-x, -y, -z, w], sub(point, vec(body.rigid.translation()))));
  }

  /** Before each frame is drawn: meshes where their bodies are. */
  update(): void {
    for (const body of this.bodies) {
      const { rigid, members, origin, settled } = body;
      body.settled = rigid.isSleeping();
      if (settled && body.settled) continue;
      const at = vec(rigid.translation()), turn = quat(rigid.rotation());
      for (const member of members) {
        const mesh = this.meshes[member]!;
        mesh.position.set(...add(at, rotate(turn, sub(this.answer.fragments[member]!.translation, origin))));
        mesh.quaternion.set(...turn);
      }
    }
  }

  /** After each step: events.drainContactForceEvents(event => pieces.onContact(event)). Only groups can break. */
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
      // What lies or stands presses with each step; only what comes on top of some times its weight is a blow.
      const weight = Math.max(moves(a), moves(b)) * Math.hypot(world.gravity.x, world.gravity.y, world.gravity.z) * world.timestep;
      const rest = impulse - QUIET * weight;
      if (rest > 0) this.blows.push({ member, energy: energyOf(rest, moves(a), moves(b)) });
    }
  }

  /** After the contacts of a step: breaks bonds and parts what they held. Returns how many broke. */
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

  /** A blow from elsewhere: `point` in the frame of the mesh, `energy` in joules, on the group that a fragment is in (default:
   * the nearest one; if that is loose already, nothing breaks). Returns how many bonds broke. */
  strike(point: Vec3, energy: number, id?: number): number {
    const body = this.bodyOfMember.get(id === undefined ? this.nearest(point) : this.indexOf.get(id) ?? -1);
    if (!body || body.members.length < 2) return 0;
    const broken = this.broken({ point, energy }, body.members);
    for (const bond of broken) this.holding.delete(bond);
    const parts = components(body.members, this.holding, this.ends);
    if (parts.length > 1) this.replace(body.rigid, body.origin, parts, body);
    return broken.length;
  }

  /** Its bodies are gone already. @internal */
  release(): void {
    this.bodies.clear();
    this.remove();
  }

  /** Out of world and scene. Frees what the graphics card has of it; materials are yours. */
  remove(): void {
    for (const { rigid } of this.bodies) this.setup.world.removeRigidBody(rigid);
    this.bodies.clear();
    this.bodyOfMember.clear();
    this.memberOfCollider.clear();
    this.object3D.removeFromParent();
    for (const mesh of this.meshes) mesh.geometry.dispose();
  }

  /** @internal */
  start(pose: Required<Pose>, whole: boolean): void {
    const all = this.answer.fragments.map((_, k) => k);
    const parts = whole ? [all] : components(all, this.holding, this.ends);
    for (const members of parts) this.add(members, vec3(pose.position), quaternion(pose.rotation), undefined);
    this.enter();
  }

  /** In place of a body whose frame is at `origin` of the mesh's frame. @internal */
  startAs(rigid: RapierBody, origin: Vec3, blow: Blow | undefined): void {
    const all = this.answer.fragments.map((_, k) => k);
    if (blow) for (const bond of this.broken(blow, all)) this.holding.delete(bond);
    this.replace(rigid, origin, components(all, this.holding, this.ends), undefined);
    this.enter();
  }

  /** The only body, and where its frame is. @internal */
  only(): { rigid: RapierBody; origin: Vec3 } {
    const [body, ...others] = this.bodies;
    if (!body || others.length > 0)
      throw localError('bad-argument', `swap() replaces one body; these are ${this.bodies.size}.`, { parameter: 'object' });
    return body;
  }

  private enter(): void {
    this.showCuts(this.bodies.size > 1);
    this.setup.parent.add(this.object3D);
    this.update();
  }

  /** Of what is in one piece no cut is drawn: their edges would show where it will break. */
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
    // Twice: the second time for what the rounding to floats took.
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
        throw localError('bad-argument', 'The answer has no rigid bodies: ask with physics=khr.', { parameter: 'physics' });
      return massOf(motion, translation);
    });
    const whole = combine(parts), origin = fragments.length === 1 ? fragments[0]!.translation : whole.center;
    const { moments, axes } = principalAxes(whole.inertia), held = fragments.some(({ anchored }) => anchored);
    const at = add(frame, rotate(turn, origin));
    const description = (held ? rapier.RigidBodyDesc.fixed() : rapier.RigidBodyDesc.dynamic())
      .setTranslation(...at).setRotation(xyzw(turn))
      .setAdditionalMassProperties(whole.mass, xyz(sub(whole.center, origin)), xyz(moments), xyzw(axes));
    const rigid: RapierBody = world.createRigidBody(description);
    // A group can break: contacts below some times its weight are not even reported.
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
