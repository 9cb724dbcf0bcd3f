// SHA-256 (FIPS 180-4): with WebCrypto, or with the code below if WebCrypto is missing, as in node 18 and in pages loaded over plain
// HTTP from another machine.

/** Returns the constants of SHA-256: the first 32 bits of the fractional parts of the first primes' square roots and cube roots. */
function constants(): { start: Uint32Array; rounds: Uint32Array } {
  const start = new Uint32Array(8), rounds = new Uint32Array(64), primes: number[] = [];
  for (let n = 2; primes.length < 64; ++n) if (primes.every(p => n % p !== 0)) primes.push(n);
  const fraction = (x: number) => Math.floor((x - Math.floor(x)) * 2 ** 32);
  primes.forEach((p, k) => {
    if (k < 8) start[k] = fraction(Math.sqrt(p));
    rounds[k] = fraction(Math.cbrt(p));
  });
  return { start, rounds };
}

let tables: ReturnType<typeof constants> | undefined;

/** Returns the SHA-256 of the bytes without WebCrypto, at about 100 MB/s. Exported for its test. */
export function sha256Here(bytes: Uint8Array): Uint8Array {
  const { start, rounds } = (tables ??= constants());
  const state = Uint32Array.from(start), w = new Uint32Array(64);
  const block = (view: DataView, at: number) => {
    for (let t = 0; t < 16; ++t) w[t] = view.getUint32(at + 4 * t);
    for (let t = 16; t < 64; ++t) {
      const x = w[t - 15]!, y = w[t - 2]!;
      w[t] = ((y >>> 17 | y << 15) ^ (y >>> 19 | y << 13) ^ y >>> 10) + w[t - 7]! +
             ((x >>> 7 | x << 25) ^ (x >>> 18 | x << 14) ^ x >>> 3) + w[t - 16]!;
    }
    let a = state[0]!, b = state[1]!, c = state[2]!, d = state[3]!, e = state[4]!, f = state[5]!, g = state[6]!, h = state[7]!;
    for (let t = 0; t < 64; ++t) {
      const one = h + ((e >>> 6 | e << 26) ^ (e >>> 11 | e << 21) ^ (e >>> 25 | e << 7)) + (e & f ^ ~e & g) + rounds[t]! + w[t]! | 0;
      const two = ((a >>> 2 | a << 30) ^ (a >>> 13 | a << 19) ^ (a >>> 22 | a << 10)) + (a & b ^ a & c ^ b & c) | 0;
      h = g, g = f, f = e, e = d + one | 0, d = c, c = b, b = a, a = one + two | 0;
    }
    for (const [k, value] of [a, b, c, d, e, f, g, h].entries()) state[k]! += value;
  };
  const whole = bytes.byteLength - bytes.byteLength % 64, rest = bytes.byteLength - whole;
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  for (let at = 0; at < whole; at += 64) block(view, at);
  const last = new Uint8Array(rest < 56 ? 64 : 128), end = new DataView(last.buffer);
  last.set(bytes.subarray(whole));
  last[rest] = 0x80;
  end.setUint32(last.length - 8, Math.floor(bytes.byteLength / 2 ** 29));
  end.setUint32(last.length - 4, bytes.byteLength * 8 % 2 ** 32);
  for (let at = 0; at < last.length; at += 64) block(end, at);
  const digest = new Uint8Array(32), out = new DataView(digest.buffer);
  state.forEach((word, k) => out.setUint32(4 * k, word));
  return digest;
}

export async function sha256(bytes: Uint8Array): Promise<Uint8Array> {
  const subtle = globalThis.crypto?.subtle;
  if (!subtle) return sha256Here(bytes);
  return new Uint8Array(await subtle.digest('SHA-256', bytes as Uint8Array<ArrayBuffer>));
}

export function hex(bytes: Uint8Array): string {
  let text = '';
  for (const byte of bytes) text += byte.toString(16).padStart(2, '0');
  return text;
}

/** Returns whether a Repr-Digest field (RFC 9530) contains the SHA-256 of these bytes. False if it has no sha-256. */
export async function digestMatches(field: string, bytes: Uint8Array): Promise<boolean> {
  const named = /(?:^|,)\s*sha-256=:([A-Za-z0-9+/=]*):/.exec(field)?.[1];
  return named !== undefined && named === btoa(String.fromCharCode(...await sha256(bytes)));
}
