import { cleanup } from '@testing-library/react';
import { afterEach } from 'vitest';
import { speakWith } from '../src/i18n';
import { words } from '../src/i18n/en';

// uPlot asks for it as soon as it is imported; jsdom has none.
window.matchMedia ??= (() => ({
  matches: false,
  addEventListener: () => undefined,
  removeEventListener: () => undefined,
})) as unknown as typeof window.matchMedia;

// A text area that grows asks for it; jsdom has none.
if (!('fonts' in document)) Object.defineProperty(document, 'fonts', { value: new EventTarget() });

// Pages are drawn once their words have come.
speakWith('en', words);

afterEach(cleanup);
