// The contents of the stage: the whole mesh or its fragments, and how they are exploded, coloured and marked.
import type { Answer } from 'fracture-client';
import { materialsOf } from 'fracture-client/three';
import { Color, DoubleSide, FrontSide, Group, type Material, Mesh, MeshBasicMaterial, type Sphere, Texture, Vector3 } from 'three';
import { pickOnSurface } from './assembled';
import { Batch } from './batch';
import { clustersAt, type ColourMode, coloursOf } from './colours';
import { dotsOf, type Handle, handlesOf } from './gizmos';
import { BondGraph, disposeOf, hitSphere, markers, person, RED, repairsOf, ring } from './overlays';
import type { Picked } from './picking';
import { plain } from './plain';
import { rawMesh } from './raw';
import { regionsOf } from './regions';
import { type Bounds, moved, type PlaceKind } from '../state/places';
import type { Settings } from '../state/request';
import type { Stage } from './stage';

export interface Look {
  /** 0: assembled; 1: every piece is twice as far from the centre. */
  explode: number;
  cutsOnly: boolean;
  colours: ColourMode;
  /** The level whose clusters move together and share a colour. A value equal to the number of levels means the fragments themselves. */
  level: number;
  bonds: boolean;
  wireframe: boolean;
  repairs: boolean;
  person: boolean;
  chosen: ReadonlySet<number>;
  /** The fragments that are not drawn. */
  hidden: ReadonlySet<number>;
}

/** The largest explode factor at which everything that the camera frames stays in the picture. */
export const USUAL = 0.18;

/** Time in ms within which the fragments of a new mesh usually arrive; until then the whole mesh is not drawn. */
const SOON = 400;

/** The maximum number of rings, and the fraction of the mesh's size above which a fragment is visible without a ring. */
const FEW = 12, SMALL = 0.06;

export class View {
  batch: Batch | undefined;
  private materials: { key: string; list: Promise<Material[]> } | undefined;
  /** Materials that stay in the picture until the next ones replace them. */
  private readonly retired: Promise<Material[]>[] = [];
  private turn = 0;
  private bonds: BondGraph | undefined;
  private wires: Mesh[] = [];
  private repairs: Group | undefined;
  private place: Group | undefined;
  private regions: Group | undefined;
  /** The points and regions that are set, and the handles that drag them. */
  private handles: Handle[] = [];
  private readonly figure = person();
  private readonly reach: Mesh;
  private readonly rings = new Group();
  private look: Look | undefined;
  private raw: ReturnType<typeof rawMesh> | undefined;
  private centers: Vector3[] = [];
  private middle = new Vector3();
  /** The point from which exploded fragments move away. */
  private readonly from = new Vector3();
  size = 1;
  private corners: Bounds = { low: [0, 0, 0], high: [1, 1, 1] };
  /** True while physics moves the fragments. The look then does not position them. */
  private held = false;

  constructor(readonly stage: Stage, accent: Color) {
    this.reach = hitSphere(accent);
    stage.world.add(this.reach, this.figure, this.rings);
    this.figure.visible = false;
  }

  accent(color: Color): void {
    this.reach.traverse(object => ((object as Mesh).material as MeshBasicMaterial).color.copy(color));
  }

