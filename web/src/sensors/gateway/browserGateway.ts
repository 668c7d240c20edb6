// The page's handle on its gateway: one a session, whatever page of the session is shown.
import { ofSession } from '../../api/address';
import { api, ApiError, socketUrl } from '../../api/client';
import { words } from '../../i18n/sentence';
import type { Sample } from './grid';
import type { FromWorker, ToWorker } from './messages';
import type { RecorderState } from './recorder';
import { heldStoreKey } from './seal';
import type { StoredNetwork } from './store';

const PATH = '/ws/ingest';
/** Said of a session that had ended until it was asked to take more. */
const REOPENED = 'live.reopened';

export interface GatewaySnapshot {
  recorder: RecorderState | null;
  /** Why this browser cannot store at all. */
  broken: string;
}

/** The state with the service's words in the reader's language, which the worker does not know. */
function inOurWords(state: RecorderState): RecorderState {
  const { link } = state;
  return { ...state, link: { ...link, reason: words(link.reason, link.sentence) } };
}

export class BrowserGateway {
  readonly network: StoredNetwork;
  /** The session had ended, and takes packets again for this gateway: who is done with it closes it. */
  hasReopened = false;
  readonly #isLate: boolean;
  readonly #worker: Worker;
  readonly #listeners = new Set<() => void>();
  #snapshot: GatewaySnapshot = { recorder: null, broken: '' };

  /** `isLate`: for what an earlier window has left, whose session may have ended since. */
  constructor(network: StoredNetwork, { isLate = false } = {}) {
    this.network = network;
    this.#isLate = isLate;
    this.#worker = new Worker(new URL('./gateway.worker.ts', import.meta.url), { type: 'module' });
    this.#worker.onmessage = (event: MessageEvent<FromWorker>) => this.#take(event.data);
    this.#worker.onerror = (event) => this.#say({ broken: event.message || 'worker' });
    this.#post({ type: 'begin', network, url: socketUrl(PATH), key: heldStoreKey() });
    addEventListener('pagehide', this.#flush);
    document.addEventListener('visibilitychange', this.#flush);
  }

  /** `timeMs` as events stamp it: since the page was opened. */
  add(sensor: number, timeMs: number, sample: Sample): void {
    // Counted from 1970 it runs on when the page is opened again.
    this.#post({ type: 'sample', sensor, timeMs: performance.timeOrigin + timeMs, sample });
  }

  leave(sensor: number): void {
    this.#post({ type: 'leave', sensor });
  }

  finish(isGoodbye: boolean): void {
    this.#post({ type: 'finish', isGoodbye });
  }

  close(): void {
    removeEventListener('pagehide', this.#flush);
    document.removeEventListener('visibilitychange', this.#flush);
    this.#post({ type: 'close' });
  }

  subscribe = (listener: () => void): (() => void) => {
    this.#listeners.add(listener);
    return () => this.#listeners.delete(listener);
  };

  getSnapshot = (): GatewaySnapshot => this.#snapshot;

  readonly #flush = () => this.#post({ type: 'flush' });

  #post(message: ToWorker): void {
    this.#worker.postMessage(message);
  }

  #say(change: Partial<GatewaySnapshot>): void {
    this.#snapshot = { ...this.#snapshot, ...change };
    for (const listener of this.#listeners) listener();
  }

  #take(message: FromWorker): void {
    if (message.type === 'state') this.#say({ recorder: inOurWords(message.state) });
    else if (message.type === 'broken') this.#say({ broken: message.reason });
    else void this.#ticket(message.number);
  }

  async #ticket(number: number): Promise<void> {
    try {
      const of = ofSession(this.network.sessionId);
      if (this.#isLate) {
        const { sentences } = await api.post('/api/sessions/{session_id}/reopen', of);
        this.hasReopened ||= [sentences?.reason].flat().some((one) => typeof one === 'object' && one.code === REOPENED);
      }
      const { ticket } = await api.post('/api/sessions/{session_id}/ticket', {
        ...of,
        body: { purpose: 'ingest' },
      });
      this.#post({ type: 'ticket', number, ticket });
    } catch (error) {
      const refusal =
        error instanceof ApiError ? { code: error.code, reason: error.message } : { code: '', reason: String(error) };
      this.#post({ type: 'noTicket', number, refusal });
    }
  }
}
