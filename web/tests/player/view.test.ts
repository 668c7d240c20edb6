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
  link = new ViewLink('/ws/views/v', player, { create: FakeSocket.create, answers: () => Promise.resolve(true) });
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

it('says how often it was connected to, so that the frame beside it begins anew', () => {
  const state = { type: 'player_state', mode: 'replay', playing: false };
  FakeSocket.last.say(state);
  expect(link.getSnapshot()).toMatchObject({ status: 'open', connections: 1 });
  FakeSocket.last.drop();
  expect(link.getSnapshot()).toMatchObject({ status: 'lost', connections: 1 });
  vi.advanceTimersByTime(600);
  FakeSocket.last.accept();
  FakeSocket.last.say(state);
  expect(link.getSnapshot()).toMatchObject({ status: 'open', connections: 2, lostSinceS: null });
});

it('is lost when the pulse stops, although nothing closed', () => {
  FakeSocket.last.say({ type: 'pulse' });
  vi.advanceTimersByTime(2000);
  FakeSocket.last.say({ type: 'pulse' });
  expect(link.getSnapshot().status).toBe('open');
  vi.advanceTimersByTime(3000);
  expect(link.getSnapshot().status).toBe('lost');
});

it('takes the words of a service that does not know the view any more', () => {
  FakeSocket.last.say({ type: 'error', code: 'not_found', message: 'There is no such view.', closing: true });
  expect(link.getSnapshot()).toMatchObject({ status: 'refused', reason: 'There is no such view.' });
});