  /** Shows an answer. `isNew`: it belongs to another mesh, which the camera must frame. */
  async show(answer: Answer, isNew: boolean): Promise<void> {
    const turn = ++this.turn, materials = await this.materialsFor(answer, isNew);
    if (turn !== this.turn) return;  // a newer answer arrived first
    const batch = new Batch(answer, materials, this.stage.software), old = this.batch;
    this.batch = batch;
    this.held = false;
    this.stage.world.add(batch.group);
    old?.dispose();
    for (const list of this.retired.splice(0)) void list.then(free);
    this.clearWires();
    if (this.bonds) disposeOf(this.bonds.group);
    this.bonds = undefined;
    if (this.raw) disposeOf(this.raw.group);
    this.raw = undefined;
    if (isNew) {
      const { min, max } = batch.bounds();
      this.size = Math.max(1e-9, min.distanceTo(max));
      this.middle.addVectors(min, max).multiplyScalar(0.5);
      this.corners = { low: min.toArray(), high: max.toArray() };
      this.figure.position.set(max.x + 0.45, min.y, this.middle.z);
      this.stage.frame(min, max, true);
      this.stage.hold(SOON);
    } else this.stage.release();
    // The pieces of one fragment that was broken again move away from their own centre.
    const { min: low, max: high } = answer.parameters['fragment'] === undefined ? { min: this.middle, max: this.middle } : batch.bounds();
    this.from.addVectors(low, high).multiplyScalar(0.5);
    this.centers = answer.fragments.map(({ centerOfMass }) => new Vector3(...centerOfMass));
    if (this.look) this.apply(this.look);
  }

  /** Decoded images are shared by all answers of a mesh that have the same materials. */
  private async materialsFor(answer: Answer, isNew: boolean): Promise<Material[]> {
    const { materials, textures } = answer.document.json, normals = answer.fragments.some(({ normals }) => normals !== undefined);
    const key = `${answer.mesh.id} ${normals} ${JSON.stringify([materials, textures])}`;
    if (this.materials?.key !== key || isNew) {
      if (this.materials) this.retired.push(this.materials.list);
      this.materials = { key, list: materialsOf(answer) };
      if (!normals) this.materials.list = this.materials.list.then(list => list.map(material => Object.assign(material, { flatShading: true })));
      if (this.stage.software) this.materials.list = this.materials.list.then(list => list.map(plain));
    }
    return this.materials.list;
  }

  apply(look: Look): void {
    const { batch } = this, before = this.look;
    this.look = look;
    if (!batch) return;
    if (!this.held) this.spread(batch, look);
    batch.pieces.forEach(({ id }, k) => batch.poses.show(k, this.held || id === undefined || !look.hidden.has(id)));
    this.paint(batch, look);
    for (const mesh of batch.exterior) mesh.visible = !look.cutsOnly;
    for (const mesh of batch.interior) {
      const material = mesh.material as Material, side = look.cutsOnly ? DoubleSide : FrontSide;
      if (material.side !== side) Object.assign(material, { side, needsUpdate: true });
    }
    if (look.wireframe && this.wires.length === 0) this.makeWires(batch);
    if (!look.wireframe) this.clearWires();
    if (look.bonds && !this.bonds) this.stage.world.add((this.bonds = new BondGraph(batch, this.size)).group);
    if (!look.bonds && this.bonds) {
      disposeOf(this.bonds.group);
      this.bonds = undefined;
    }
    if (this.bonds && (before?.explode !== look.explode || before.level !== look.level || before.hidden !== look.hidden)) this.bonds.update();
    if (this.repairs) this.repairs.visible = look.repairs;
    this.haloes(batch, look);
    // The person is hidden if the mesh is far larger or smaller than a person, like a city or a nut.
    this.figure.visible = look.person && this.size < 40 && this.size > 0.25;
    this.stage.invalidate();
  }

  /** Lets physics move the fragments from now on, and removes overlays at their old positions. */
  hold(): void {
    this.held = true;
    this.rings.clear();
    this.reach.visible = false;
    this.batch?.pieces.forEach((_, k) => this.batch!.poses.show(k, true));
  }
  /** Ends hold(): the look positions the fragments again. */
  letGo(look: Look): void {
    this.held = false;
    this.apply(look);
  }

  /** Keeps all exploded fragments in view. */
  makeRoom(explode: number): void {
    this.stage.makeRoom(this.size / 2 * (1 + USUAL), Math.max(1, (1 + explode) / (1 + USUAL)));
  }

