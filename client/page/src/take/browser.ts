// Browser functions for text and files.

/** Copies text. Returns false if the browser does not allow it. A page loaded over plain HTTP from another machine has no clipboard,
 * so it copies from a selected field instead. */
export async function copy(text: string): Promise<boolean> {
  try {
    await navigator.clipboard.writeText(text);
    return true;
  } catch {
    const field = document.createElement('textarea');
    field.value = text;
    document.body.append(field);
    field.select();
    const done = document.execCommand('copy');
    field.remove();
    return done;
  }
}

export function saveAs(blob: Blob, name: string): void {
  const link = document.createElement('a'), url = URL.createObjectURL(blob);
  link.href = url;
  link.download = name;
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(url), 10_000);
}
