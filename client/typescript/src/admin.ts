// Health probes and metrics of the admin port, which has a separate address and requires no token.
import { FractureError } from './problems.js';
import { type CallOptions, type Settings, Transport } from './transport.js';

export class Admin {
  private readonly transport: Transport;

  /** `url`: address of the admin port; by default the server opens it at http://127.0.0.1:8081. Throws FractureError (bad-argument). */
  constructor(url: string | URL, settings: Settings = {}) {
    this.transport = new Transport(url, settings);
  }

  /** Returns whether the server process answers GET /livez in time. Throws FractureError only if the call is aborted. */
  async live(call: CallOptions = {}): Promise<boolean> {
    return this.probe('getLivez', call);
  }
  /** Returns whether the server accepts requests. False while the server is shutting down, or if it does not answer. Throws FractureError
   * only if the call is aborted. */
  async ready(call: CallOptions = {}): Promise<boolean> {
    return this.probe('getReadyz', call);
  }
  /** Returns the server's metrics in Prometheus text format, version 0.0.4. Throws FractureError. */
  async metrics(call: CallOptions = {}): Promise<string> {
    return new TextDecoder().decode((await this.transport.request('getMetrics', call)).bytes);
  }

  /** Sends a single request without retries, because a probe reports the current state. */
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
