import { screen, within } from '@testing-library/react';
import userEvent from '@testing-library/user-event';
import axe from 'axe-core';
import { afterEach, describe, expect, it, vi } from 'vitest';
import type { Conditions, Gait, GaitFoot, Stride, WalkMeasure, WalkRow } from '../../../src/api/types';
import { floorPath, leaning, mapFrame, measureLabel, measureText, partsOf } from '../../../src/kinds/walk/gait';
import { ConditionsPage } from '../../../src/kinds/walk/ConditionsPage';
import { GaitPage } from '../../../src/kinds/walk/GaitPage';
import { renderPage } from '../render';

afterEach(() => vi.unstubAllGlobals());

const measure = (name: string, value: number, unit = 'm'): WalkMeasure => ({
  measure: name,
  value,
  sigma: 0.01,
  spread: 0.02,
  count: 5,
  unit,
});
const stride = (number: number, contact_s: number): Stride => ({
  number,
  bout: 1,
  toe_off_s: contact_s - 0.4,
  contact_s,
  length_m: 1.1,
  length_sigma_m: 0.01,
  duration_s: 1.1,
  stance_s: 0.7,
  swing_s: 0.4,
  rise_m: 0,
  clearance_m: 0.12,
  circumduction_m: 0.02,
  contact_pitch_rad: 0.3,
  toe_off_pitch_rad: -1,
  toe_out_rad: 0.1,
  turn_rad: 0,
  peak_speed_mps: 4,
  is_counted: true,
  is_initiation: false,
  is_termination: false,
});
const foot = (side: 'left' | 'right', shift: number): GaitFoot => ({
  side,
  measures: [measure('stride_length', side === 'left' ? 1.02 : 1.1), measure('stance_share', 0.62, '1')],
  footholds: [0, 1, 2].map((k) => ({
    start_s: k,
    stop_s: k + 0.5,
    x_m: 1.1 * k + shift,
    y_m: side === 'left' ? 0.09 : -0.09,
    z_m: 0,
    heading_rad: 0.1,
    sigma_m: 0.01,
  })),
  strides: [stride(1, 1 + shift), stride(2, 2.1 + shift)],
  path_m: [],
  curves: [{ name: 'height', unit: 'm', mean: Array(51).fill(0.1), spread: Array(51).fill(0.01), cycle_count: 4 }],
});
const WALK: Gait = {
  session_id: 's',
  result: { id: 'r' } as Gait['result'],
  feet: [foot('left', 0), foot('right', 0.5)],
  both: [measure('double_support', 0.2, 's')],
  asymmetry: [measure('stride_length', -0.08, '1')],
  turn_count: 0,
  bout_count: 1,
  reasons: ['one thing could not be told'],
  has_step_width: true,
  test: {
    kind: 'walk',
    start_s: 3,
    end_s: 8,
    time_s: 5,
    distance_m: 5.25,
    distance_sigma_m: 0.04,
    speed_mps: 1.05,
    step_count: 8,
    turn_count: 0,
    pause_count: 0,
    turn_s: null,
    minutes_m: [5.25],
    reasons: [],
  },
  balance: {
    mass_kg: 80,
    apart_m: 0.18,
    apart_source: 'measured',
    measures: [measure('centre_to_left_standing', -0.04)],
    time_s: [0, 1],
    centre_m: [
      [0, 0, 1],
      [1, -0.03, 1],
    ],
    centre_sigma_m: [0.003, 0.003],
    pressure_m: [
      [0, 0],
      [1, -0.05],
    ],
    margin_m: [0.1, null],
    support: [
      {
        time_s: 0,
        outline_m: [
          [0, 0],
          [1, 0],
          [0, 1],
        ],
      },
    ],
  },
};
const ROWS: WalkRow[] = ['s', 'e'].map((id, k) => ({
  session_id: id,
  started_at: `2026-11-0${k + 1}T10:00:00Z`,
  exercise_name: 'Walk',
  kind: 'walk',
  time_s: 5,
  distance_m: 5,
  speed_mps: 1,
  stride_count: 8,
}));
const ANSWERS = {
  '/api/sessions/s': {
    id: 's',
    patient_id: 'p',
    exercise_name: 'Walk',
    created_at: '2026-11-02T10:00:00Z',
    started_at: null,
    state: 'analysed',
  },
  '/api/sessions/s/gait': WALK,
  '/api/sessions/e/gait': { ...WALK, session_id: 'e' },
  '/api/patients/p': { id: 'p', given_name: 'Tomasz', family_name: 'Lindqvist', affected_side: 'left' },
  '/api/patients/p/walks': ROWS,
};

