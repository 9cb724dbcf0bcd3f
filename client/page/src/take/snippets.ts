// The current request for use outside the page: in a shell, in a script, without a server, or on a render farm.
import type { ParameterValue } from 'fracture-client';
import type { App } from '../app/app';
import { textOf } from '../panels/lists';
import { parametersOf } from '../state/request';
import { words } from '../words/words';

/** Returns a text as a single shell word, whatever characters it contains. */
const shell = (text: string) => (/^[\w./:=,+@%-]+$/.test(text) ? text : `'${text.replaceAll('\'', '\'\\\'\'')}'`);
const json = (value: unknown) => JSON.stringify(value);
/** Returns a filename for a curl form. curl treats commas, semicolons and spaces specially unless the name is quoted. */
const formFile = (name: string) => (!/^[\w./-]+$/.test(name) ? `"${name.replace(/["\\]/g, '\\$&')}"` : name);
/** Returns JSON for a curl form. curl ends a value at a semicolon, so this function escapes semicolons; in JSON they occur only
 * inside strings. */
const formJson = (value: unknown) => json(value).replaceAll(';', '\\u003b');
/** Returns a path that no program mistakes for an option. */
const fileWord = (name: string) => shell(name.startsWith('-') ? `./${name}` : name);
/** Removes line breaks and control characters, so that the text fits on one line. */
const oneLine = (text: string) => text.replace(/[\p{Cc}\p{Zl}\p{Zp}]/gu, ' ');

function python(value: ParameterValue): string {
  if (Array.isArray(value)) return `[${value.map(python).join(', ')}]`;
  if (typeof value === 'object' && !ArrayBuffer.isView(value)) return `{${Object.entries(value).map(([name, member]) => `${json(name)}: ${python(member as ParameterValue)}`).join(', ')}}`;
  return typeof value === 'boolean' ? (value ? 'True' : 'False') : json(value);
}

export interface Snippets {
  curl: string;
  python: string;
  javascript: string;
  bake: string;
  manifest: string;
}

export function snippets(app: App): Snippets {
  const { shown, source } = app.state, parameters = parametersOf((shown ?? app.state).wish), server = location.origin;
  const file = source?.label.includes('.') ? source.label : `${source?.label ?? 'mesh'}.glb`, out = 'fragments.glb', token = app.service.hasToken;
  const others = Array.isArray(source?.input) ? source.input.map(({ name }) => String(name)).filter(name => name.split('/').pop() !== file) : [];
  // A sample is not on disk unless somebody saves it. Shells need a comment on its own line; JSON allows none.
  const remark = (mark: string) => (source?.fetched ? `${mark} ${oneLine(words.take.sampleFile(file))}` : ''), before = (mark: string) => (source?.fetched ? `${remark(mark)}\n` : '');
  const after = source?.fetched ? `\n${remark('#')}` : '';
  return {
    curl: ['curl --fail-with-body', token ? '-H "Authorization: Bearer $TOKEN"' : '', ...[`mesh=@${formFile(file)}`, ...others.map(name => `file=@${formFile(name)}`)].map(part => `-F ${shell(part)}`),
      `\\\n  -F ${shell(`params=${formJson(parameters)};type=application/json`)}`, `\\\n  ${shell(`${server}/fracture`)} -o ${out}`].filter(Boolean).join(' ') + after,
    // Files that the mesh references are found next to it.
    python: `${before('#')}from fracture_client import Client\n\nwith Client(${json(server)}${token ? ', token=TOKEN' : ''}) as client:\n    mesh = client.put(${json(file)})\n` +
      `    answer = mesh.fracture({${Object.entries(parameters).map(([name, value]) => `\n        ${json(name)}: ${python(value)},`).join('')}\n    })\n    answer.save(${json(out)})\n`,
    javascript: `${before('//')}import { readFile, writeFile } from 'node:fs/promises';\nimport { Client } from 'fracture-client';\n\n` +
      `const client = new Client(${json(server)}${token ? ', { token: process.env.TOKEN }' : ''});\n` +
      `const mesh = await client.put(${others.length > 0 ? `await Promise.all(${json([file, ...others])}.map(async name => ({ name, data: await readFile(name) })))` : `{ name: ${json(file)}, data: await readFile(${json(file)}) }`});\n` +
      `const answer = await mesh.fracture(${json(parameters)});\nawait writeFile(${json(out)}, answer.glb);\n`,
    bake: ['fracture-server bake', fileWord(file), `-o ${out}`, ...Object.entries(parameters).map(([name, value]) => `\\\n  ${shell(`--${name}=${textOf(value)}`)}`)].join(' ') + after,
    manifest: json({ input: file, output: out, parameters }),
  };
}