  /** Moves fragments away from the centre, or whole clusters. */
  private spread(batch: Batch, { explode, level }: Look): void {
    const clusters = clustersAt(batch.answer, level), levels = batch.answer.figures.levels?.[level];
    const centerOf = new Map<number, Vector3>((levels?.['id'] as number[] ?? []).map((id, k) => [id, new Vector3(...levels!['center_of_mass'][k] as [number, number, number])]));
    const away = new Vector3();
    batch.answer.fragments.forEach(({ id, translation }, k) => {
      away.copy(centerOf.get(clusters?.get(id) ?? -1) ?? this.centers[k]!).sub(this.from).multiplyScalar(explode);
      batch.poses.place(k, translation[0] + away.x, translation[1] + away.y, translation[2] + away.z);
      batch.poses.turn(k, 0, 0, 0, 1);
    });
    batch.poses.commit();
  }

  private paint(batch: Batch, { colours, level, chosen }: Look): void {
    const list = coloursOf(batch.answer, colours, level), accent = ((this.reach.material as MeshBasicMaterial).color);
    batch.answer.fragments.forEach(({ id }, k) => {
      const color = list?.[k];
      if (chosen.has(id)) batch.poses.tint(k, accent.r, accent.g, accent.b, 1);
      else if (color) batch.poses.tint(k, color.r, color.g, color.b, chosen.size > 0 ? 0.4 : 0.92);
      else batch.poses.tint(k, 0.18, 0.18, 0.19, chosen.size > 0 ? 0.6 : 0);
    });
    batch.poses.commit();
  }

  /** Draws rings around the selected fragments if there are few, so that crumbs can be found. */
  private haloes(batch: Batch, { chosen }: Look): void {
    this.rings.clear();
    if (this.held) return;
    const k = chosen.size > 0 && chosen.size <= FEW ? [...chosen].flatMap(id => batch.indexOf.get(id) ?? []).filter(index => batch.pieces[index]!.bounds.radius < SMALL * this.size) : [];
    for (const index of k) this.rings.add(ring(this.centers[index]!.clone().sub(new Vector3(...batch.pieces[index]!.origin)).add(new Vector3(...batch.poses.get(index).at)),
      (this.reach.material as MeshBasicMaterial).color));
  }

  private makeWires(batch: Batch): void {
    const material = batch.poses.apply(new MeshBasicMaterial({ wireframe: true, transparent: true, opacity: 0.35, color: 0x000000, depthWrite: false }));
    material.polygonOffset = true;
    material.polygonOffsetFactor = -1;
    this.wires = [...batch.exterior, ...batch.interior].map(mesh => {
      const wire = new Mesh(mesh.geometry, material);
      wire.frustumCulled = false;
      wire.renderOrder = 2;
      mesh.add(wire);
      return wire;
    });
  }
  private clearWires(): void {
    this.wires.forEach(wire => {
      wire.removeFromParent();
      (wire.material as Material).dispose();
    });
    this.wires = [];
  }

  /** Shows a mesh without an answer: its triangles, and its edges with only one face. */
  showRaw(points: Float32Array): void {
    this.clear();
    this.raw = rawMesh(points);
    const { min, max } = this.raw.bounds;
    this.size = Math.max(1e-9, min.distanceTo(max));
    this.middle.addVectors(min, max).multiplyScalar(0.5);
    this.stage.frame(min, max, true);
    this.stage.add(this.raw.group);
    this.stage.release();
  }

  /** Shows the open edges and filled holes of the whole mesh; undefined removes them. */
  repaired(whole: Answer | undefined): void {
    if (this.repairs) disposeOf(this.repairs);
    this.repairs = whole && repairsOf(whole);
    if (this.repairs) {
      this.repairs.visible = this.look?.repairs ?? false;
      this.stage.add(this.repairs);
    }
  }

