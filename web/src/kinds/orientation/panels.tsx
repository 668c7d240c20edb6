// Single sensors: what is known of them is in the details and in the files of the result.
import type { KindPanels } from '../kind';

export const panels: KindPanels = { live: {}, replay: { Actions: () => null } };
