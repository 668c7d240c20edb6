import { cleanup } from '@testing-library/react';
import { afterEach } from 'vitest';

// uPlot asks for it as soon as it is imported; jsdom has none.
window.matchMedia ??= (() => ({ matches: false, addEventListener: () => undefined, removeEventListener: () => undefined })) as unknown as typeof window.matchMedia;

afterEach(cleanup);
