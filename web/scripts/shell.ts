// Writes the service worker of the build: which files a patient's pages need without a link.
import { createHash } from 'node:crypto';
import { readFile } from 'node:fs/promises';
import type { Plugin, Rollup } from 'vite';

/** Pages that are wanted where there is no link, and the words of every language; others are fetched when they are opened. */
const WANTED = /\/src\/(pages\/mine|sensors|i18n\/[a-z]{2})\/|\/ConfirmDialog\.tsx$/;
const WANTED_ASSETS = /worker.*\.js$|latin-wght-normal.*\.woff2$/;
const ALWAYS = ['/', '/mark.svg', '/manifest.webmanifest'];

/** The pieces that are loaded with these, and those of the patient's pages. */
function shellFiles(bundle: Rollup.OutputBundle): string[] {
  const files = new Set<string>();
  const add = (name: string) => {
    const piece = bundle[name];
    if (!piece || files.has(name)) return;
    files.add(name);
    if (piece.type !== 'chunk') return;
    piece.viteMetadata?.importedCss.forEach((sheet) => files.add(sheet));
    piece.imports.forEach(add);
    for (const later of piece.dynamicImports) {
      const found = bundle[later];
      if (found?.type === 'chunk' && WANTED.test(found.facadeModuleId ?? '')) add(later);
    }
  };
  for (const piece of Object.values(bundle)) {
    if (piece.type === 'chunk' ? piece.isEntry : WANTED_ASSETS.test(piece.fileName)) add(piece.fileName);
  }
  return [...files].filter((name) => name.startsWith('assets/')).sort();
}

export function shell(): Plugin {
  return {
    name: 'shell',
    apply: 'build',
    enforce: 'post',
    async generateBundle(_, bundle) {
      const files = shellFiles(bundle);
      const source = await readFile(new URL('./shell-worker.js', import.meta.url), 'utf8');
      const version = createHash('sha256').update(files.join()).digest('hex').slice(0, 12);
      const list = JSON.stringify([...ALWAYS, ...files.map((name) => `/${name}`)]);
      this.emitFile({
        type: 'asset',
        fileName: 'sw.js',
        source: source.replace('__VERSION__', version).replace('__FILES__', list),
      });
    },
  };
}
