// The request as the page keeps it: the settings, and the hits that follow. Everything else is derived from it.
import type { Answer, ParameterValue, Vector3 } from 'fracture-client';

export type Settings = Readonly<Record<string, ParameterValue>>;

export interface Hit {
  point: Vector3;
  /** In metres. */
  radius: number;
  /** The number of cells of the hit; undefined: the server's default. */
  sites?: number | undefined;
}

/** The server's default for local_sites. */
export const HIT_SITES = 30;

export interface Wish {
  settings: Settings;
  hits: readonly Hit[];
}

/** Returns the parameters of a single request for everything: the settings and all hits. */
export function parametersOf({ settings, hits }: Wish): Record<string, ParameterValue> {
  if (hits.length === 0) return { ...settings };
  return {
    ...settings, local_point: hits.map(({ point }) => point), local_radius: hits.map(({ radius }) => radius), local_rest: 'fractured',
    ...(hits.some(({ sites }) => sites !== undefined) ? { local_sites: hits.map(({ sites = HIT_SITES }) => sites) } : {}),
  };
}

export function withSetting(settings: Settings, name: string, value: ParameterValue | undefined): Settings {
  const next = { ...settings };
  if (value === undefined) delete next[name];
  else next[name] = value;
  return next;
}

/** Removes those of the page's `own` settings that, according to a problem, exclude one of the user's settings. The problem's
 * `details` quote both names. Returns undefined if there is nothing to remove. */
export function withoutExcluded(settings: Settings, own: Settings, details: readonly string[]): Settings | undefined {
  const isOwn = (name: string) => own[name] !== undefined && JSON.stringify(own[name]) === JSON.stringify(settings[name]);
  const gone = new Set(details.flatMap(detail => {
    const named = [...detail.matchAll(/'(\w+)'/g)].map(([, name]) => name!).filter(name => settings[name] !== undefined);
    return named.some(name => !isOwn(name)) && new Set(named).size > 1 ? named.filter(isOwn) : [];
  }));
  return gone.size === 0 ? undefined : Object.fromEntries(Object.entries(settings).filter(([name]) => !gone.has(name)));
}

/** Returns the request with the settings that another pattern accepts, because it refuses other patterns' parameters. If there are
 * no hits yet, impacts become hits with this radius. */
export function underPattern({ settings, hits }: Wish, pattern: string, parameters: readonly { name: string; patterns?: string[] }[], radius: number): Wish {
  const foreign = new Set(parameters.filter(({ patterns }) => patterns && !patterns.includes(pattern)).map(({ name }) => name)), { impacts } = settings;
  const moved = foreign.has('impacts') && Array.isArray(impacts) ? (impacts as Vector3[]).map(point => ({ point, radius })).filter(({ point }) => !hits.some(hit => String(hit.point) === String(point))) : [];
  return { settings: Object.fromEntries(Object.entries(settings).filter(([name]) => !foreign.has(name))), hits: [...moved, ...hits] };
}

/** A request and its result, to which undo returns. */
export interface Step extends Wish {
  answer: Answer | undefined;
  /** The number of the gesture: all values of a drag are one step. */
  gesture: number;
}

/** The maximum number of answers that are kept. Older ones are requested again, and are identical. */
const KEPT = 8;
const ONE_GESTURE = 900;  // ms between two key presses or drags that belong together

/** Decides which values belong to one step: all values of a drag, however long their answers take, and quick successive changes to
 * the same setting. */
export class Gestures {
  private number = 0;
  private cause = '';
  private held = false;
  private at = -Infinity;

  /** Returns the number of the gesture that set a value at `now` (ms). `cause`: the setting that changed, '' for a gesture of its
   * own. `settled`: the drag has ended. */
  of(cause: string, settled: boolean, now: number): number {
    if (cause === '' || cause !== this.cause || !(this.held || now - this.at < ONE_GESTURE)) ++this.number;
    this.cause = cause;
    this.held = !settled;
    this.at = now;
    return this.number;
  }
  letGo(): void {
    this.held = false;
  }
}

export class History {
  private steps: Step[] = [];
  private at = -1;

  get canUndo(): boolean {
    return this.at > 0;
  }
  get canRedo(): boolean {
    return this.at + 1 < this.steps.length;
  }
  /** Returns a function that restores the current steps. */
  keep(): () => void {
    const { steps, at } = this;
    return () => {
      this.steps = steps;
      this.at = at;
    };
  }
  clear(): void {
    this.steps = [];
    this.at = -1;
  }

  push(step: Step): void {
    const top = this.steps[this.at];
    this.steps.length = this.at + 1;
    if (top && this.at > 0 && top.gesture === step.gesture) this.steps[this.at] = step;
    else this.at = this.steps.push(step) - 1;
    this.steps.forEach((old, k) => {
      if (k < this.at - KEPT) old.answer = undefined;
    });
  }

  move(by: 1 | 0 | -1): Step | undefined {
    const step = this.steps[this.at + by];
    if (step) this.at += by;
    return step;
  }
}
