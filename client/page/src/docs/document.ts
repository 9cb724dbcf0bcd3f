// The parts of OpenAPI 3.1 that are shown.
export interface Schema {
  type?: string | string[];
  description?: string;
  enum?: unknown[];
  const?: unknown;
  minimum?: number;
  maximum?: number;
  exclusiveMinimum?: number;
  default?: unknown;
  pattern?: string;
  items?: Schema;
  minItems?: number;
  maxItems?: number;
  properties?: Record<string, Schema>;
}
export interface Operation {
  tags?: string[];
  summary?: string;
  description?: string;
  parameters?: unknown[];
  requestBody?: unknown;
  responses: Record<string, unknown>;
}

/** Returns type, range and default in one line. */
export function typeOf(schema: Schema | undefined): string {
  if (!schema) return '';
  const { type, minimum, exclusiveMinimum, maximum, items } = schema, parts: string[] = [];
  if (schema.enum) parts.push(schema.enum.map(String).join(' | '));
  else if (type === 'array') parts.push(`list${schema.maxItems !== undefined ? `, at most ${schema.maxItems}` : ''} of (${typeOf(items)})`);
  else if (type) parts.push(String(type));
  if (minimum !== undefined || exclusiveMinimum !== undefined || maximum !== undefined)
    parts.push(`${minimum ?? (exclusiveMinimum !== undefined ? `over ${exclusiveMinimum}` : '…')} to ${maximum ?? '…'}`);
  if (schema.pattern) parts.push(schema.pattern);
  if (schema.default !== undefined) parts.push(`default ${JSON.stringify(schema.default)}`);
  return parts.join(', ');
}

/** Returns command lines that users can copy. */
export function examplesOf(method: string, path: string, origin: string): string[] {
  const id = 'sha256:…', address = `'${origin}${path.replace('{id}', path.startsWith('/jobs') ? '…' : id).replace('{name}', 'bad-parameter')}'`;
  if (path.startsWith('/livez') || path.startsWith('/readyz') || path.startsWith('/metrics')) return [];
  if (method === 'get') return [`curl --fail-with-body -H 'Accept: application/json' ${address}`];
  if (path === '/fracture') return [`curl --fail-with-body -F mesh=@barrel.glb -F params='{"material": "stone", "fragments": 80};type=application/json' \\\n  ${address} -o fragments.glb`];
  if (path.endsWith('/fracture')) return [`curl --fail-with-body -H 'Content-Type: application/json' -d '{"sites": 50, "seed": 7}' \\\n  ${address} -o fragments.glb`];
  if (method === 'put') return [`curl --fail-with-body -T barrel.glb -H 'Content-Type: model/gltf-binary' ${address}`];
  if (method === 'delete') return [`curl --fail-with-body -X DELETE ${address}`];
  return path === '/meshes' ? [`curl --fail-with-body -F mesh=@barrel.obj ${address}`] : [];
}
