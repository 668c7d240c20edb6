import { readdir, readFile, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { brotliCompressSync, gzipSync } from 'node:zlib';
import react from '@vitejs/plugin-react';
import type { Plugin } from 'vite';
import { defineConfig } from 'vitest/config';
import { shell } from './scripts/shell';

const service = process.env.TELEMOTION_SERVICE ?? 'http://127.0.0.1:8000';

/** Write each file that packs well a second and third time, packed: the service sends those. */
function packed(): Plugin {
  return {
    name: 'packed',
    apply: 'build',
    enforce: 'post',
    async closeBundle() {
      const names = await readdir('dist', { recursive: true, withFileTypes: true });
      for (const one of names.filter(
        (entry) =>
          entry.isFile() && !entry.parentPath.includes('.vite') && /\.(js|css|html|svg|json)$/.test(entry.name),
      )) {
        const path = join(one.parentPath, one.name);
        const content = await readFile(path);
        if (content.length < 1000) continue;
        await writeFile(`${path}.gz`, gzipSync(content, { level: 9 }));
        await writeFile(`${path}.br`, brotliCompressSync(content));
      }
    },
  };
}

/** What changes with each version apart from what stays: a new version then asks for little. */
const LIBRARIES: readonly [string, RegExp][] = [['react', /node_modules\/(react|react-dom|react-router|scheduler)\//]];

export default defineConfig({
  plugins: [react(), shell(), packed()],
  build: {
    // The content security policy allows files of our own origin only: nothing may be inlined as data.
    assetsInlineLimit: 0,
    modulePreload: { polyfill: false },
    // Which files each page loads; the budget of script is counted with it.
    manifest: true,
    target: 'es2022',
    chunkSizeWarningLimit: 400,
    rollupOptions: { output: { manualChunks: (id) => LIBRARIES.find(([, pattern]) => pattern.test(id))?.[0] } },
  },
  worker: { format: 'es' },
  server: {
    // The sentences of the service stand beside this folder.
    fs: { allow: ['.', '../messages'] },
    proxy: Object.fromEntries(['/api', '/ws', '/viewer'].map((path) => [path, { target: service, ws: true }])),
  },
  test: {
    environment: 'jsdom',
    include: ['tests/**/*.test.{ts,tsx}'],
    setupFiles: ['tests/setup.ts'],
    restoreMocks: true,
    // On a machine that is busy with something else a test may wait long for its turn.
    testTimeout: 20_000,
  },
});
