// Dropped or chosen files and folders, in the form that the package takes.
import type { NamedFile } from 'fracture-client';

export interface Dropped {
  label: string;
  files: NamedFile[];
}

/** Reads the files and folders of a drop. Call it while the event is handled, because the browser provides the entries only then;
 * reading them may take longer. */
export async function filesOf(data: DataTransfer): Promise<Dropped | undefined> {
  const entries = [...data.items].filter(({ kind }) => kind === 'file').map(item => item.webkitGetAsEntry?.() ?? item.getAsFile());
  const files: NamedFile[] = [];
  for (const entry of entries) {
    if (entry instanceof File) files.push({ name: entry.name, data: entry });
    else if (entry) await walk(entry, '', files);
  }
  return named(files);
}

export function chosenFiles(list: FileList | readonly File[]): Dropped | undefined {
  return named([...list].map(file => ({ name: file.webkitRelativePath || file.name, data: file })));
}

/** Removes files that operating systems leave in folders, because they are not part of an asset. */
const named = (all: NamedFile[]): Dropped | undefined => {
  const files = all.filter(({ name }) => !/(^|\/)(\.|Thumbs\.db$|desktop\.ini$)/.test(name));
  return files.length === 0 ? undefined : { files, label: files[0]!.name.split('/').pop()! };
};

async function walk(entry: FileSystemEntry, folder: string, into: NamedFile[]): Promise<void> {
  if (entry.isFile) {
    const file = await new Promise<File>((resolve, reject) => (entry as FileSystemFileEntry).file(resolve, reject));
    into.push({ name: folder + entry.name, data: file });
    return;
  }
  const reader = (entry as FileSystemDirectoryEntry).createReader();
  for (;;) {
    const some = await new Promise<FileSystemEntry[]>((resolve, reject) => reader.readEntries(resolve, reject));
    if (some.length === 0) return;
    for (const child of some) await walk(child, `${folder}${entry.name}/`, into);
  }
}

/** Returns the files in a format that the server reads, largest first. The page uses the first one. */
export function meshesOf(files: readonly NamedFile[], formats: readonly string[]): NamedFile[] {
  const ending = (name: string) => /\.([^./]+)$/.exec(name)?.[1]?.toLowerCase() ?? '';
  const size = ({ data }: NamedFile) => (data instanceof Blob ? data.size : data.byteLength);
  const meshes = files.filter(({ name }) => formats.includes(ending(name)));
  return [...meshes].sort((a, b) => size(b) - size(a));
}
