import { cleanup, configure } from '@testing-library/react';
import { afterEach, beforeEach, expect, vi, type MockInstance } from 'vitest';
import { speakWith } from '../src/i18n';
import { words } from '../src/i18n/en';

// uPlot asks for it as soon as it is imported; jsdom has none.
window.matchMedia ??= (() => ({
  matches: false,
  addEventListener: () => undefined,
  removeEventListener: () => undefined,
})) as unknown as typeof window.matchMedia;

// Charts measure their place; jsdom lays nothing out.
window.ResizeObserver ??= class {
  observe() {}
  unobserve() {}
  disconnect() {}
};

// A text area that grows asks for it; jsdom has none.
if (!('fonts' in document)) Object.defineProperty(document, 'fonts', { value: new EventTarget() });

// Pages ask once whether 3D can be drawn; jsdom draws nothing, and most tests are of browsers that can.
const contextOf = HTMLCanvasElement.prototype.getContext;
HTMLCanvasElement.prototype.getContext = function (this: HTMLCanvasElement, kind: string) {
  return kind === 'webgl2' ? { getExtension: () => null } : contextOf.call(this, kind as '2d');
} as never;

// Pages are drawn once their words have come.
speakWith('en', words);

// On a machine that is busy with something else what is waited for comes late; one that never comes still fails.
const PATIENCE_MS = 10_000;
configure({ asyncUtilTimeout: PATIENCE_MS });
const waitFor = vi.waitFor.bind(vi);
vi.waitFor = (callback, options) => waitFor(callback, options ?? { timeout: PATIENCE_MS });

// React says it and goes on, with parts of an earlier page left on the screen.
let complaints: MockInstance<typeof console.error>;
beforeEach(() => {
  complaints = vi.spyOn(console, 'error');
});

afterEach(() => {
  cleanup();
  const said = complaints.mock.calls.map((one) => one.map(String).join(' '));
  expect(said.filter((one) => one.includes('two children with the same key'))).toEqual([]);
});