  /** Shows the points, regions and directions that are set, with their handles. */
  wished(wish: Settings, places: ReadonlyMap<string, PlaceKind>): void {
    if (this.regions) disposeOf(this.regions);
    const settings = moved(wish, places, (this.batch?.answer.offset ?? [0, 0, 0]).map(value => -value));
    const { color } = this.reach.material as MeshBasicMaterial, extent = { middle: this.middle, size: this.size };
    this.handles = handlesOf(settings, places, extent);
    this.regions = regionsOf(settings, places, color, extent).add(dotsOf(this.handles, color));
    this.stage.world.add(this.regions);
    this.stage.invalidate(false);
  }
  get bounds(): Bounds {
    return this.corners;
  }

  /** Returns the nearest handle within this many pixels of a point on the page. */
  handleAt(x: number, y: number, within: number): string | undefined {
    let best: string | undefined, nearest = within;
    for (const { key, at } of this.handles) {
      const seen = this.stage.pixelOf(at), distance = seen ? Math.hypot(seen[0] - x, seen[1] - y) : Infinity;
      if (distance <= nearest) [best, nearest] = [key, distance];
    }
    return best;
  }
  /** Returns the settings that result from dragging a handle to this pointer position. */
  dragged(key: string, x: number, y: number): Settings | undefined {
    return this.handles.find(handle => handle.key === key)?.drag(this.stage.ray(x, y), this.stage.camera.getWorldDirection(new Vector3()));
  }

  /** Marks the location of a problem. */
  mark(points: readonly (readonly number[])[]): void {
    if (this.place) disposeOf(this.place);
    this.place = points.length > 0 ? markers(points, 0.012 * this.size, RED) : undefined;
    if (this.place) this.stage.add(this.place);
    else this.stage.invalidate(false);
  }

  pick(x: number, y: number): Picked | undefined {
    if (!this.batch) return undefined;
    // While physics moves the fragments, they form no common surface.
    const explode = this.held ? 0 : this.look?.explode ?? 0;
    return pickOnSurface(this.batch, this.stage.ray(x, y), { exterior: !this.look?.cutsOnly, interior: true }, explode, this.from);
  }

  /** Returns a sphere around the drawn fragments with these ids, or undefined if none is drawn. */
  around(ids: ReadonlySet<number>): Sphere | undefined {
    const { batch } = this, spheres = [...ids].flatMap(id => batch?.indexOf.get(id) ?? []).map(k => batch!.pieces[k]!.bounds.clone().translate(new Vector3(...batch!.poses.get(k).at)));
    return spheres.length === 0 ? undefined : spheres.slice(1).reduce((all, each) => all.union(each), spheres[0]!);
  }

  /** Shows the sphere of a hit, or no sphere if `at` is undefined. */
  reachAt(at: readonly number[] | undefined, radius: number): void {
    this.reach.visible = at !== undefined;
    if (at) this.reach.position.set(at[0]!, at[1]!, at[2]!);
    this.reach.scale.setScalar(radius);
    this.stage.invalidate(false);
  }

  /** Updates the view after physics has moved fragments. */
  moved(): void {
    this.batch?.poses.commit();
    this.bonds?.update();
    this.stage.invalidate();
  }

  clear(): void {
    if (this.raw) disposeOf(this.raw.group);
    this.raw = undefined;
    this.rings.clear();
    this.clearWires();
    if (this.bonds) disposeOf(this.bonds.group);
    this.bonds = undefined;
    this.wished({}, new Map());
    this.figure.visible = this.reach.visible = false;
    this.batch?.dispose();
    this.batch = undefined;
    this.repaired(undefined);
    this.mark([]);
  }
}

/** Disposes of materials, and of their textures and decoded images, which no other material uses. */
function free(materials: readonly Material[]): void {
  for (const material of materials) {
    for (const value of Object.values(material)) {
      if (!(value instanceof Texture)) continue;
      value.dispose();
      (value.image as Partial<ImageBitmap> | undefined)?.close?.();
    }
    material.dispose();
  }
}
