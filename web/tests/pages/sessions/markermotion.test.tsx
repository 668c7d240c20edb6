import { screen, within } from '@testing-library/react';
import userEvent from '@testing-library/user-event';
import axe from 'axe-core';
import { afterEach, describe, expect, it, vi } from 'vitest';
import type { MarkerMotion as Motion, Markers } from '../../../src/api/types';
import { MarkerLegend, MarkerMotion, tableOf } from '../../../src/pages/session/replay/MarkerMotion';
import type { Player } from '../../../src/player/types';
import { renderPage } from '../render';

vi.mock('../../../src/charts/Plot', () => ({
  Plot: ({ label }: { label: string }) => <div role="img" aria-label={label} />,
  axis: (more: object) => more,
  themeColour: () => '#000',
}));
afterEach(() => vi.unstubAllGlobals());

const MOTION: Motion = {
  markers_id: 'm',
  time_s: [10, 10.01, 10.02, 10.03, 10.04],
  place_m: [
    [1, 1.1, 1.2, 1.3, 1.4],
    [0, 0, 0, 0, 0],
    [2, 2, 2, 2, null],
  ],
  sigma_m: [
    [0.01, 0.01, 0.02, 0.02, 0.01],
    [0, 0, 0, 0, 0],
    [0, 0, 0, 0, null],
  ],
  measured_m: [
    [1, 1.1, null, null, 1.4],
    [0, 0, null, null, 0],
    [2, 2, null, null, 2],
  ],
  speed_mps: [0, 0, 0, 0, 0],
  is_gap: [false, false, true, true, false],
};
const gap = (start_s: number, length_s: number, withheld = false) => ({ start_s, length_s, sigma_m: 0.0042, withheld });
const FOUND = {
  id: 'm',
  session_id: 's',
  segment: 'hand_right',
  report: {
    marker: 'HAND',
    gaps: [gap(12, 0.5), ...Array.from({ length: 9 }, (_, k) => gap(20 + k, 0.1)), gap(40, 2.5, true)],
  },
} as unknown as Markers;

function standing(): Player {
  const snapshot = {
    connection: 'open',
    problem: null,
    capabilities: { isLive: false, canSeek: true, canChangeSpeed: true },
    columns: null,
    isPlaying: false,
    speed: 1,
    epoch: 0,
  };
  return {
    getSnapshot: () => snapshot,
    subscribe: () => () => undefined,
    clock: () => ({ timeS: 12, startS: 2, endS: 60, isPlaying: false, speed: 1 }),
  } as unknown as Player;
}

describe('fused motion of a marker', () => {
  it('parts the line into what was seen and what was filled, and the parts meet', () => {
    const [time, low, high, seen, filled, frames] = tableOf([MOTION], 0, 2);
    expect(time?.[0]).toBe(8);
    expect(low?.[2]).toBeCloseTo(1.16);
    expect(high?.[2]).toBeCloseTo(1.24);
    expect(seen).toEqual([1, 1.1, null, 1.3, 1.4]);
    expect(filled).toEqual([null, 1.1, 1.2, 1.3, null]);
    // Dots a tenth of a second apart leave the line to be seen.
    expect(frames).toEqual([1, null, null, null, null]);
    // Without a place there is no band either.
    expect(tableOf([MOTION], 2, 2)[1]?.[4]).toBeNull();
  });

  it('lists the longest gaps in order of time and goes there', async () => {
    const onSeek = vi.fn();
    const view = renderPage(
      <>
        <MarkerMotion fused={[FOUND]} shown={FOUND} onChoose={() => undefined} player={standing()} onSeek={onSeek} />
        <MarkerLegend />
      </>,
      { at: '/s', path: '/s', answers: { '/api/sessions/s/markers/motion/stretch': MOTION } },
    );
    const rows = within(await screen.findByRole('table', { name: 'Longest gaps of the cameras' }))
      .getAllByRole('row')
      .slice(1);
    expect(rows).toHaveLength(8);
    expect(rows[0]?.textContent).toBe('10.0 s0.50 s4.2 mm');
    expect(rows.at(-1)?.textContent).toBe('38.0 s2.50 s4.2 mm, do not rely on it');
    await userEvent.click(screen.getByRole('button', { name: 'Show the gap at 38.0 s' }));
    expect(onSeek).toHaveBeenCalledWith(38);
    expect(screen.getAllByRole('img', { name: /Position of the marker along/ })).toHaveLength(3);
    const rules = {
      'color-contrast': { enabled: false },
      region: { enabled: false },
      'page-has-heading-one': { enabled: false },
      'heading-order': { enabled: false },
    };
    expect((await axe.run(view.container, { rules })).violations.map((one) => one.id)).toEqual([]);
  });
});
