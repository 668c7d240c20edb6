// The therapist's weighted sum on paper: with every part of it, on the report of a session and of a course.
import { screen, within } from '@testing-library/react';
import { describe, expect, it } from 'vitest';
import type { ComparisonDetail, Patient, SessionDetail } from '../../../src/api/types';
import { CoursePage } from '../../../src/pages/report/CoursePage';
import { MethodSheet } from '../../../src/pages/report/MethodSheet';
import { renderPage } from '../render';

const PART = { measure: 'duration', label: 'Duration', unit: 's', weight: -1.25, value: 3, part: -3.75 };
const SUM = {
  value: 71.25,
  uncertainty: 4.5,
  count: 3,
  template_value: 78.5,
  parts: [
    { ...PART, measure: 'range:a', label: 'Elbow range', unit: 'deg', weight: 1.5, value: 50, part: 75 },
    { ...PART, template_value: 2, template_part: -2.5 },
  ].map((one) => ({ template_value: 54, template_part: 81, ...one })),
};
const compared = (change: object) =>
  ({
    id: 'c',
    repetition_count: 3,
    repetitions: [],
    curves: [],
    findings: [],
    summary: [],
    outside: [],
    created_at: '2026-01-01T10:00:00Z',
    weighted_sum: SUM,
    ...change,
  }) as unknown as ComparisonDetail;
const SESSION = {
  id: 's',
  created_at: '2026-01-01T10:00:00Z',
  duration_s: 60,
  placements: [],
  events: [],
  results: [],
} as unknown as SessionDetail;
const PATIENT = { id: 'p', given_name: 'Ada', family_name: 'Lund' } as Patient;

const method = (comparison: ComparisonDetail) =>
  renderPage(
    <MethodSheet
      session={SESSION}
      patient={PATIENT}
      comparison={comparison}
      template={null}
      estimators={[]}
      exercise={null}
      progress={null}
    />,
    { answers: {} },
  );

function check() {
  const table = within(screen.getByRole('table', { name: 'Weighted sum' }));
  expect(table.getByRole('row', { name: /Elbow range/ }).textContent).toContain('× 1.5');
  const minus = table.getByRole('row', { name: /Duration/ }).textContent;
  expect(minus).toContain('× −1.25');
  expect(minus).toContain('−3.75');
  const sum = table.getByRole('row', { name: /^Sum/ }).textContent;
  expect(sum).toContain('± 4.50 (mean of');
  expect(sum).toContain('78.50');
  expect(sum).toMatch(/71\.25$/);
}

describe('a weighted sum on paper', () => {
  it('stands with its parts on the report of a session', () => {
    method(compared({}));
    check();
  });

  it('is no empty table where there is none, and says why it has no value', () => {
    method(compared({ weighted_sum: null }));
    expect(screen.queryByText('Weighted sum')).toBeNull();
    method(compared({ weighted_sum: { ...SUM, value: null, uncertainty: null, count: 0 } }));
    expect(screen.getByText('No repetition has every part, so there is no sum.')).toBeTruthy();
  });

  it('stands with its parts on the report of a course', async () => {
    renderPage(<CoursePage />, {
      at: '/patients/p/report?exercise=e',
      path: '/patients/:patientId/report',
      answers: {
        '/api/patients/p': PATIENT,
        '/api/patients/p/course?exercise_id=e': {
          exercise_name: 'Reach',
          session_count: 1,
          first_at: '2026-01-01T10:00:00Z',
          last_at: '2026-01-01T10:00:00Z',
          prescribed: [],
          first_comparison_id: 'c',
          last_comparison_id: 'c',
          service_version: '1',
        },
        '/api/patients/p/progress?exercise_id=e': { exercise_id: 'e', measures: [], events: [] },
        '/api/comparisons/c': compared({}),
      },
    });
    await screen.findByText('Weighted sum', { selector: 'h3' });
    check();
  });
});
