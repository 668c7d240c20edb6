// My results: when, how far, how it went, and on which days; also in German.
import { trend } from '../../trend';
import { cleanup, screen } from '@testing-library/react';
import axe from 'axe-core';
import { afterEach, expect, it, vi } from 'vitest';
import type { Me } from '../../../src/api/types';
import { speakLanguage } from '../../../src/i18n/languages';
import { practisedWeeks, valuesByDay } from '../../../src/lib/assessment/ownDays';
import { HowItGoes } from '../../../src/pages/mine/HowItGoes';
import { ResultsPage } from '../../../src/pages/mine/Results';
import { renderPage, THERAPIST } from '../render';

afterEach(async () => {
  vi.unstubAllGlobals();
  await speakLanguage('en');
});

const OWN: Me = { ...THERAPIST, role: 'patient', patient_id: 'p' };
const at = (day: number, hour: number) => new Date(2026, 5, day, hour, 5).toISOString();
const point = (id: string, when: string, degrees: number, count: number) => ({
  session_id: id,
  at: when,
  value: (degrees * Math.PI) / 180,
  count,
  change: null,
  is_real_change: null,
});
const POINTS = [point('a', at(2, 9), 40, 10), point('b', at(4, 9), 50, 10), point('c', at(4, 17), 59, 20)];
const MEASURE = {
  measure: 'range:humerus_forearm_right_flexion',
  label: 'Elbow flexion',
  unit: 'rad',
  points: POINTS,
  trend: trend(),
};

function open() {
  cleanup();
  const session = { patient_id: 'p', exercise_id: 'e', exercise_name: 'Reach', state: 'analysed', duration_s: 240 };
  return renderPage(<ResultsPage />, {
    me: OWN,
    answers: {
      '/api/patients/p/prescriptions': [{ exercise_id: 'e', exercise_name: 'Reach' }],
      '/api/patients/p/sessions': POINTS.map((one) => ({ ...session, id: one.session_id, started_at: one.at })),
      '/api/patients/p/progress?exercise_id=e': { measures: [MEASURE], events: [] },
    },
  });
}

it('tells the sessions of a day apart by time and value, and draws the days', async () => {
  const { container } = open();
  expect(await screen.findByText('Your elbow: 59°')).toBeTruthy();
  expect(screen.getByText('Your elbow: 50°')).toBeTruthy();
  expect(screen.getByText(/^(17:05|05:05 PM), 20 times, 4 minutes$/)).toBeTruthy();
  // The second day: ten of 50 and twenty of 59.
  expect(screen.getByRole('img', { name: /^Your elbow: 2 days?, .*40°.*56°/ })).toBeTruthy();
  const found = await axe.run(container, {
    rules: { 'color-contrast': { enabled: false }, region: { enabled: false } },
  });
  expect(found.violations.map((one) => one.id)).toEqual([]);
  await speakLanguage('de');
  open();
  expect(await screen.findByText('Beweglichkeit (Ellbogen): 59°')).toBeTruthy();
});

it('weighs the sessions of a day by their repetitions', () => {
  expect(valuesByDay(MEASURE as never).map((one) => Math.round((one.value * 180) / Math.PI))).toEqual([40, 56]);
});

it('marks days in weeks from Monday, and claims nothing of days that it does not know', () => {
  // Thursday 4 June 2026.
  const now = new Date(2026, 5, 4, 20);
  const marks = (isWhole: boolean, days: string[]) =>
    practisedWeeks(days, isWhole, now).map((week) => week.map((one) => one.state[0]).join(''));
  expect(marks(true, [at(2, 9), at(4, 9), at(4, 17)])).toEqual(['fpfpuuu']);
  expect(marks(false, [at(2, 9), at(4, 9)])).toEqual(['upfpuuu']);
  expect(marks(true, [new Date(2026, 4, 31, 23).toISOString(), at(1, 0)])).toEqual(['ffffffp', 'pfffuuu']);
  expect(marks(true, [])).toEqual([]);
});

it('calls what was recorded as the example so, and that day no day of practice', async () => {
  const session = { patient_id: 'p', exercise_id: 'e', exercise_name: 'Reach', state: 'analysed', duration_s: 60 };
  const shown = (id: string, purpose: string, started_at: string) => ({ ...session, id, purpose, started_at });
  const now = new Date();
  const yesterday = new Date(now.getTime() - 86_400_000);
  renderPage(<ResultsPage />, {
    me: OWN,
    answers: {
      '/api/patients/p/prescriptions': [],
      '/api/patients/p/sessions': [
        shown('a', 'exercise', now.toISOString()),
        shown('t', 'template', yesterday.toISOString()),
      ],
      '/api/patients/p/progress?exercise_id=e': { measures: [], events: [] },
    },
  });
  expect(await screen.findAllByText('Recorded as the example for this exercise')).toHaveLength(1);
  expect(screen.getAllByText('practised')).toHaveLength(1);
});

it('says the last value where no change can be told and it is no angle', () => {
  const walk = {
    ...MEASURE,
    measure: 'walk:speed:left',
    label: 'Walking speed',
    unit: 'm/s',
    points: [point('a', at(2, 9), 0, 9)],
  };
  walk.points = [{ ...walk.points[0]!, value: 0.634 }];
  renderPage(<HowItGoes measures={[walk] as never} />, { answers: {} });
  expect(screen.getByText('Walking speed: 0.63 m/s')).toBeTruthy();
});
