// Files that are dropped or chosen: a mesh with what it names, a folder, or a scene. Out: [{name, file}], `/` in names.

export const chosen = (list) => [...list].map((file) => ({ name: file.webkitRelativePath || file.name, file }));

// Must be called while the event is handled: what is dropped is gone afterwards.
export function dropped({ items, files }) {
  const entries = [...(items ?? [])].map((item) => item.webkitGetAsEntry?.()).filter(Boolean);
  if (!entries.length) return Promise.resolve(chosen(files));
  return Promise.all(entries.map((entry) => inside(entry, ''))).then((lists) => lists.flat());
}

async function inside(entry, folder) {
  const name = folder + entry.name;
  if (entry.isFile) {
    const file = await new Promise((resolve, reject) => entry.file(resolve, reject));
    return [{ name, file }];
  }
  const reader = entry.createReader();
  const found = [];
  // A reader gives some at a time, and none in the end.
  for (;;) {
    const some = await new Promise((resolve, reject) => reader.readEntries(resolve, reject));
    if (!some.length) break;
    found.push(...(await Promise.all(some.map((each) => inside(each, `${name}/`)))).flat());
  }
  return found;
}

// A file from a URL.
export async function fetched(url, signal) {
  const answer = await fetch(url, { signal });
  if (!answer.ok) throw new Error(`${url}: ${answer.status} ${answer.statusText}`);
  const name = new URL(url, location.href).pathname.split('/').pop() || 'scene.vxd';
  return [{ name, file: await answer.blob() }];
}

// What files are called that could not be opened; of others, the module says which one it has built.
export const title = (files) =>
  (files.find(({ name }) => /\.vxd$/i.test(name)) ?? files.find(({ name }) => /\.obj$/i.test(name)) ?? files[0])
    ?.name.split('/').pop() ?? '';

// Names and bytes, as a worker takes them.
export async function read(files) {
  const useful = files.filter(({ name }) => /\.(vxd|obj|mtl|png|jpe?g|bmp|gif|tga|webp|avif)$/i.test(name));
  const list = useful.length ? useful : files;
  return Promise.all(list.map(async ({ name, file }) => ({ name, bytes: new Uint8Array(await file.arrayBuffer()) })));
}
