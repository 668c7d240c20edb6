import { screen, within } from '@testing-library/react';
import axe from 'axe-core';
import { describe, expect, it } from 'vitest';
import type { Gait, GaitFoot, WalkMeasure } from '../../../src/api/types';
import { ReportPage } from '../../../src/pages/report/ReportPage';
import { changed, trend } from '../../trend';
import { renderPage } from '../render';

const measure = (name: string, value: number, unit = 'm'): WalkMeasure => ({
  measure: name,
  value,
  sigma: 0.01,
  spread: 0.02,
  count: 6,
  unit,
});
const curve = (level: number) => ({
  name: 'force_vertical' as const,
  unit: '1',
  mean: Array<number>(51).fill(level),
  spread: Array<number>(51).fill(0.05),
  cycle_count: 5,
});
const foot = (side: 'left' | 'right'): GaitFoot => ({
  side,
  measures: [measure('stride_length', side === 'left' ? 1.02 : 1.1), measure('speed', 0.9, 'm/s')],
  footholds: [],
  strides: [{ is_counted: true }, { is_counted: false }] as GaitFoot['strides'],
  path_m: [],
  curves: [curve(side === 'left' ? 0.9 : 1.05)],
});
const WALK = {
  session_id: 's',
  result: { id: 'r', kind: 'offline', orientation: 'foot', orientation_version: '1', pipeline_version: '2' },
  feet: [foot('left'), foot('right')],
  both: [measure('step_width', 0.16)],
  asymmetry: [measure('stride_length', -0.08, '1')],
  turn_count: 1,
  bout_count: 1,
  reasons: ['the forces of three strides are missing'],
  has_step_width: true,
  test: { kind: 'walk', distance_m: 12.4, time_s: 13.1, speed_mps: 0.95, reasons: [] },
  balance: { mass_kg: 81.5, apart_m: 0.18, apart_source: 'forces', measures: [measure('margin', -0.1)] },
} as unknown as Gait;
const point = (session_id: string, day: number, value: number) => ({
  session_id,
  at: `2026-11-0${day}T10:00:00Z`,
  value,
  low: value - 0.05,
  high: value + 0.05,
  count: 6,
  orientation: 'foot 1',
  template_version_id: null,
});
/** Four walks, of which the last is the one reported. */
const walks = (values: number[]) => values.map((value, index) => point('abcs'[index] ?? '', index + 1, value));
const ANSWERS = {
  '/api/sessions/s': {
    id: 's',
    patient_id: 'p',
    pipeline: 'gait',
    exercise_id: 'e',
    exercise_name: 'Walk',
    created_at: '2026-11-02T10:00:00Z',
    started_at: null,
    state: 'analysed',
    placements: ['heel_left', 'heel_right'],
    rate_hz: 100,
    packets_stored: 98,
    packets_missing: 2,
    events: [{ kind: 'forces_lost' }],
  },
  '/api/sessions/s/gait': WALK,
  '/api/patients/p': {
    id: 'p',
    given_name: 'Tomasz',
    family_name: 'Lindqvist',
    affected_side: 'left',
    birth_date: null,
  },
  '/api/patients/p/progress?exercise_id=e&until=s': {
    exercise_id: 'e',
    measures: [
      {
        measure: 'walk:speed:left',
        label: 'Walking speed, left',
        unit: 'm/s',
        points: walks([0.7, 0.71, 0.69, 0.9]),
        trend: changed(0.7, 0.9, 0.08),
      },
      {
        measure: 'walk:step_width',
        label: 'Step width',
        unit: 'm',
        points: walks([0.15, 0.14, 0.16, 0.16]),
        trend: changed(0.15, 0.16, 0.02, { word: 'unchanged' }),
      },
    ],
    events: [],
  },
  '/api/estimators': [],
  '/api/me': { id: 'u', role: 'therapist', clinic_name: 'Clinic', display_name: 'Ingrid' },
};

describe('the report of a walk', () => {
  it('says what came of it, whether it changed, and how it was measured', async () => {
    const view = renderPage(<ReportPage />, {
      at: '/sessions/s/report',
      path: '/sessions/:sessionId/report',
      answers: ANSWERS,
    });
    expect(await screen.findByRole('heading', { name: 'Walking report' })).toBeTruthy();
    expect(await screen.findByText('0.90 m/s')).toBeTruthy();
    const stride = screen.getByRole('row', { name: /^Stride length/ });
    expect(
      within(stride)
        .getAllByRole('cell')
        .map((cell) => cell.textContent),
    ).toEqual(['102.0 cm ± 1.0', '110.0 cm ± 1.0', '−8 % ± 1', '–']);
    const speed = screen.getByRole('row', { name: /^Speed/ });
    expect(speed.textContent).toContain('+0.20 m/s ± 0.08');
    expect(screen.getByRole('row', { name: /^Step width/ }).textContent).toContain('unchanged: within ± 3.0 cm');
    expect(screen.getByText('the forces of three strides are missing')).toBeTruthy();
    expect(screen.getAllByRole('img')).toHaveLength(2);
    expect(screen.getByText('18.0 cm apart (estimated from the forces)')).toBeTruthy();
    expect(screen.getByText('2.0 % of packets missing, 0 gaps, forces of a shoe lost: 1')).toBeTruthy();
    expect(screen.getByText(/^2 of 4;/)).toBeTruthy();
    const found = await axe.run(view.container, {
      rules: {
        'color-contrast': { enabled: false },
        region: { enabled: false },
        'page-has-heading-one': { enabled: false },
      },
    });
    expect(found.violations.map((one) => one.id)).toEqual([]);
  });

  it('has no column of changes for one of the first three walks, and units beside its curves', async () => {
    const progress = ANSWERS['/api/patients/p/progress?exercise_id=e&until=s'];
    renderPage(<ReportPage />, {
      at: '/sessions/s/report',
      path: '/sessions/:sessionId/report',
      answers: {
        ...ANSWERS,
        '/api/sessions/s/gait': {
          ...WALK,
          feet: WALK.feet.map((one) => ({ ...one, curves: [{ ...curve(0.1), name: 'height' as const, unit: 'm' }] })),
        },
        '/api/patients/p/progress?exercise_id=e&until=s': {
          ...progress,
          measures: progress.measures.map((one) => ({
            ...one,
            points: [point('s', 1, 0.7), point('b', 2, 0.8)],
            trend: trend(),
          })),
        },
      },
    });
    expect(await screen.findByText('0.70 m/s')).toBeTruthy();
    expect(screen.queryByText('Change up to this walk')).toBeNull();
    expect(screen.getByText(/a change can be judged from four days on/)).toBeTruthy();
    expect(screen.getByText('Height of the foot (cm)')).toBeTruthy();
    expect(screen.getByText(/^Walking speed, left \(m\/s\), over the sessions/)).toBeTruthy();
    expect(screen.getByText(/Foot tracking \(version 1\)/)).toBeTruthy();
  });
});
