import { afterEach, beforeEach, expect, it, vi } from 'vitest';
import type { PlayerCommand } from '../../src/api/types';
import { SnapshotStore, type Player, type PlayerSnapshot } from '../../src/player/types';
import { ViewLink } from '../../src/player/view';
import { FakeSocket } from './fixtures';

const clock = { timeS: 0, startS: 0, endS: 10, isPlaying: false, speed: 1 };
const store = new SnapshotStore<PlayerSnapshot>({
  connection: 'open',
  problem: null,
  capabilities: { isLive: false, canSeek: true, canChangeSpeed: true },
  columns: null,
  isPlaying: false,
  speed: 1,
  epoch: 0,
});
const player = { subscribe: store.subscribe, getSnapshot: store.get, clock: () => clock } as unknown as Player;
let link: ViewLink;
const commands = () =>
  FakeSocket.last.sent.map((text) => JSON.parse(text) as PlayerCommand).filter((command) => command.type === 'player');

beforeEach(() => {
  vi.useFakeTimers();
  vi.stubGlobal('WebSocket', { OPEN: 1 });
  Object.assign(clock, { timeS: 0, isPlaying: false, speed: 1 });
  link = new ViewLink('/ws/views/v', player, FakeSocket.create);
  FakeSocket.last.accept();
});
afterEach(() => {
  link.close();
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

it('says where it stands on connecting', () => {
  expect(commands()).toEqual([{ type: 'player', time_s: 0, playing: false, speed: 1, ghost: true, warp: true }]);
});

it('sends a seek at once and nothing that says nothing new', () => {
  clock.timeS = 4.2;
  store.set({ epoch: store.get().epoch + 1 });
  store.set({ epoch: store.get().epoch + 1 });
  expect(commands().map((command) => command.time_s)).toEqual([0, 4.2]);
});

it('stays together once a second while playing', () => {
  clock.isPlaying = true;
  vi.advanceTimersByTime(3100);
  expect(commands()).toHaveLength(4);
  clock.isPlaying = false;
  vi.advanceTimersByTime(5000);
  expect(commands()).toHaveLength(4);
});

it('passes on the choice of the ghost', () => {
  link.setGhost({ ghost: true, warp: false });
  expect(commands().at(-1)).toMatchObject({ ghost: true, warp: false });
});
