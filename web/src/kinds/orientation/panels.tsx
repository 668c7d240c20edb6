// Single sensors: what is known of them is in the details and in the files of the result.
import type { KindParts } from '../kind';

export const parts: KindParts = { live: {}, replay: { Actions: () => null } };
