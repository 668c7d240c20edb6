import { screen, waitFor } from '@testing-library/react';
import { expect, it, vi } from 'vitest';
import type { LayoutMessage } from '../../../src/api/types';
import { Viewer3D } from '../../../src/components/Viewer3D';
import FlatFigure from '../../../src/pictures/flat/FlatFigure';
import { sceneOf, seen } from '../../../src/pictures/flat/scene';
import { columnsOf, type Player, type PlayerSnapshot } from '../../../src/player/types';
import { layoutMessage } from '../../player/fixtures';
import { renderPage } from '../render';

const ARM = ['pelvis', 'neck', 'head', 'shoulder_right', 'elbow_right', 'wrist_right', 'hand_right', 'shoulder_left'];
/** The right upper arm hangs, the forearm points forward; x forward, y left, z up. */
const AT: Record<string, readonly [number, number, number]> = {
  pelvis: [2, 3, 1],
  neck: [2, 3, 1.5],
  head: [2, 3, 1.7],
  shoulder_right: [2, 2.8, 1.45],
  shoulder_left: [2, 3.2, 1.45],
  elbow_right: [2, 2.8, 1.15],
  wrist_right: [2.25, 2.8, 1.15],
  hand_right: [NaN, NaN, NaN],
};

function player(points: string[], segments: string[], timeS: number[] = [1]): Player {
  const columns = columnsOf(
    layoutMessage({
      layout: { points, segments, angles: [], scalars: [] } as LayoutMessage['layout'],
      columns: points.flatMap((name) => ['x', 'y', 'z'].map((axis) => `${name}.${axis}`)),
    }),
  );
  const snapshot = { connection: 'open', capabilities: { isLive: true }, columns, epoch: 0 } as PlayerSnapshot;
  return {
    getSnapshot: () => snapshot,
    subscribe: () => () => undefined,
    clock: () => ({ timeS: 1, startS: 0, endS: 1, isPlaying: true, speed: 1 }),
    read: (startS: number, endS: number, names: readonly string[]) => {
      const shown = timeS.filter((at) => at >= startS && at < endS);
      const value = (name: string) => AT[name.slice(0, -2)]!['xyz'.indexOf(name.slice(-1))]!;
      return {
        timeS: Float64Array.from(shown),
        values: names.map((name) => Float32Array.from(shown, () => value(name))),
        isComplete: true,
      };
    },
  } as unknown as Player;
}

const end = (view: string, bone: string) => {
  const line = document.querySelector(`[data-view=${view}] [data-bone=${bone}]`);
  return line && ['x2', 'y2', 'x1', 'y1'].map((name) => Number(line.getAttribute(name)));
};

it('draws the measured positions from the front and from the side of the arm', async () => {
  renderPage(<FlatFigure player={player(ARM, ['sternum', 'upper_arm_right', 'forearm_right'])} title="Arm" />, {
    answers: {},
  });
  await waitFor(() => expect(end('front', 'elbow_right')).not.toBeNull());
  // Seen from the front the right arm is at the left; the forearm points at the viewer.
  const [x, y, fromX, fromY] = end('front', 'elbow_right')!;
  expect(x).toBeCloseTo(-0.2);
  expect(y! - fromY!).toBeCloseTo(0.3);
  expect(fromX).toBeCloseTo(-0.2);
  // Seen from the right the forearm points to the right.
  const [wristX, wristY, elbowX, elbowY] = end('right', 'wrist_right')!;
  expect(wristX! - elbowX!).toBeCloseTo(0.25);
  expect(wristY! - elbowY!).toBeCloseTo(0);
  // What nobody knows is not drawn; what has no sensor is pale.
  expect(end('front', 'hand_right')).toBeNull();
  expect(document.querySelector('[data-bone=elbow_right]')!.classList).toContain('flat-measured');
  expect(document.querySelector('[data-bone=head]')!.classList).not.toContain('flat-measured');
  expect(screen.getByText(/cannot show 3D/)).toBeTruthy();
});

