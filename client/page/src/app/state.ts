// Everything that the page shows, in one place. Panels read it; only the App changes it.
import type { Answer, Estimate, FractureError, JobDocument, Mesh, MeshInput } from 'fracture-client';
import type { Look } from '../scene/view';
import type { Wish } from '../state/request';
import type { Names } from '../take/pieces';

/** A mesh offered by the server; `file` is relative to /page/. */
export interface Offered {
  name: string;
  file: string;
  bytes: number;
}

/** The mesh that is open. */
export interface Source {
  label: string;
  /** A sample from samples.ts. */
  sample: string | undefined;
  /** True if the mesh is not on the user's disk: a sample, or a mesh offered by the server. */
  fetched: boolean;
  input: MeshInput | undefined;
  main: string | undefined;
  mesh: Mesh;
  /** The same sample in the looks of different materials, by name. Each look has its own colours and digest. All of them share this map. */
  dresses: Map<string, Source>;
  /** The answer with one fragment for each part of the mesh: closed, in metres, y up. */
  whole: Answer;
}

export interface Shown {
  answer: Answer;
  wish: Wish;
  /** Milliseconds from the input to the picture, and to the arrival of the answer. */
  toPicture: number;
  toAnswer: number;
}

export type Tool = 'hit' | 'aim' | 'select';
export type Tab = 'mesh' | 'break' | 'pieces' | 'take';
export type Sheet = 'keys' | 'token' | 'seal' | undefined;

export interface PlayState {
  loading: boolean;
  running: boolean;
  slow: boolean;
  bodies: number;
  resting: boolean;
}

export interface State {
  source: Source | undefined;
  /** The file that is being read. */
  bringing: string | undefined;
  /** The mesh that a link requests but the server does not have. */
  wanted: { mesh: string; name: string; wish: Wish } | undefined;
  wish: Wish;
  shown: Shown | undefined;
  /** The request that failed with the current problem. */
  unmet: Wish | undefined;
  problem: FractureError | undefined;
  /** The file with the problem. */
  refused: string | undefined;
  note: string | undefined;
  /** Set if several meshes were dropped. */
  leftOut: { taken: string; others: string[] } | undefined;
  /** Meshes that the server offers in addition to the page's own samples. */
  offered: readonly Offered[];
  inFlight: number;
  /** The server's estimate for the request in flight. */
  expected: Estimate | undefined;
  job: JobDocument | undefined;
  tool: Tool;
  /** The radius of the next hit, in metres. */
  radius: number;
  /** The number of cells of the next hit; undefined: the server's default. */
  sites: number | undefined;
  /** The names that the user gave to fragments, by id. */
  names: Names;
  look: Look;
  tab: Tab;
  sheet: Sheet;
  /** Text by which parameters are filtered. */
  filter: string;
  more: boolean;
  sort: { by: 'name' | 'volume' | 'mass' | 'triangles'; down: boolean };
  rows: number;
  play: PlayState | undefined;
  webgl: boolean;
  /** True if the graphics card was lost. The picture returns when the card does. */
  lost: boolean;
}

export const firstState = (): State => ({
  source: undefined, bringing: undefined, wanted: undefined, wish: { settings: {}, hits: [] }, shown: undefined, unmet: undefined, problem: undefined, refused: undefined, note: undefined, leftOut: undefined, offered: [],
  inFlight: 0, expected: undefined, job: undefined, tool: 'hit', radius: 0.1, sites: undefined, names: new Map(),
  look: {
    explode: 0.18, cutsOnly: false, colours: 'material', level: 99, bonds: false, wireframe: false, repairs: false, person: false, chosen: new Set(), hidden: new Set(),
  },
  tab: 'break', sheet: undefined, filter: '', more: false, sort: { by: 'volume', down: true }, rows: 50, play: undefined, webgl: true, lost: false,
});
