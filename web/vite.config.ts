import react from '@vitejs/plugin-react';
import { defineConfig } from 'vitest/config';

const service = process.env.TELEMOTION_SERVICE ?? 'http://127.0.0.1:8000';

export default defineConfig({
  plugins: [react()],
  build: {
    // The content security policy allows files of our own origin only: nothing may be inlined as data.
    assetsInlineLimit: 0,
    modulePreload: { polyfill: false },
    target: 'es2022',
    chunkSizeWarningLimit: 900,
  },
  worker: { format: 'es' },
  server: {
    proxy: Object.fromEntries(
      ['/api', '/ws', '/viewer'].map((path) => [path, { target: service, ws: true }]),
    ),
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