it('draws nothing old as of now', async () => {
  renderPage(<FlatFigure player={player(ARM, ['upper_arm_right'], [-3])} title="Arm" isPlain />, { answers: {} });
  await screen.findByText('No positions at this moment.');
  expect(document.querySelector('line')).toBeNull();
});

it('looks from the side that is measured, and at feet from above', () => {
  const layout = (points: string[], segments: string[]) => ({ points, segments, angles: [], scalars: [] });
  expect(sceneOf(layout(['shoulder_left', 'elbow_left'], ['upper_arm_left']))?.views).toEqual(['front', 'left']);
  expect(sceneOf(layout(['foot_left', 'foot_right'], ['foot_left', 'foot_right']))?.views[0]).toBe('above');
  expect(sceneOf(layout([], ['forearm_left']))).toBeNull();
  // Forward is up when seen from above, and the left is at the left.
  expect(seen([1, 0, 0], 'above')[1]).toBe(-1);
  expect(seen([0, 1, 0], 'above')[0]).toBe(-1);
});

it('says it where a session measures no positions', async () => {
  renderPage(<FlatFigure player={player([], ['forearm_left'])} title="Sensor" />, { answers: {} });
  await screen.findByText(/measure no positions/);
  expect(document.querySelector('svg')).toBeNull();
});

it.each([
  ['has none', () => null],
  [
    'breaks while it is asked',
    () => {
      throw new Error('blocked');
    },
  ],
])('asks the service for no 3D view where the browser %s', async (_, context) => {
  vi.spyOn(HTMLCanvasElement.prototype, 'getContext').mockImplementation(context);
  const { asked } = renderPage(
    <Viewer3D sessionId="s" request={{ mode: 'live' }} title="Arm" player={player(ARM, ['sternum'])} />,
    { answers: {} },
  );
  await screen.findByText(/cannot show 3D/);
  expect(asked).toEqual([]);
});

it('draws flat when the graphics card is lost while the page is open', async () => {
  vi.useFakeTimers({ shouldAdvanceTime: true });
  try {
    renderPage(
      <Viewer3D sessionId="s" request={{ mode: 'live' }} title="Arm" player={player(ARM, ['sternum'])} isPlain />,
      { answers: { 'POST /api/sessions/s/views': { id: 'v', page_path: 'about:blank', control_path: '/viewer/v' } } },
    );
    const frame = await waitFor(() => {
      const found = document.querySelector('iframe');
      expect(found?.contentDocument).toBeTruthy();
      return found!;
    });
    frame.dispatchEvent(new Event('load'));
    frame.contentDocument!.dispatchEvent(new Event('webglcontextlost'));
    frame.contentDocument!.dispatchEvent(new Event('webglcontextrestored'));
    await vi.advanceTimersByTimeAsync(5000);
    expect(screen.queryByText(/cannot show 3D/)).toBeNull();
    // A locked phone takes the card away, and gives it back when it is looked at.
    const isSeen = vi.spyOn(document, 'visibilityState', 'get');
    const show = (state: DocumentVisibilityState) => {
      isSeen.mockReturnValue(state);
      document.dispatchEvent(new Event('visibilitychange'));
    };
    show('hidden');
    frame.contentDocument!.dispatchEvent(new Event('webglcontextlost'));
    await vi.advanceTimersByTimeAsync(60_000);
    expect(screen.queryByText(/cannot show 3D/)).toBeNull();
    show('visible');
    await vi.advanceTimersByTimeAsync(2000);
    frame.contentDocument!.dispatchEvent(new Event('webglcontextrestored'));
    await vi.advanceTimersByTimeAsync(5000);
    expect(screen.queryByText(/cannot show 3D/)).toBeNull();
    frame.contentDocument!.dispatchEvent(new Event('webglcontextlost'));
    await vi.advanceTimersByTimeAsync(5000);
    expect(await screen.findByText(/cannot show 3D/)).toBeTruthy();
    show('hidden');
    show('visible');
    await waitFor(() => expect(document.querySelector('iframe')).toBeTruthy());
    expect(screen.queryByText(/cannot show 3D/)).toBeNull();
  } finally {
    vi.useRealTimers();
  }
});
