import { execFileSync } from 'node:child_process';
import { expect, it } from 'vitest';

it('has wire types as young as the service', () => {
  // Where the service's Python is at hand this dumps its types anew; elsewhere it checks what was made from the stored document.
  expect(() => execFileSync(process.execPath, ['scripts/generate-types.mjs', '--check'], { stdio: 'pipe' })).not.toThrow();
}, 180_000);
