import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { InlineDecoder } from '../../src/player/decoder';
import { PAGE_S, PAGES_HELD, ReplayPlayer } from '../../src/player/replay';
import { layoutMessage, packBlock, settle } from './fixtures';

const RATE_HZ = 100;
let asked: URL[] = [];
let nowMs = 0;
let version = 1;

/** A service with a recording whose elbow angle is the session time. */
function serve(input: string): Response {
  const url = new URL(input, 'http://test');
  asked.push(url);
  if (url.pathname.endsWith('/layout')) return Response.json(layoutMessage({ protocol_version: version }));
  const startS = Number(url.searchParams.get('start_s'));
  const endS = Number(url.searchParams.get('end_s'));
  const most = Number(url.searchParams.get('max_points') ?? Infinity);
  const stride = Math.max(1, Math.ceil(((endS - startS) * RATE_HZ) / most));
  const stepS = stride / RATE_HZ;
  const ticks = Math.floor((endS - startS) / stepS);
  return new Response(
    packBlock({
      ticks,
      columns: 3,
      startS,
      stepS,
      value: (tick, column) => (column === 0 ? startS + tick * stepS : 0),
    }),
  );
}

const open = async (endS = 35) => {
  const player = new ReplayPlayer({
    sessionId: 's',
    resultId: 'r',
    startS: 0,
    endS,
    decoder: new InlineDecoder(),
    now: () => nowMs,
  });
  await vi.waitFor(() => expect(player.getSnapshot().connection).not.toBe('connecting'));
  return player;
};

beforeEach(() => {
  asked = [];
  nowMs = 0;
  version = 1;
  vi.stubGlobal('fetch', (input: string) => Promise.resolve(serve(input)));
});
afterEach(() => vi.unstubAllGlobals());

describe('ReplayPlayer', () => {
  it('runs its own clock at the chosen speed and stops at the end', async () => {
    const player = await open();
    player.play();
    nowMs += 2000;
    expect(player.clock().timeS).toBeCloseTo(2);
    player.setSpeed(0.5);
    nowMs += 2000;
    expect(player.clock().timeS).toBeCloseTo(3);
    nowMs += 1e6;
    expect(player.clock().timeS).toBe(35);
    await settle();
    expect(player.getSnapshot().isPlaying).toBe(false);
    player.play();
    expect(player.clock().timeS).toBe(0);
  });

  it('stays inside the recording when it seeks, and tells readers to forget', async () => {
    const player = await open();
    const { epoch } = player.getSnapshot();
    player.seek(99);
    expect(player.clock().timeS).toBe(35);
    player.seek(-5);
    expect(player.clock().timeS).toBe(0);
    expect(player.getSnapshot().epoch).toBe(epoch + 2);
  });

  it('shows the overview first and the full rate once the page is here', async () => {
    const player = await open(300);
    expect(player.read(8, 12, ['elbow']).isComplete).toBe(false);
    await vi.waitFor(() => expect(player.read(8, 12, ['elbow']).isComplete).toBe(true));
    const { timeS, values } = player.read(8, 12, ['elbow']);
    expect(timeS).toHaveLength(4 * RATE_HZ);
    timeS.forEach((time, index) => expect(values[0]?.[index]).toBeCloseTo(time, 4));
  });

  it('asks for each page once and holds a bounded number', async () => {
    const player = await open(PAGE_S * (PAGES_HELD + 20));
    for (let page = 0; page < PAGES_HELD + 20; page += 1) {
      await vi.waitFor(() => expect(player.read(page * PAGE_S, page * PAGE_S + 1, ['elbow']).isComplete).toBe(true));
    }
    const pages = () => asked.filter((url) => url.pathname.endsWith('/frames') && !url.searchParams.has('max_points'));
    expect(pages()).toHaveLength(PAGES_HELD + 20);
    expect(player.read(PAGE_S * (PAGES_HELD + 19), PAGE_S * (PAGES_HELD + 19) + 1, ['elbow']).isComplete).toBe(true);
    expect(player.read(0, 1, ['elbow']).isComplete).toBe(false);
  });

  it('refuses another protocol version in words', async () => {
    version = 2;
    const player = await open();
    expect(player.getSnapshot()).toMatchObject({ connection: 'refused' });
    expect(player.getSnapshot().problem).toMatch(/version/);
  });

  it('passes on why the service does not give the movement', async () => {
    vi.stubGlobal('fetch', () =>
      Promise.resolve(Response.json({ code: 'not_found', message: 'No such session.', details: {} }, { status: 404 })),
    );
    const player = await open();
    expect(player.getSnapshot()).toMatchObject({ connection: 'refused', problem: 'No such session.' });
  });
});
