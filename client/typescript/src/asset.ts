// Converts a mesh, given as bytes or files, to the form that the server reads. Also computes the digest under which the server stores
// the mesh (PUT /meshes/{id} in proto/openapi.yaml contains the rule).
import { localError } from './problems.js';
import { hex, sha256 } from './sha256.js';

export type Bytes = ArrayBuffer | ArrayBufferView | Blob;

/** A file, for platforms without the class File. The name may contain folders. */
export interface NamedFile {
  name: string;
  data: Bytes;
}

/** A mesh: its bytes, its file, or a list of its file and the files that it references (OBJ + MTL + textures, glTF + buffers + images). */
export type MeshInput = Bytes | NamedFile | Iterable<Blob | NamedFile>;

export interface MeshFormat {
  /** `obj`, `glb`, …; needed only if neither the name nor the first bytes show the format. */
  format?: string | undefined;
  /** If there are several files: the name of the mesh file. */
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
  /** Additional files, in the order in which the digest includes them. */
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
  const what = typeof input === 'string' ? 'a string. Read the file first' : typeof input;
  throw localError('bad-argument', `A mesh must be bytes, a Blob, a File or a list of files, but item ${number} is ${what}.`,
    { parameter: 'mesh' });
}

/** Returns a name in the form that meshes and the server use: forward slashes, no leading "./". */
function plainName(name: string): string {
  if (/[\r\n\0]/.test(name))
    throw localError('bad-argument', `The file name ${JSON.stringify(name)} has a line break and cannot be sent. Rename the file.`,
      { parameter: 'mesh' });
  return name.replaceAll('\\', '/').replace(/^(\.\/)+/, '');
}

const extensionOf = (name: string) => /\.([^./]+)$/.exec(name)?.[1]?.toLowerCase() ?? '';

/** Reads a mesh. Calls `formats` only if it is unclear which of several files is the mesh. Throws FractureError. */
export async function readAsset(input: MeshInput, { format, main }: MeshFormat, formats: Formats): Promise<Asset> {
  const several = typeof input === 'object' && input !== null && !ArrayBuffer.isView(input) && Symbol.iterator in input;
  const given = (several ? [...(input as Iterable<Blob | NamedFile>)] : [input as Bytes | NamedFile]).map(asFile);
  const chosen = given.length === 1 ? given[0] : await mainOf(given, main, formats);
  if (!chosen) throw localError('bad-argument', 'The list of files is empty. Pass at least the mesh.', { parameter: 'mesh' });
  // If a whole folder was chosen, the names in the mesh are relative to the mesh's folder.
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
    if (!found) throw localError('bad-argument', `No file is named '${main}'. The files are: ${names()}.`, { parameter: 'main' });
    return found;
  }
  if (files.length === 0) return undefined;
  const known = await formats(), meshes = files.filter(file => known.includes(extensionOf(file.name)));
  if (meshes.length === 1) return meshes[0];
  throw localError('bad-argument', `Exactly one file must be a mesh that this server reads (${known.join(', ')}), but ${meshes.length} of these ` +
    `files are: ${names()}. Name the mesh with \`main\`.`, { parameter: 'main' });
}

const bytesOf = async (data: Blob) => new Uint8Array(await data.arrayBuffer());

/** Returns the digest of a mesh with additional files. Sorts the files by the bytes of their names. */
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

/** Returns the multipart form of a mesh (RFC 7578), with its parameters. If no format is given, the server detects it from the file
 * name or the first bytes. */
export function formOf({ main, files, format }: Asset, params?: string): Blob {
  const boundary = `fracture-${Math.random().toString(36).slice(2)}${Math.random().toString(36).slice(2)}`;
  const parts: (Blob | string)[] = [];
  const part = (name: string, data: Blob | string, more: string) =>
    parts.push(`--${boundary}\r\nContent-Disposition: form-data; name="${name}"${more}\r\n\r\n`, data, '\r\n');
  // The browser takes a File's type from a system table, so the name is more reliable. A Blob without a name keeps its type.
  const type = main.name === '' && /^model\//.test(main.data.type) ? `\r\nContent-Type: ${main.data.type}` : '';
  part('mesh', main.data, (main.name === '' ? '' : `; filename="${quoted(main.name)}"`) + type);
  for (const { name, data } of files) part('file', data, `; filename="${quoted(name)}"`);
  if (format !== undefined) part('format', format, '');
  if (params !== undefined) part('params', params, '\r\nContent-Type: application/json');
  parts.push(`--${boundary}--\r\n`);
  return new Blob(parts, { type: `multipart/form-data; boundary=${boundary}` });
}

const quoted = (name: string) => name.replace(/["\\]/g, '\\$&');
