// Probes and figures of the admin listener, which is another address and asks for no token.
import { FractureError } from './problems.js';
import { type CallOptions, type Settings, Transport } from './transport.js';

export class Admin {
  private readonly transport: Transport;

  /** `url`: http://127.0.0.1:8081 where nothing else was said. */
  constructor(url: string | URL, settings: Settings = {}) {
    this.transport = new Transport(url, settings);
  }

  /** Does the process answer? */
  async live(call: CallOptions = {}): Promise<boolean> {
    return this.probe('getLivez', call);
  }
  /** Does the server take requests? Not while it drains. */
  async ready(call: CallOptions = {}): Promise<boolean> {
    return this.probe('getReadyz', call);
  }
  /** The text exposition format of Prometheus, version 0.0.4. */
  async metrics(call: CallOptions = {}): Promise<string> {
    return new TextDecoder().decode((await this.transport.request('getMetrics', call)).bytes);
  }

  /** A probe is not tried again: that is its answer. */
  private async probe(operation: 'getLivez' | 'getReadyz', call: CallOptions): Promise<boolean> {
    try {
      await this.transport.request(operation, { retries: 0, ...call });
      return true;
    } catch (error) {
      if (error instanceof FractureError && error.problem !== 'aborted' && error.problem !== 'bad-argument') return false;
      throw error;
    }
  }
}
