// What a page and its gateway's worker say to each other.
import type { Sample } from './grid';
import type { Refusal } from './link';
import type { RecorderState } from './recorder';
import type { StoredNetwork } from './store';

export type ToWorker =
  | { type: 'begin'; network: StoredNetwork; url: string; key: string }
  | { type: 'sample'; sensor: number; timeMs: number; sample: Sample }
  | { type: 'leave'; sensor: number }
  | { type: 'flush' }
  | { type: 'finish'; isGoodbye: boolean }
  | { type: 'close' }
  | { type: 'ticket'; number: number; ticket: string }
  | { type: 'noTicket'; number: number; refusal: Refusal };

export type FromWorker =
  { type: 'state'; state: RecorderState } | { type: 'ticket'; number: number } | { type: 'broken'; reason: string };
