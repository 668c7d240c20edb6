// A session while it happens: socket in, ring of frames, state, health and events out.
import { PROTOCOL_VERSION } from '../api/schema';
import type {
  CalibrationMessage,
  ErrorMessage,
  GuidanceMessage,
  HealthMessage,
  LiveMessage,
  SessionEvent,
  SessionState,
  StateMessage,
} from '../api/types';
import { t } from '../i18n';
import { createDecoder, type Decoder } from './decoder';
import { LatencyMeter } from './latency';
import { FrameRing } from './ring';
import { REACH_S } from './reach';
import { CONNECTING, ReturningSocket, type ReturningSocketOptions, type SocketState } from './socket';
import { inOurWords } from '../i18n/sentence';
import { columnsOf, SnapshotStore, type Clock, type Player, type PlayerSnapshot, type Stretch } from './types';

/** Frames held for the running curves. */
export const HELD_S = 60;
const KEPT_EVENTS = 200;
/** Frames come twenty times a second: after so long without one, no number on the page is of now. */
export const FRESH_S = 1.5;
/** Who spoke no longer than this after the last frame fell silent with the frames: the sensors are not to blame. */
const TOGETHER_S = 0.25;
/** A session whose sensors are connected is spoken of once a second. */
const ATTENDED: readonly SessionState[] = ['calibrating', 'ready', 'recording'];
const WATCH_MS = 250;
/** Phases come twenty times a second while something moves: what lies further apart is not joined. */
const PHASE_GAP_S = 0.5;
/** A phase that goes back by less is the same repetition, known better. */
const BACK = 0.1;
const EMPTY: Stretch = { timeS: new Float64Array(0), values: [], isComplete: false };

export interface LiveSnapshot extends PlayerSnapshot {
  state: StateMessage | null;
  health: HealthMessage | null;
  events: readonly SessionEvent[];
  /** The guided calibration that runs, or the last one that ran. */
  calibration: CalibrationMessage | null;
  /** How the patient follows the template, as it was when anything but the phase last changed. */
  guidance: GuidanceMessage | null;
  /** The last error message of the service on this socket. */
  error: ErrorMessage | null;
  /** From publication by the service to arrival here, ms. */
  networkMs: number | null;
  /** When the last frame came, s since the epoch, while none comes any more; null while they come. */
  silentSinceS: number | null;
  /** When the service was last heard, s since the epoch, while it is out of reach. */
  lostSinceS: number | null;
  /** The service answers over HTTP, and the network between refuses the socket. */
  isBlocked: boolean;
}

export interface LivePlayerOptions {
  url: string;
  decoder?: Decoder;
  create?: ReturningSocketOptions['create'];
  answers?: ReturningSocketOptions['answers'];
  now?: () => number;
}

