// The page as fracture-server serves it, in front of a fracture-server: its files with strong ETags and the policy, everything else passed
// on. It can count, delay and refuse requests.
import { createHash } from 'node:crypto';
import fs from 'node:fs';
import http from 'node:http';
import path from 'node:path';

export const POLICY = "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self'; worker-src 'self' blob:; " +
  "img-src 'self' blob: data:; connect-src 'self'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'";
const TYPES = { '.html': 'text/html; charset=utf-8', '.js': 'text/javascript; charset=utf-8', '.css': 'text/css; charset=utf-8', '.svg': 'image/svg+xml', '.txt': 'text/plain; charset=utf-8', '.json': 'application/json' };

export class Site {
  /** Requests that were passed on: {method, path, at, ended, aborted, status}. */
  passed = [];
  /** Number of fractures in flight, now and at most. */
  inFlight = 0;
  most = 0;
  /** Milliseconds by which a fracture is delayed. */
  delay = 0;
  /** The address of the server; undefined: no server. */
  target;
  /** If true, every connection is cut, as if the server were away. */
  away = false;
  /** Replacements for files by path, for example from another build. */
  instead = new Map();

  constructor(dist, target) {
    this.dist = dist;
    this.target = target;
    this.server = http.createServer((request, response) => this.serve(request, response));
    // Browsers keep connections alive; tests should see requests, not reconnections.
    this.server.keepAliveTimeout = 60_000;
  }

  async listen() {
    await new Promise(resolve => this.server.listen(0, '127.0.0.1', resolve));
    return this;
  }
  get url() {
    return `http://127.0.0.1:${this.server.address().port}`;
  }
  close() {
    this.server.closeAllConnections?.();
    this.server.close();
  }

  serve(request, response) {
    if (this.away) return void response.destroy();
    const { pathname } = new URL(request.url, 'http://page.test'), html = (request.headers.accept ?? '').includes('text/html');
    // Samples come from the server.
    const offer = /^\/page\/sample(s\.json|-\d+)$/.test(pathname), file = offer ? undefined : pathname === '/' && html ? 'index.html' : pathname === '/docs' ? 'docs.html' : pathname.startsWith('/page/') ? pathname.slice(1) : undefined;
    if (file === undefined) return this.pass(request, response, pathname);
    const full = path.join(this.dist, file);
    if (!full.startsWith(this.dist) || !fs.existsSync(full)) return void response.writeHead(404).end();
    const bytes = this.instead.get(pathname) ?? fs.readFileSync(full), tag = `"${createHash('sha256').update(bytes).digest('hex').slice(0, 32)}"`;
    const headers = {
      'Content-Type': TYPES[path.extname(file)], 'Content-Security-Policy': POLICY, ETag: tag, 'Cache-Control': 'no-cache', Vary: 'Accept',
      'Referrer-Policy': 'same-origin', 'X-Content-Type-Options': 'nosniff',
    };
    if (request.headers['if-none-match'] === tag) return void response.writeHead(304, headers).end();
    response.writeHead(200, { ...headers, 'Content-Length': bytes.length }).end(bytes);
    return undefined;
  }

  pass(request, response, pathname) {
    const fracture = pathname.endsWith('/fracture') && request.method === 'POST', chunks = [];
    const seen = { method: request.method, path: pathname, at: performance.now(), ended: undefined, aborted: false, status: 0, body: '' };
    this.passed.push(seen);
    if (fracture) this.most = Math.max(this.most, ++this.inFlight);
    const done = () => {
      if (seen.ended !== undefined) return;
      seen.ended = performance.now();
      if (fracture) --this.inFlight;
    };
    let onward;
    response.on('close', () => {
      seen.aborted = !response.writableEnded;
      onward?.destroy();
      done();
    });
    request.on('data', chunk => chunks.push(chunk));
    request.on('end', () => {
      const body = Buffer.concat(chunks);
      if (body.length < 10_000) seen.body = body.toString('utf8');
      // pause: so that answers can overtake one another
      setTimeout(() => {
        if (response.destroyed) return;
        if (!this.target) return void response.destroy();
        const { hostname, port } = new URL(this.target);
        const headers = { ...request.headers, host: `${hostname}:${port}`, 'content-length': body.length };
        // The server must take this proxy for a program, not for a page.
        for (const name of ['origin', 'referer', 'transfer-encoding', 'sec-fetch-site', 'sec-fetch-mode', 'sec-fetch-dest', 'connection']) delete headers[name];
        if (request.method === 'GET' || request.method === 'HEAD') delete headers['content-length'];
        onward = http.request({ hostname, port, method: request.method, path: request.url, headers }, answer => {
          seen.status = answer.statusCode;
          response.writeHead(answer.statusCode, answer.headers);
          answer.pipe(response);
          answer.on('error', () => response.destroy());
        });
        onward.on('error', () => response.destroy());
        onward.end(body);
      }, fracture ? this.delay : 0);
    });
  }
}
