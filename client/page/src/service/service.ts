// The server that sent the page: what it can do, whether it is available, and the token that it requires.
import { Client, FractureError, type Limits, type ParameterDescription, type Patterns } from 'fracture-client';

export type ServiceState = 'connecting' | 'ready' | 'absent' | 'token';

export interface Knowledge {
  version: { name: string; version: string; algorithm: number };
  limits: Limits;
  patterns: Patterns;
}

const AGAIN = 1500;  // ms between requests to a server that is away

export class Service {
  readonly client: Client;
  knowledge: Knowledge | undefined;
  state: ServiceState = 'connecting';
  /** Kept only in memory: after a reload, the page asks for it again. */
  private token = '';
  private timer: ReturnType<typeof setTimeout> | undefined;

  /** `changed` is called if the state has changed, and `back` if the server has become available (again). */
  constructor(private readonly changed: () => void, private readonly back: () => void) {
    this.client = new Client('', { token: () => this.token, retries: 2 });
  }

  async start(): Promise<void> {
    try {
      const once = { retries: 0, timeout: 10_000 };
      const [version, limits, patterns] = await Promise.all([this.client.version(once), this.client.limits(once), this.client.patterns(once)]);
      this.knowledge = { version, limits, patterns };
      this.become('ready');
      this.back();
    } catch (error) {
      this.noticed(error);
    }
  }

  /** Call this for every failure. Returns true if it only means that the server is away or requires a token. */
  noticed(error: unknown): boolean {
    if (!(error instanceof FractureError)) return false;
    if (error.problem === 'unauthorized') {
      this.become('token');
      return true;
    }
    if (['server-absent', 'timed-out', 'draining'].includes(error.problem) || (!this.knowledge && error.problem !== 'aborted')) {
      this.become('absent');
      this.timer ??= setTimeout(() => {
        this.timer = undefined;
        void this.start();
      }, AGAIN);
      return true;
    }
    return false;
  }

  useToken(token: string): void {
    this.token = token.trim();
    void this.start();
  }

  get hasToken(): boolean {
    return this.token !== '';
  }

  private become(state: ServiceState): void {
    // Set even if the state is the same, because the token may have been wrong.
    this.state = state;
    this.changed();
  }

  /** The headings under which the documents list parameters. A parameter that is in none of them follows without a heading. */
  get groups(): { title: string; description: string; parameters: string[] }[] {
    return this.knowledge?.limits['parameter_groups'] ?? [];
  }

  /** Every parameter once. `patterns` lists the patterns that use it; it is absent if all patterns do. */
  get parameters(): (ParameterDescription & { patterns?: string[] })[] {
    if (!this.knowledge) return [];
    const { limits, patterns } = this.knowledge, shared = new Set(patterns.parameters.map(({ name }) => name));
    return limits.parameters.map(parameter => {
      const having = patterns.patterns.filter(pattern => pattern.parameters.some(({ name }) => name === parameter.name)).map(({ name }) => name);
      return shared.has(parameter.name) || having.length === 0 ? parameter : { ...parameter, patterns: having };
    });
  }

  /** Returns the pattern that applies to these settings: their own, their material's, or the server's default. */
  patternOf(settings: Readonly<Record<string, unknown>>): string {
    const material = this.knowledge?.patterns.materials.find(({ name }) => name === settings['material']);
    return String(settings['pattern'] ?? material?.parameters['pattern'] ?? this.parameters.find(({ name }) => name === 'pattern')?.['default'] ?? '');
  }

  /** The parameters that shape the solid before it is fractured: those that are in /limits but in no pattern. */
  get solidParameters(): Set<string> {
    if (!this.knowledge) return new Set();
    const { limits, patterns } = this.knowledge;
    const broken = new Set([...patterns.parameters, ...patterns.patterns.flatMap(({ parameters }) => parameters)].map(({ name }) => name as string));
    return new Set(limits.parameters.map(({ name }) => name).filter(name => !broken.has(name)));
  }
}
