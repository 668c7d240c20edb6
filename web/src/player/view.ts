// The socket that steers a 3D view: what changes goes at once, and once a second while playing, so both stay together.
import { socketUrl } from '../api/client';
import type { CameraCommand, ErrorMessage, PlayerCommand, PlayerState, Pulse } from '../api/types';
import { CONNECTING, ReturningSocket, type ReturningSocketOptions, type SocketState } from './socket';
import { inOurWords } from '../i18n/sentence';
import { SnapshotStore, type Player } from './types';

const TOGETHER_MS = 1000;

export interface GhostChoice {
  ghost: boolean;
  warp: boolean;
}

export interface ViewSnapshot extends SocketState {
  /** What it could not do, in words. */
  problem: string;
  /** What the scene says it shows. */
  shown: PlayerState | null;
  /** How often the view was connected to. */
  connections: number;
}

export const NO_VIEW: ViewSnapshot = { ...CONNECTING, problem: '', shown: null, connections: 0 };

export class ViewLink {
  readonly #player: Player | null;
  readonly #socket: ReturningSocket;
  readonly #store = new SnapshotStore<ViewSnapshot>(NO_VIEW);
  readonly #stop: () => void;
  readonly #timer: ReturnType<typeof setInterval> | undefined;
  #ghost: GhostChoice = { ghost: true, warp: true };
  #theme: CameraCommand['theme'] = 'light';
  #sent = '';

  /** A live view steers itself: it takes no player, only the camera. */
  constructor(
    controlPath: string,
    player: Player | null,
    options: Pick<ReturningSocketOptions, 'create' | 'answers'> = {},
  ) {
    this.#player = player;
    this.#socket = new ReturningSocket({
      url: socketUrl(controlPath),
      ...options,
      onState: (state) => this.#store.set(state.status === 'open' ? state : { ...state, problem: '' }),
      onOpen: () => {
        this.#store.set({ connections: this.#store.get().connections + 1 });
        this.#sendPlayer(true);
        this.camera({});
      },
      onText: (text) => this.#take(text),
    });
    this.#stop = player?.subscribe(() => this.#sendPlayer(false)) ?? (() => undefined);
    if (player) {
      this.#timer = setInterval(() => {
        if (player.clock().isPlaying) this.#sendPlayer(true);
      }, TOGETHER_MS);
    }
  }

  getSnapshot = () => this.#store.get();
  subscribe = this.#store.subscribe;

  setGhost(choice: GhostChoice): void {
    this.#ghost = choice;
    this.#sendPlayer(false);
  }

  setTheme(theme: 'light' | 'dark'): void {
    this.#theme = theme;
    this.camera({});
  }

  camera(move: Omit<Partial<CameraCommand>, 'type' | 'theme'>): void {
    this.#socket.send({ type: 'camera', theme: this.#theme, ...move } satisfies CameraCommand);
  }

  close(): void {
    clearInterval(this.#timer);
    this.#stop();
    this.#socket.close();
  }

  /** Unless it is due anyway, a command that says nothing new is not sent. */
  #sendPlayer(isDue: boolean): void {
    if (!this.#player) return;
    const { timeS, isPlaying, speed } = this.#player.clock();
    const command: PlayerCommand = { type: 'player', time_s: timeS, playing: isPlaying, speed, ...this.#ghost };
    const sign = JSON.stringify(isPlaying ? { ...command, time_s: this.#player.getSnapshot().epoch } : command);
    if (!isDue && sign === this.#sent) return;
    this.#sent = sign;
    this.#socket.send(command);
  }

  #take(text: string): void {
    const message = inOurWords(JSON.parse(text) as PlayerState | ErrorMessage | Pulse);
    if (message.type === 'player_state') this.#store.set({ shown: message, problem: '' });
    else if (message.type === 'error') {
      if (message.closing) this.#socket.refuse(message.message);
      else this.#store.set({ problem: message.message });
    }
  }
}
