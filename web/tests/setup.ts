import { cleanup } from '@testing-library/react';
import { afterEach } from 'vitest';

// uPlot asks for it as soon as it is imported; jsdom has none.
window.matchMedia ??= (() => ({
  matches: false,
  addEventListener: () => undefined,
  removeEventListener: () => undefined,
})) as unknown as typeof window.matchMedia;

// A text area that grows asks for it; jsdom has none.
if (!('fonts' in document)) Object.defineProperty(document, 'fonts', { value: new EventTarget() });

afterEach(cleanup);
