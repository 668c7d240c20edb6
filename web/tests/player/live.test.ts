import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { InlineDecoder } from '../../src/player/decoder';
import { LivePlayer } from '../../src/player/live';
import { backOffMs } from '../../src/player/socket';
import { FakeSocket, layoutMessage, packBlock, settle } from './fixtures';

let player: LivePlayer;
let nowS = 1000;
/** Whether the service answers over HTTP. */
let answers = true;

beforeEach(() => {
  answers = true;
  vi.useFakeTimers();
  vi.stubGlobal('WebSocket', { OPEN: 1 });
  FakeSocket.made.length = 0;
  nowS = 1000;
  player = new LivePlayer({
    url: 'ws://test/ws/live/s',
    decoder: new InlineDecoder(),
    create: FakeSocket.create,
    answers: () => Promise.resolve(answers),
    now: () => nowS,
  });
});
afterEach(() => {
  player.close();
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

const wait = (seconds: number) => {
  for (let quarter = 0; quarter < 4 * seconds; quarter += 1) {
    nowS += 0.25;
    vi.advanceTimersByTime(250);
  }
};
/** As `wait`, with all that was promised meanwhile. */
const pass = async (seconds: number) => {
  for (let quarter = 0; quarter < 4 * seconds; quarter += 1) {
    nowS += 0.25;
    await vi.advanceTimersByTimeAsync(250);
  }
};
const health = {
  type: 'health',
  sensors: [],
  packets_stored: 1,
  packets_missing: 0,
  latency_ms_median: 5,
  latency_ms_p99: 9,
  clock_skew_ppm: null,
};
const stateMessage = (state: string) => ({
  type: 'state',
  state,
  reason: '',
  session_time_s: 3,
  recording_start_s: 1,
  calibration: null,
  calibration_progress: null,
});
const begin = async () => {
  FakeSocket.last.accept();
  FakeSocket.last.say(layoutMessage());
  FakeSocket.last.say(health);
  await send(0, 50);
};

const send = async (firstTick: number, ticks: number, publishedS = 1000) => {
  FakeSocket.last.say(packBlock({ ticks, columns: 3, firstTick, publishedS }));
  await settle();
};

describe('LivePlayer', () => {
  it('follows the newest frame', async () => {
    FakeSocket.last.accept();
    FakeSocket.last.say(layoutMessage());
    await send(0, 50);
    expect(player.getSnapshot().connection).toBe('open');
    expect(player.clock().timeS).toBeCloseTo(0.49);
    expect(player.read(0, 1, ['elbow']).timeS).toHaveLength(50);
  });

  it('holds the picture while paused and collects on', async () => {
    FakeSocket.last.accept();
    FakeSocket.last.say(layoutMessage());
    await send(0, 50);
    player.pause();
    await send(50, 50);
    expect(player.clock()).toMatchObject({ isPlaying: false });
    expect(player.clock().timeS).toBeCloseTo(0.49);
    expect(player.clock().endS).toBeCloseTo(0.99);
    player.play();
    expect(player.clock().timeS).toBeCloseTo(0.99);
  });

  it('forgets what it holds when the layout comes again', async () => {
    FakeSocket.last.accept();
    FakeSocket.last.say(layoutMessage());
    await send(0, 50);
    const { epoch } = player.getSnapshot();
    FakeSocket.last.say(layoutMessage());
    expect(player.getSnapshot().epoch).toBeGreaterThan(epoch);
    expect(player.read(0, 10, ['elbow']).timeS).toHaveLength(0);
  });

  it('knows where along the template the patient was, and nothing where it does not know it', () => {
    FakeSocket.last.accept();
    FakeSocket.last.say(layoutMessage());
    const counts = { valid: 0, partial: 0, wrong: 0 };
    const say = (time_s: number, phase: number | null) =>
      FakeSocket.last.say({ type: 'guidance', status: 'moving', time_s, phase, counts });
    expect(player.templatePhaseAt(1)).toBeNull();
    say(1.0, null);
    say(1.1, 0.2);
    say(1.2, 0.4);
    say(1.3, 0.05);
    say(2.3, 0.5);
    say(2.4, 0.6);
    expect(player.templatePhaseAt(1.05)).toBeNull();
    expect(player.templatePhaseAt(1.15)).toBeCloseTo(30);
    expect(player.templatePhaseAt(1.2)).toBeCloseTo(40);
    expect(player.templatePhaseAt(1.25)).toBeNull();
    expect(player.templatePhaseAt(1.8)).toBeNull();
    expect(player.templatePhaseAt(2.375)).toBeCloseTo(57.5);
    expect(player.templatePhaseAt(3)).toBeNull();
    // A service that was restarted speaks of an earlier time again.
    say(1.15, 0.5);
    say(1.25, 0.7);
    expect(player.templatePhaseAt(1.2)).toBeCloseTo(60);
    expect(player.templatePhaseAt(2.375)).toBeNull();
    say(70, 0.1);
    expect(player.templatePhaseAt(1.2)).toBeNull();
  });

  it('refuses another protocol version in words and does not try again', () => {
    FakeSocket.last.accept();
    FakeSocket.last.say(layoutMessage({ protocol_version: 99 }));
    expect(player.getSnapshot().connection).toBe('refused');
    expect(player.getSnapshot().problem).toMatch(/version 1 .*99/);
    vi.advanceTimersByTime(60_000);
    expect(FakeSocket.made).toHaveLength(1);
  });

  it('comes back after a loss, waiting longer each time', () => {
    FakeSocket.last.accept();
    FakeSocket.last.drop();
    expect(player.getSnapshot().connection).toBe('lost');
    vi.advanceTimersByTime(500);
    expect(FakeSocket.made).toHaveLength(2);
    FakeSocket.last.drop();
    vi.advanceTimersByTime(500);
    expect(FakeSocket.made).toHaveLength(2);
    vi.advanceTimersByTime(500);
    expect(FakeSocket.made).toHaveLength(3);
    FakeSocket.last.accept();
    // A proxy may take the socket and pass nothing on: only a word counts.
    expect(player.getSnapshot().connection).toBe('lost');
    FakeSocket.last.say(layoutMessage());
    expect(player.getSnapshot().connection).toBe('open');
  });

  it('keeps the reason of a refusal', () => {
    FakeSocket.last.accept();
    FakeSocket.last.drop(1008, 'Your right to this patient has ended.');
    expect(player.getSnapshot()).toMatchObject({
      connection: 'refused',
      problem: 'Your right to this patient has ended.',
    });
  });

  it('shows what the service says about state, health and events', () => {
    FakeSocket.last.accept();
    FakeSocket.last.say({
      type: 'state',
      state: 'ready',
      reason: '',
      session_time_s: 3,
      recording_start_s: null,
      calibration: null,
      calibration_progress: null,
    });
    FakeSocket.last.say({
      type: 'event',
      event: { kind: 'mark', time_s: 2, duration_s: 0, placement: null, text: 'pain' },
    });
    expect(player.getSnapshot().state?.state).toBe('ready');
    expect(player.getSnapshot().events.map((event) => event.text)).toEqual(['pain']);
  });

  it('tells the delay since publication, and never a negative one', async () => {
    FakeSocket.last.accept();
    FakeSocket.last.say(layoutMessage());
    nowS = 1000.04;
    await send(0, 5, 1000);
    FakeSocket.last.say(health);
    expect(player.getSnapshot().networkMs).toBeCloseTo(40, 3);
    // This machine's clock stands ten seconds behind the service's.
    for (let tick = 5; tick < 500; tick += 5) {
      nowS = 990 + tick / 100 + (tick % 10 ? 0.02 : 0.01);
      await send(tick, 5, 1000 + tick / 100);
    }
    FakeSocket.last.say({ ...health });
    expect(player.getSnapshot().networkMs).toBeGreaterThanOrEqual(0);
    expect(player.getSnapshot().networkMs).toBeLessThan(20);
  });
});

describe('what does not come', () => {
  it('leaves no number of now behind when frames stop, and goes on with the next one', async () => {
    await begin();
    for (let turn = 0; turn < 4; turn += 1) {
      wait(0.5);
      FakeSocket.last.say(health);
    }
    expect(player.getSnapshot()).toMatchObject({ connection: 'open', silentSinceS: 1000 });
    expect(player.clock().timeS).toBeCloseTo(0.49 + 2);
    expect(player.read(player.clock().timeS - 1.5, player.clock().timeS, ['elbow']).timeS).toHaveLength(0);
    await send(50, 50);
    expect(player.getSnapshot().silentSinceS).toBeNull();
    expect(player.clock().timeS).toBeCloseTo(0.99);
  });

  it('knows within three seconds that a service hangs, although no socket closed, and comes back by itself', async () => {
    await begin();
    wait(3);
    expect(player.getSnapshot()).toMatchObject({ connection: 'lost', lostSinceS: 1000 });
    FakeSocket.last.say(health);
    expect(player.getSnapshot()).toMatchObject({ connection: 'open', lostSinceS: null });
    wait(9);
    expect(FakeSocket.made).toHaveLength(2);
    expect(player.getSnapshot()).toMatchObject({ connection: 'lost', lostSinceS: 1003 });
    // Nobody answers the new one either: another is tried.
    wait(8);
    expect(FakeSocket.made.length).toBeGreaterThan(2);
    FakeSocket.last.accept();
    FakeSocket.last.say(layoutMessage());
    expect(player.getSnapshot()).toMatchObject({ connection: 'open', lostSinceS: null });
  });

  it('blames the service, not the sensors, where frames and words end at the same moment', async () => {
    await begin();
    wait(1.75);
    expect(player.getSnapshot()).toMatchObject({ connection: 'lost', lostSinceS: 1000 });
  });

  it('blames the sensors where the service is heard after the last frame', async () => {
    await begin();
    wait(0.5);
    FakeSocket.last.say(health);
    wait(1.25);
    expect(player.getSnapshot()).toMatchObject({ connection: 'open', silentSinceS: 1000 });
  });

  it('says since when, from the moment the service was last heard', async () => {
    await begin();
    wait(1);
    FakeSocket.last.drop();
    expect(player.getSnapshot()).toMatchObject({ connection: 'lost', lostSinceS: 1000 });
  });

  it('misses no frames and no health of a session that has ended, only the pulse', async () => {
    await begin();
    FakeSocket.last.say({
      type: 'state',
      state: 'analysed',
      reason: '',
      session_time_s: 3,
      recording_start_s: null,
      calibration: null,
      calibration_progress: null,
    });
    for (let second = 0; second < 60; second += 1) {
      FakeSocket.last.say({ type: 'pulse' });
      wait(1);
    }
    expect(player.getSnapshot().connection).toBe('open');
    expect(FakeSocket.made).toHaveLength(1);
    wait(3);
    expect(player.getSnapshot().connection).toBe('lost');
  });
});

describe('what was kept from before', () => {
  /** The words of a service that was started again, before the gateway came back. */
  const returned = () => {
    FakeSocket.last.accept();
    FakeSocket.last.say(layoutMessage());
    FakeSocket.last.say(stateMessage('link_lost'));
  };

  it('does not judge a service that was started again by the health of the one before', async () => {
    await begin();
    FakeSocket.last.say(stateMessage('recording'));
    FakeSocket.last.drop();
    await pass(1);
    returned();
    const seen = new Set<string>();
    for (let second = 0; second < 40; second += 1) {
      FakeSocket.last.say({ type: 'pulse' });
      await pass(1);
      seen.add(player.getSnapshot().connection);
    }
    expect([...seen]).toEqual(['open']);
    expect(FakeSocket.made).toHaveLength(2);
    expect(player.getSnapshot()).toMatchObject({ health: null, calibration: null, silentSinceS: 1000 });
    FakeSocket.last.say(layoutMessage());
    FakeSocket.last.say(stateMessage('recording'));
    FakeSocket.last.say(health);
    await send(50, 50);
    expect(player.getSnapshot()).toMatchObject({ connection: 'open', silentSinceS: null });
  });

  it('misses the health of a session that is said to run, although the service is heard', async () => {
    await begin();
    FakeSocket.last.say(stateMessage('recording'));
    const seen: string[] = [];
    for (let second = 0; second < 20; second += 1) {
      FakeSocket.last.say({ type: 'pulse' });
      wait(1);
      seen.push(player.getSnapshot().connection);
    }
    expect(seen.slice(3).every((one) => one === 'lost')).toBe(true);
    expect(player.getSnapshot().lostSinceS).toBe(1000);
    FakeSocket.last.say(health);
    await send(50, 50);
    expect(player.getSnapshot()).toMatchObject({ connection: 'open', lostSinceS: null });
  });

  it('opens another socket after the machine slept, and takes nothing that had waited', async () => {
    await begin();
    nowS += 60;
    const slept = FakeSocket.last;
    slept.say(health);
    expect(FakeSocket.made).toHaveLength(2);
    expect(player.getSnapshot()).toMatchObject({ connection: 'lost', lostSinceS: 1000 });
    slept.say(packBlock({ ticks: 50, columns: 3, firstTick: 50, publishedS: 1001 }));
    await settle();
    expect(player.clock().endS).toBeCloseTo(0.49);
    await begin();
    expect(player.getSnapshot()).toMatchObject({ connection: 'open', lostSinceS: null });
  });

  it('does not take a pause of the network for sleep: timers ran', async () => {
    await begin();
    wait(6);
    FakeSocket.last.say(health);
    expect(FakeSocket.made).toHaveLength(1);
    expect(player.getSnapshot().connection).toBe('open');
  });
});

describe('the way back', () => {
  it('tries at once when the service answers again, whatever the wait still is', async () => {
    await begin();
    answers = false;
    FakeSocket.last.drop();
    for (let second = 0; second < 90; second += 1) {
      await pass(1);
      if (FakeSocket.last.readyState === 0) FakeSocket.last.drop();
    }
    const { length } = FakeSocket.made;
    answers = true;
    await pass(3);
    expect(FakeSocket.made.length).toBeGreaterThan(length);
    FakeSocket.last.accept();
    FakeSocket.last.say(layoutMessage());
    expect(player.getSnapshot()).toMatchObject({ connection: 'open', isBlocked: false });
  });

  it('lets go of a try that hangs when the service answers again', async () => {
    await begin();
    answers = false;
    FakeSocket.last.drop();
    await pass(9);
    const { length } = FakeSocket.made;
    answers = true;
    await pass(3);
    expect(FakeSocket.made.length).toBeGreaterThan(length);
  });

  it('tells a network that refuses sockets from a service that is away, and since when, once', async () => {
    const since = new Set<number | null>();
    for (let second = 0; second < 60; second += 1) {
      if (FakeSocket.last.readyState === 0) FakeSocket.last.drop();
      await pass(1);
      since.add(player.getSnapshot().lostSinceS);
      expect(player.getSnapshot().connection).toBe('lost');
    }
    expect([...since]).toEqual([1000]);
    expect(player.getSnapshot().isBlocked).toBe(true);
    answers = false;
    await pass(3);
    expect(player.getSnapshot().isBlocked).toBe(false);
  });

  it('blames no network while a service starts', async () => {
    await begin();
    answers = false;
    FakeSocket.last.drop();
    await pass(20);
    answers = true;
    await pass(3);
    FakeSocket.last.drop();
    expect(player.getSnapshot().isBlocked).toBe(false);
    await pass(1);
    FakeSocket.last.accept();
    FakeSocket.last.say(layoutMessage());
    expect(player.getSnapshot()).toMatchObject({ connection: 'open', isBlocked: false });
  });
});

describe('backOffMs', () => {
  it('doubles up to a limit and spreads by chance', () => {
    expect(backOffMs(0, () => 1)).toBe(500);
    expect(backOffMs(3, () => 1)).toBe(4000);
    expect(backOffMs(20, () => 1)).toBe(15_000);
    expect(backOffMs(3, () => 0)).toBe(3000);
  });
});
