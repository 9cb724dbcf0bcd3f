// A mesh as a caller has it, bytes or files, as the service takes it: a form, and the content key that it is stored
// under (PUT /meshes/{id} of proto/openapi.yaml says how).
import { localError } from './problems.js';
import { hex, sha256 } from './sha256.js';

export type Bytes = ArrayBuffer | ArrayBufferView | Blob;

/** A file where there is no File: `data` with its name, which may have folders. */
export interface NamedFile {
  name: string;
  data: Bytes;
}

/** One mesh: its bytes, a file, or files of which one is the mesh and the others are what it names (OBJ + MTL + textures,
 * glTF + buffers + images). */
export type MeshInput = Bytes | NamedFile | Iterable<Blob | NamedFile>;

export interface MeshFormat {
  /** `obj`, `glb`, …, where neither name nor first bytes say it. */
  format?: string | undefined;
  /** Of several files: the name of the one that is the mesh. */
  main?: string | undefined;
}

interface AssetFile {
  name: string;
  data: Blob;
}

export interface Asset {
  /** "sha256:" and 64 hex digits. */
  id: string;
  main: AssetFile;
  /** Further files, ordered as the content key orders them. */
  files: AssetFile[];
  format: string | undefined;
}

const isNamed = (input: unknown): input is NamedFile =>
  typeof input === 'object' && input !== null && 'data' in input && typeof (input as NamedFile).name === 'string';

function asFile(input: Bytes | NamedFile, number: number): AssetFile {
  if (isNamed(input)) return { ...asFile(input.data, number), name: plainName(input.name) };
  if (input instanceof Blob) {
    const { name, webkitRelativePath } = input as Partial<File>;
    return { name: plainName(webkitRelativePath || name || ''), data: input };
  }
  if (input instanceof ArrayBuffer || ArrayBuffer.isView(input)) return { name: '', data: new Blob([input as BufferSource]) };
  const what = typeof input === 'string' ? 'a text, of which nobody can know whether it is a path' : typeof input;
  throw localError('bad-argument', `A mesh is bytes, a Blob, a File or a list of files; item ${number} is ${what}.`, { parameter: 'mesh' });
}

/** As an asset would write it, and as the service keeps it: forward slashes, no leading "./". */
function plainName(name: string): string {
  if (/[\r\n\0]/.test(name))
    throw localError('bad-argument', `A file name with a line break cannot be sent: ${JSON.stringify(name)}.`, { parameter: 'mesh' });
  return name.replaceAll('\\', '/').replace(/^(\.\/)+/, '');
}

const extensionOf = (name: string) => /\.([^./]+)$/.exec(name)?.[1]?.toLowerCase() ?? '';

/** `formats`: asked only where it has to be found out which of several files is the mesh. */
export async function readAsset(input: MeshInput, { format, main }: MeshFormat, formats: Formats): Promise<Asset> {
  const several = typeof input === 'object' && input !== null && !ArrayBuffer.isView(input) && Symbol.iterator in input;
  const given = (several ? [...(input as Iterable<Blob | NamedFile>)] : [input as Bytes | NamedFile]).map(asFile);
  const chosen = given.length === 1 ? given[0] : await mainOf(given, main, formats);
  if (!chosen) throw localError('bad-argument', 'There is no file in the list.', { parameter: 'mesh' });
  // A folder that was chosen as a whole: what the mesh names is named from where the mesh is.
  const folder = chosen.name.slice(0, chosen.name.lastIndexOf('/') + 1);
  const files = given.filter(file => file !== chosen).map(file => ({
    data: file.data, name: folder !== '' && file.name.startsWith(folder) ? file.name.slice(folder.length) : file.name,
  }));
  const own = hex(await sha256(await bytesOf(chosen.data)));
  return { id: `sha256:${files.length > 0 ? await keyOf(own, files) : own}`, main: chosen, files, format };
}

type Formats = () => Promise<readonly string[]>;

async function mainOf(files: AssetFile[], main: string | undefined, formats: Formats): Promise<AssetFile | undefined> {
  const names = () => files.map(file => file.name || '(no name)').join(', ');
  if (main !== undefined) {
    const wanted = plainName(main);
    const found = files.find(file => file.name === wanted) ?? files.find(file => file.name.endsWith(`/${wanted}`));
    if (!found) throw localError('bad-argument', `'${main}' is none of the files: ${names()}.`, { parameter: 'main' });
    return found;
  }
  if (files.length === 0) return undefined;
  const known = await formats(), meshes = files.filter(file => known.includes(extensionOf(file.name)));
  if (meshes.length === 1) return meshes[0];
  throw localError('bad-argument', `${meshes.length} of ${files.length} files are meshes that this server reads (${known.join(', ')}): ` +
    `say by \`main\` which one is meant. They are ${names()}.`, { parameter: 'main' });
}

const bytesOf = async (data: Blob) => new Uint8Array(await data.arrayBuffer());

/** The digest of a mesh with further files, which it sorts by the bytes of their names. */
async function keyOf(mesh: string, files: AssetFile[]): Promise<string> {
  const utf8 = new TextEncoder();
  const listed = await Promise.all(files.map(async file =>
    ({ file, name: utf8.encode(file.name), digest: hex(await sha256(await bytesOf(file.data))) })));
  listed.sort((a, b) => compareBytes(a.name, b.name));
  files.splice(0, files.length, ...listed.map(({ file }) => file));
  const lines = listed.map(({ file, name, digest }) => `${name.length} ${file.name} ${digest}\n`);
  const inner = hex(await sha256(utf8.encode(`files\n${mesh}\n${lines.join('')}`)));
  return hex(await sha256(utf8.encode(`fracture files 2\n${inner}`)));
}

function compareBytes(a: Uint8Array, b: Uint8Array): number {
  const least = Math.min(a.length, b.length);
  for (let k = 0; k < least; ++k) if (a[k] !== b[k]) return a[k]! - b[k]!;
  return a.length - b.length;
}

/** The form of a mesh (RFC 7578), with parameters in it where they are given. A format that is not said is known to the
 * service by the name of the file or its first bytes. */
export function formOf({ main, files, format }: Asset, params?: string): Blob {
  const boundary = `fracture-${Math.random().toString(36).slice(2)}${Math.random().toString(36).slice(2)}`;
  const parts: (Blob | string)[] = [];
  const part = (name: string, data: Blob | string, more: string) =>
    parts.push(`--${boundary}\r\nContent-Disposition: form-data; name="${name}"${more}\r\n\r\n`, data, '\r\n');
  // Types of files are whatever the system's table has for their ending: names say more. A Blob without a name has its type.
  const type = main.name === '' && /^model\//.test(main.data.type) ? `\r\nContent-Type: ${main.data.type}` : '';
  part('mesh', main.data, (main.name === '' ? '' : `; filename="${quoted(main.name)}"`) + type);
  for (const { name, data } of files) part('file', data, `; filename="${quoted(name)}"`);
  if (format !== undefined) part('format', format, '');
  if (params !== undefined) part('params', params, '\r\nContent-Type: application/json');
  parts.push(`--${boundary}--\r\n`);
  return new Blob(parts, { type: `multipart/form-data; boundary=${boundary}` });
}

const quoted = (name: string) => name.replace(/["\\]/g, '\\$&');
