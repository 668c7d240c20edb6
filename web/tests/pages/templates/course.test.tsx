// The report of a course of therapy: rows with n, verdicts, words that are stored, first beside newest, the software's version.
import { screen, waitFor, within } from '@testing-library/react';
import userEvent from '@testing-library/user-event';
import axe from 'axe-core';
import { afterEach, describe, expect, it, vi } from 'vitest';
import type { ProgressMeasure } from '../../../src/api/types';
import { courseRows } from '../../../src/lib/assessment/course';
import { readDraft, writeDraft } from '../../../src/lib/editing/drafts';
import { CoursePage } from '../../../src/pages/report/CoursePage';
import { changed, trend } from '../../trend';
import { renderPage } from '../render';

afterEach(() => vi.unstubAllGlobals());

const measure = (name: string, values: number[], change: Partial<ProgressMeasure> = {}): ProgressMeasure => ({
  measure: name,
  label: name,
  unit: 'deg',
  points: values.map((value, index) => ({
    session_id: `s${index}`,
    at: `2026-0${index + 1}-01T10:00:00Z`,
    value,
    low: value - 2,
    high: value + 2,
    count: 8,
    orientation: 'telemotion 9',
    template_version_id: null,
  })),
  trend: trend({ days: values.length }),
  bands: [],
  ...change,
});

describe('rows of a course', () => {
  it('begin with the main measure, then compensation, then what changed for sure', () => {
    const found = [
      measure('range:a', [50, 54, 52, 64]),
      measure('duration', [3, 3, 3, 3]),
      measure('peak_speed', [1, 2, 3, 9], { trend: changed(1, 9, 2) }),
      measure('compensation:trunk', [9, 9, 9, 4]),
      measure('multiple_correlation:a', [0.8, 0.9]),
      measure('movement_units', [5, 4]),
      measure('empty', []),
    ];
    const names = (rows: ProgressMeasure[]) => rows.map((row) => row.measure);
    expect(names(courseRows(found))).toEqual(['range:a', 'compensation:trunk', 'peak_speed', 'duration']);
    expect(names(courseRows(found, { indices: true }))).toEqual(['multiple_correlation:a', 'movement_units']);
  });
});

const COURSE = '/api/patients/p/course?exercise_id=e';
const answers = {
  '/api/patients/p': { id: 'p', given_name: 'Ada', family_name: 'Berg', birth_date: null, may_treat: true },
  [COURSE]: {
    exercise_id: 'e',
    exercise_name: 'Reach',
    session_count: 4,
    first_at: '2026-01-01T10:00:00Z',
    last_at: '2026-04-01T10:00:00Z',
    valid_repetitions: 32,
    active_s: 300,
    prescribed: ['10 repetitions, 3 times a week'],
    adherence_percent: 75,
    first_comparison_id: null,
    last_comparison_id: null,
    note: {
      id: 'n',
      exercise_id: 'e',
      text: 'Reaches further.',
      written_by: 'Ingrid',
      created_at: '2026-04-02T10:00:00Z',
    },
    service_version: '1.2.3',
  },
  '/api/patients/p/progress?exercise_id=e': {
    exercise_id: 'e',
    measures: [
      measure('Elbow range', [50, 54, 52, 58, 64], { trend: changed(50.4, 63.4, 4) }),
      measure('Duration', [3, 4]),
      measure('movement_units', [5, 4]),
    ],
    events: [{ at: '2026-02-01T10:00:00Z', kind: 'pain', text: 'Stopped because it hurt' }],
  },
  'POST /api/patients/p/course-notes': { id: 'm' },
};

describe('the report of a course', () => {
  it('says what was done, what changed and how many stand behind each number', async () => {
    const view = renderPage(<CoursePage />, {
      at: '/patients/p/report?exercise=e',
      path: '/patients/:patientId/report',
      answers,
    });
    const row = within(await screen.findByRole('row', { name: /Elbow range/ }));
    expect(row.getAllByRole('cell').map((cell) => cell.textContent)).toEqual(['50°', '63°', '+13° ± 4', '6']);
    const few = screen.getByRole('row', { name: /Duration/ });
    expect(few.textContent).toContain('4° (newest)2 days: a change can be judged from four days on');
    expect(screen.getByRole('heading', { name: 'Movement indices' })).toBeTruthy();
    expect(screen.getByText('4 sessions, 32 valid repetitions, 5 min active')).toBeTruthy();
    expect(screen.getByText('Reaches further.')).toBeTruthy();
    expect(screen.getByText(/Stopped because it hurt/)).toBeTruthy();
    expect(screen.getAllByText(/Telemotion 1\.2\.3/).length).toBeGreaterThan(0);
    const found = await axe.run(view.container, {
      rules: { 'color-contrast': { enabled: false }, region: { enabled: false } },
    });
    expect(found.violations.map((one) => one.id)).toEqual([]);
  });

  it('shows the saved words while others are written, and offers a draft beside them', async () => {
    sessionStorage.clear();
    writeDraft('a', 'course-note:p:e', 'Not saved.');
    const saved = () =>
      screen.getByText('Reaches further.', { selector: 'p' }).closest('.no-print, .print-only')?.className ?? 'shown';
    renderPage(<CoursePage />, { at: '/patients/p/report?exercise=e', path: '/patients/:patientId/report', answers });
    await userEvent.click(await screen.findByRole('button', { name: 'Change' }));
    expect(saved(), 'a print has them').toBe('print-only');
    await userEvent.click(screen.getByRole('button', { name: 'Cancel' }));
    expect(saved()).toBe('shown');
    expect(screen.queryByRole('textbox', { name: /What you think/ })).toBeNull();
    await userEvent.click(screen.getByRole('button', { name: 'Continue with it' }));
    expect(screen.getByRole<HTMLTextAreaElement>('textbox', { name: /What you think/ }).value).toBe('Not saved.');
    await userEvent.click(screen.getByRole('button', { name: 'Save' }));
    expect(await screen.findByRole('button', { name: 'Change' })).toBeTruthy();
    expect(readDraft('a', 'course-note:p:e')).toBeNull();
  });

  it('stores the words of who treats', async () => {
    const { asked } = renderPage(<CoursePage />, {
      at: '/patients/p/report?exercise=e',
      path: '/patients/:patientId/report',
      answers,
    });
    await userEvent.click(await screen.findByRole('button', { name: 'Change' }));
    const box = screen.getByRole('textbox', { name: /What you think/ });
    await userEvent.clear(box);
    await userEvent.type(box, 'Ready for the cup.');
    await userEvent.click(screen.getByRole('button', { name: 'Save' }));
    await waitFor(() =>
      expect(asked.find((one) => one.method === 'POST')).toMatchObject({
        path: '/api/patients/p/course-notes',
        body: { exercise_id: 'e', text: 'Ready for the cup.' },
      }),
    );
  });
});