export class LivePlayer implements Player {
  readonly #store = new SnapshotStore<LiveSnapshot>({
    connection: 'connecting',
    problem: null,
    capabilities: { isLive: true, canSeek: false, canChangeSpeed: false },
    columns: null,
    isPlaying: true,
    speed: 1,
    epoch: 0,
    state: null,
    health: null,
    events: [],
    calibration: null,
    guidance: null,
    error: null,
    networkMs: null,
    silentSinceS: null,
    lostSinceS: null,
    isBlocked: false,
  });
  readonly #decoder: Decoder;
  readonly #socket: ReturningSocket;
  readonly #latency: LatencyMeter;
  #ring: FrameRing | null = null;
  /** Where along the template the patient was, oldest first, as long as the frames are held; null at rest. */
  #phases: { timeS: number; phase: number | null }[] = [];
  /** Session time at which the picture was paused; frames go on being collected. */
  #pausedAtS: number | null = null;
  #lastFrameS: number | null = null;
  /** When the session's health was last said over this connection, or when it was opened. */
  #attendedS = 0;
  #link: SocketState = CONNECTING;
  readonly #watch: ReturnType<typeof setInterval>;

  constructor(options: LivePlayerOptions) {
    this.#decoder = options.decoder ?? createDecoder();
    this.#latency = new LatencyMeter(options.now);
    this.#socket = new ReturningSocket({
      url: options.url,
      create: options.create,
      answers: options.answers,
      now: options.now,
      onState: (link) => {
        this.#link = link;
        this.#judge();
      },
      onOpen: () => this.#beginAnew(),
      onText: (text) => this.#takeText(text),
      onBinary: (buffer) => void this.#takeFrames(buffer),
    });
    this.#watch = setInterval(() => this.#look(), WATCH_MS);
  }

  getSnapshot = () => this.#store.get();
  subscribe = this.#store.subscribe;

  clock(): Clock {
    const ring = this.#ring;
    const endS = ring && ring.count ? ring.lastS : 0;
    // In silence time goes on: curves move out of the picture, and nothing old stands at "now".
    const silentS = this.#store.get().silentSinceS === null ? 0 : this.#latency.now() - (this.#lastFrameS ?? 0);
    return {
      timeS: this.#pausedAtS ?? endS + silentS,
      startS: ring && ring.count ? ring.firstS : 0,
      endS,
      isPlaying: this.#pausedAtS === null,
      speed: 1,
    };
  }

  read(startS: number, endS: number, columns: readonly string[]): Stretch {
    return this.#ring?.read(startS, endS, columns) ?? EMPTY;
  }

  /** Where along the template the patient was at a session time, 0 to 100; null at rest and where it is not known. */
  templatePhaseAt(timeS: number): number | null {
    // Asked for every sample of every curve: halved, not walked through.
    let [before, after] = [-1, this.#phases.length];
    while (after - before > 1) {
      const middle = (before + after) >> 1;
      if ((this.#phases[middle]?.timeS ?? Infinity) < timeS) before = middle;
      else after = middle;
    }
    const [low, high] = [this.#phases[before], this.#phases[after]];
    if (low?.phase == null || high?.phase == null || high.timeS - low.timeS > PHASE_GAP_S) return null;
    // A new repetition begins at the beginning: no line leads back to it.
    if (high.phase < low.phase - BACK) return null;
    const share = (timeS - low.timeS) / (high.timeS - low.timeS || 1);
    return 100 * (low.phase + share * (high.phase - low.phase));
  }

  play(): void {
    this.#pausedAtS = null;
    this.#store.set({ isPlaying: true });
  }

  /** Hold the picture; the session goes on. */
  pause(): void {
    this.#pausedAtS = this.clock().endS;
    this.#store.set({ isPlaying: false });
  }

  seek(): void {}
  setSpeed(): void {}

  close(): void {
    clearInterval(this.#watch);
    this.#socket.close();
    this.#decoder.close();
  }

  /** What was said over another connection is not of now: a service that was started again knows nothing of it. */
  #beginAnew(): void {
    this.#attendedS = this.#latency.now();
    this.#store.set({ health: null, calibration: null, error: null });
  }

  /** What did not come cannot call: look for it. */
  #look(): void {
    const nowS = this.#latency.now();
    const isSilent = this.#lastFrameS !== null && nowS - this.#lastFrameS > FRESH_S;
    this.#store.set({ silentSinceS: isSilent ? this.#lastFrameS : null });
    // Frames and words that end at the same moment: it is the service or the way to it, and no sensor.
    if (isSilent && this.#socket.isOpen && !this.#isOver && this.#socket.heardS - (this.#lastFrameS ?? 0) < TOGETHER_S)
      this.#socket.doubt();
    this.#judge();
  }

  get #isOver(): boolean {
    const { state } = this.#store.get();
    return state !== null && ['closing', 'analysed', 'failed'].includes(state.state);
  }

  /** Whether the service is in reach: the socket tells, and for a session with sensors its health besides. */
  #judge(): void {
    const { state, problem } = this.#store.get();
    const nowS = this.#latency.now();
    const { status, reason, lostSinceS, isBlocked } = this.#link;
    const isAttended = Math.max(this.#attendedS, this.#lastFrameS ?? 0) > nowS - REACH_S;
    const isMissed = status === 'open' && state !== null && ATTENDED.includes(state.state) && !isAttended;
    this.#store.set({
      connection: isMissed ? 'lost' : status,
      problem: status === 'open' ? null : reason || problem,
      lostSinceS: isMissed ? (this.#store.get().lostSinceS ?? this.#attendedS) : lostSinceS,
      isBlocked,
    });
  }

  #takeText(text: string): void {
    let message: LiveMessage;
    try {
      message = inOurWords(JSON.parse(text) as LiveMessage);
    } catch {
      this.#socket.refuse(t('player.notUnderstood'));
      return;
    }
    switch (message.type) {
      case 'layout':
        if (message.protocol_version !== PROTOCOL_VERSION) {
          this.#socket.refuse(
            t('player.otherVersion', { ours: PROTOCOL_VERSION, theirs: message.protocol_version ?? '?' }),
          );
          return;
        }
        this.#forget(new FrameRing(columnsOf(message), HELD_S));
        this.#store.set({ columns: columnsOf(message) });
        break;
      case 'state':
        this.#store.set({ state: message });
        break;
      case 'health':
        this.#attendedS = this.#latency.now();
        this.#store.set({ health: message, networkMs: this.#latency.read() });
        this.#judge();
        break;
      case 'event':
        this.#store.set({ events: [...this.#store.get().events, message.event].slice(-KEPT_EVENTS) });
        break;
      case 'calibration':
        this.#store.set({ calibration: message });
        break;
      case 'guidance':
        this.#takeGuidance(message);
        break;
      case 'error':
        this.#store.set({ error: message });
        if (message.closing) this.#socket.refuse(message.message);
        break;
    }
  }

  /** The phase comes twenty times a second: only the 3D view draws it, no page need be drawn anew. */
  #takeGuidance(message: GuidanceMessage): void {
    const sign = (one: GuidanceMessage | null) =>
      one && JSON.stringify([one.status, one.cause, one.counts, one.goal, one.last, one.cue, one.cue_number]);
    if (sign(message) !== sign(this.#store.get().guidance)) this.#store.set({ guidance: message });
    const last = this.#phases.at(-1);
    if (last && message.time_s < last.timeS) this.#phases = this.#phases.filter((one) => one.timeS < message.time_s);
    if (last?.timeS !== message.time_s) this.#phases.push({ timeS: message.time_s, phase: message.phase ?? null });
    const first = this.#phases.findIndex((one) => one.timeS >= message.time_s - HELD_S);
    if (first > 0) this.#phases.splice(0, first);
  }

  #forget(ring: FrameRing): void {
    this.#ring = ring;
    this.#phases = [];
    this.#pausedAtS = null;
    this.#store.set({ epoch: this.#store.get().epoch + 1, isPlaying: true });
  }

  async #takeFrames(buffer: ArrayBuffer): Promise<void> {
    const arrivedAt = this.#latency.now();
    const ring = this.#ring;
    if (!ring) return;
    try {
      const block = await this.#decoder.decode(buffer);
      if (ring !== this.#ring) return;
      this.#lastFrameS = arrivedAt;
      this.#store.set({ silentSinceS: null });
      this.#latency.add(arrivedAt, block.publishedS);
      // A session that was restarted begins again at an earlier time: forget what is held.
      if (ring.count && block.startS + block.ticks * block.stepS < ring.lastS - 2) {
        ring.clear();
        this.#store.set({ epoch: this.#store.get().epoch + 1 });
      }
      ring.push(block);
    } catch (error) {
      if (this.#store.get().connection !== 'closed')
        this.#socket.refuse(error instanceof Error ? error.message : String(error));
    }
  }
}