describe('the page of a walk', () => {
  it('shows a walk of hours by its beginning, with its strides in pages', async () => {
    const long: Gait = {
      ...WALK,
      feet: WALK.feet.map((one) => ({ ...one, stride_count: 3560, counted_count: 3500 })),
    };
    renderPage(<GaitPage />, {
      at: '/sessions/s/gait',
      path: '/sessions/:sessionId/gait',
      answers: {
        ...ANSWERS,
        '/api/sessions/s/gait': long,
        '/api/sessions/s/gait/strides?result_id=r&limit=100': [{ ...stride(7, 7), side: 'left' }],
      },
    });
    expect(await screen.findByText('1 of 7,120')).toBeTruthy();
    expect(screen.getByText('The first 2 strides of each foot are drawn.')).toBeTruthy();
    expect(screen.getByRole('button', { name: 'Left foot, stride 7: show in the map' })).toBeTruthy();
  });

  it('shows the way to the line pale, and says that it does not count', async () => {
    const line: Gait = {
      ...WALK,
      feet: WALK.feet.map((one) => ({
        ...one,
        strides: one.strides.map((each, k) => (k === 0 ? { ...each, is_counted: false, flags: 16 } : each)),
      })),
    };
    const view = renderPage(<GaitPage />, {
      at: '/sessions/s/gait',
      path: '/sessions/:sessionId/gait',
      answers: { ...ANSWERS, '/api/sessions/s/gait': line },
    });
    expect(await screen.findAllByText('not recorded')).toHaveLength(2);
    // The first foothold of each foot is of that stride only; the second one begins the next.
    expect(view.container.querySelectorAll('.print[data-outside]')).toHaveLength(2);
    expect(screen.getByText(/^Pale footprints: before Record was pressed/)).toBeTruthy();
  });

  it('shows result, footprints, left beside right and every stride, and marks the stride that is chosen', async () => {
    const user = userEvent.setup();
    const view = renderPage(<GaitPage />, {
      at: '/sessions/s/gait',
      path: '/sessions/:sessionId/gait',
      answers: ANSWERS,
    });
    expect(await screen.findByText('5.25 m')).toBeTruthy();
    expect(screen.getByText('Standing: 4.0 cm to the right.')).toBeTruthy();
    expect(screen.getByText('one thing could not be told')).toBeTruthy();
    expect(view.container.querySelectorAll('.print-left path')).toHaveLength(3);
    const row = screen.getByRole('row', { name: /^Stride length/ });
    expect(
      within(row)
        .getAllByRole('cell')
        .map((cell) => cell.textContent),
    ).toEqual(['102.0 cm ± 1.0', '110.0 cm ± 1.0', '−8 % ± 1', '5 + 5']);
    expect(await screen.findByRole('columnheader', { name: 'Left (affected side)' })).toBeTruthy();
    // Below each other on a telephone, every number still has its name.
    const cells = [...view.container.querySelectorAll('.stacked-table td')];
    expect(cells.length).toBeGreaterThan(40);
    expect(cells.filter((cell) => !cell.getAttribute('data-label'))).toEqual([]);
    await user.click(screen.getByRole('button', { name: 'Right foot, stride 2: show in the map' }));
    expect(view.container.querySelectorAll('.print[data-selected]')).toHaveLength(2);
    const found = await axe.run(view.container, {
      rules: {
        'color-contrast': { enabled: false },
        region: { enabled: false },
        'page-has-heading-one': { enabled: false },
      },
    });
    expect(found.violations.map((one) => one.id)).toEqual([]);
  });

  it('shows strides along turns apart from the others', async () => {
    const turned: Gait = {
      ...WALK,
      feet: WALK.feet.map((one) => ({
        ...one,
        turning: [measure('swing_time', one.side === 'left' ? 0.41 : 0.45, 's')],
      })),
    };
    renderPage(<GaitPage />, {
      at: '/sessions/s/gait',
      path: '/sessions/:sessionId/gait',
      answers: { ...ANSWERS, '/api/sessions/s/gait': turned },
    });
    const table = await screen.findByRole('table', { name: 'Strides along turns' });
    expect(
      within(table)
        .getAllByRole('cell')
        .map((cell) => cell.textContent),
    ).toEqual(['0.41 s ± 0.01', '0.45 s ± 0.01', '5 + 5']);
  });

  it('puts another walk beside it when one is chosen', async () => {
    renderPage(<GaitPage />, { at: '/sessions/s/gait?before=e', path: '/sessions/:sessionId/gait', answers: ANSWERS });
    // By text: looking for roles in a page this large takes longer than the wait on a busy machine.
    expect((await screen.findByText('Left, before', {}, { timeout: 5000 })).tagName).toBe('TH');
    expect(screen.getByText('Before, without band')).toBeTruthy();
  });

  it('says that no stride was found, and why', async () => {
    const empty: Gait = {
      ...WALK,
      feet: [{ ...foot('right', 0), strides: [] }],
      test: null,
      balance: null,
      reasons: ['right foot: no stride found; it never rested'],
    };
    renderPage(<GaitPage />, {
      at: '/sessions/s/gait',
      path: '/sessions/:sessionId/gait',
      answers: { ...ANSWERS, '/api/sessions/s/gait': empty },
    });
    expect(await screen.findByRole('heading', { name: 'No stride found' })).toBeTruthy();
    expect(screen.getByText(/it never rested/)).toBeTruthy();
  });
});

