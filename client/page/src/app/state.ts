// Everything that the page shows, in one place. Panels read it; the App changes it.
import type { Answer, FractureError, JobDocument, Mesh, MeshInput } from 'fracture-client';
import type { Look } from '../scene/view';
import type { Wish } from '../state/request';

/** A mesh that the server offers; `file` as below /page/. */
export interface Offered {
  name: string;
  file: string;
  bytes: number;
}

/** A mesh that was brought. */
export interface Source {
  label: string;
  /** One of samples.ts. */
  sample: string | undefined;
  /** On no disk of who looks at it: a sample, or one that the server offers. */
  fetched: boolean;
  input: MeshInput | undefined;
  main: string | undefined;
  mesh: Mesh;
  /** A sample in the looks of materials, by their names: other colours, other digests. All of them have the same map. */
  dresses: Map<string, Source>;
  /** Of one fragment for each part: closed, in metres, y up. */
  whole: Answer;
}

export interface Shown {
  answer: Answer;
  wish: Wish;
  /** Milliseconds from the input to the picture, and until the answer was there. */
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
  /** What is being read. */
  bringing: string | undefined;
  /** What a link asks for, whose mesh the server has not. */
  wanted: { mesh: string; name: string; wish: Wish } | undefined;
  wish: Wish;
  shown: Shown | undefined;
  /** A wish that came to nothing. */
  unmet: Wish | undefined;
  problem: FractureError | undefined;
  /** The file that the problem is about. */
  refused: string | undefined;
  note: string | undefined;
  /** Of several meshes that were dropped. */
  leftOut: { taken: string; others: string[] } | undefined;
  /** Meshes that the server lays beside the page's own samples. */
  offered: readonly Offered[];
  inFlight: number;
  job: JobDocument | undefined;
  tool: Tool;
  /** Metres; of the next hit. */
  radius: number;
  look: Look;
  tab: Tab;
  sheet: Sheet;
  /** Text that parameters are filtered by. */
  filter: string;
  more: boolean;
  sort: { by: 'name' | 'volume' | 'mass' | 'triangles'; down: boolean };
  rows: number;
  play: PlayState | undefined;
  webgl: boolean;
  /** The graphics card is away: the picture comes back with it. */
  lost: boolean;
}

export const firstState = (): State => ({
  source: undefined, bringing: undefined, wanted: undefined, wish: { settings: {}, hits: [] }, shown: undefined, unmet: undefined, problem: undefined, refused: undefined, note: undefined, leftOut: undefined, offered: [],
  inFlight: 0, job: undefined, tool: 'hit', radius: 0.1,
  look: {
    explode: 0.18, cutsOnly: false, colours: 'material', level: 99, bonds: false, wireframe: false, repairs: false, person: false, chosen: new Set(),
  },
  tab: 'break', sheet: undefined, filter: '', more: false, sort: { by: 'volume', down: true }, rows: 50, play: undefined, webgl: true, lost: false,
});