describe('conditions', () => {
  it('compare the walks that were put into each', async () => {
    const user = userEvent.setup();
    const found: Conditions = {
      method: 'strides',
      changes: [
        {
          measure: 'stride_length',
          foot: 'left',
          unit: 'm',
          a: 1.1,
          b: 1.0,
          difference: -0.1,
          sigma: 0.02,
          p: 0.002,
          effect: -1.2,
          count: 20,
          method: 'strides',
        },
      ],
    };
    const view = renderPage(<ConditionsPage />, {
      at: '/patients/p/walks',
      path: '/patients/:patientId/walks',
      answers: { ...ANSWERS, 'POST /api/patients/p/walks/comparison': found },
    });
    expect(await screen.findByText('Choose at least one walk for each condition.')).toBeTruthy();
    const groups = screen.getAllByRole('radiogroup');
    await user.click(within(groups[0] as HTMLElement).getByText('Eyes open'));
    await user.click(within(groups[1] as HTMLElement).getByText('Eyes closed'));
    expect(await screen.findByText('clear difference')).toBeTruthy();
    expect(view.asked.at(-1)?.body).toEqual({ a: ['s'], b: ['e'] });
    expect(screen.getByText('−10.0 cm ± 2.0')).toBeTruthy();
  });

  it('stand in parts, in words, left beside right', () => {
    const change = (measure: string, foot: 'left' | 'right' | 'both'): Conditions['changes'][number] => ({
      measure,
      foot,
      unit: 'm',
      a: 1,
      b: 1,
      difference: 0,
      sigma: 1,
      p: 1,
      effect: 0,
      count: 9,
      method: 'strides',
    });
    const parts = partsOf([
      change('stride_length', 'left'),
      change('circumduction', 'left'),
      change('stride_length', 'right'),
      change('circumduction', 'right'),
      change('step_width', 'both'),
      change('swing_time_asymmetry', 'both'),
      change('weight_on_left', 'both'),
    ]);
    expect(
      parts.map(([part, found]) => [part, ...found.map((one) => `${measureLabel(one.measure)}, ${one.foot}`)]),
    ).toEqual([
      [
        'feet',
        'Stride length, left',
        'Stride length, right',
        'Outward swing (circumduction), left',
        'Outward swing (circumduction), right',
      ],
      ['both', 'Step width, both'],
      ['asymmetry', 'Swing, both'],
      ['balance', 'Weight on the left foot, standing, both'],
    ]);
    expect(partsOf([])).toEqual([]);
  });
});

describe('numbers of a walk', () => {
  it('stand in units of a clinic', () => {
    expect(measureText(0.62, '1', 0.01)).toBe('62 % ± 1');
    expect(measureText(1.234, 's')).toBe('1.23 s');
    expect(measureText(110.4, 'steps/min', 1.2)).toBe('110 /min ± 1');
    expect(measureText(110.4, 'steps/min', 0.3)).toBe('110.4 /min ± 0.3');
    expect(measureText(1.234, 's', 0.002)).toBe('1.234 s ± 0.002');
    expect(measureText(null, 'm')).toBe('–');
  });
  it('put the map where the feet were', () => {
    const frame = mapFrame(WALK, 1000);
    expect(frame.scale).toBe(240);
    expect(
      floorPath(
        [
          [frame.minX, frame.maxY],
          [frame.minX + 1, frame.maxY - 0.5],
        ],
        frame,
      ),
    ).toBe('M0.0 0.0L240.0 120.0');
    // On a telephone the walk goes up, as wide as the feet went to the sides.
    expect(mapFrame(WALK, 320)).toMatchObject({ isUpright: true, scale: 150 });
    expect(mapFrame({ ...WALK, feet: [foot('left', 0), foot('right', 9)] }, 320).scale).toBeLessThan(90);
    expect(leaning([measure('centre_to_left', 0.004)], 'centre_to_left')?.side).toBe('middle');
    expect(leaning([], 'centre_to_left')).toBeNull();
  });
});
