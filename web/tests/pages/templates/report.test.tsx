import { act, render } from '@testing-library/react';
import { afterEach, describe, expect, it, vi } from 'vitest';
import type { ComparisonDetail, MeasureValue, ProgressMeasure } from '../../../src/api/types';
import { Chart } from '../../../src/charts/ChartFrame';
import { lineOf } from '../../../src/charts/marks';
import { joined, PhaseChart } from '../../../src/charts/PhaseChart';
import { repetitionsText, reportRows } from '../../../src/lib/assessment/report';
import { verdict, verdictText } from '../../../src/pages/report/SummarySheet';
import { changed, trend } from '../../trend';

const measure = (name: string, group: string, value: number | null = 1): MeasureValue => ({
  measure: name,
  label: name,
  value,
  unit: 'rad',
  uncertainty: null,
  count: 3,
  template_value: null,
  group,
});

describe('rows of the report', () => {
  it('takes of each group before it takes more of one, and leaves out what is not known', () => {
    const summary = [
      measure('range:a', 'range'),
      measure('range:b', 'range'),
      measure('range:c', 'range'),
      measure('duration', 'timing'),
      measure('sparc', 'smoothness', null),
      measure('lean', 'compensation'),
    ];
    const rows = reportRows(summary, [], 4);
    expect(rows.map((row) => row.value.measure)).toEqual(['range:a', 'range:b', 'duration', 'lean']);
    const ofKnee = reportRows(summary, [], 4, 'range:c');
    expect(ofKnee.map((row) => row.value.measure)).toEqual(['range:c', 'range:a', 'duration', 'lean']);
  });
  it('puts the progress of a measure beside it', () => {
    const over = {
      measure: 'duration',
      label: '',
      unit: 's',
      points: [],
      trend: trend(),
      bands: [],
    };
    expect(reportRows([measure('duration', 'timing')], [over])[0]?.progress).toBe(over);
  });
});

describe('repetitions of the report', () => {
  const made = (counted: string[], evaluated: number) =>
    repetitionsText({
      repetition_count: evaluated,
      repetitions: counted.map((one, index) => ({ repetition: { number: index + 1, counted: one } })),
    } as unknown as ComparisonDetail);
  it('are stated once where all that were counted were evaluated', () => {
    expect(made(['valid', 'partial'], 2)).toBe('1 of 2 valid; not far enough: 2');
    expect(made(['valid', 'partial'], 1)).toBe('1 of 2 valid; not far enough: 2 · 1 repetition evaluated');
    expect(made(['', ''], 2)).toBe('2 repetitions evaluated');
  });
});

describe('charts for paper', () => {
  const numbers = (domain: [number, number], isLogarithmic = false) => {
    const axis = { domain, text: String, isRound: true, isLogarithmic };
    const margin = { top: 0, right: 0, bottom: 0, left: 0 };
    const { container } = render(
      <Chart label="" width={200} height={200} margin={margin} x={{ domain: [0, 1] }} y={axis}>
        {() => null}
      </Chart>,
    );
    return [...container.querySelectorAll('text')].map((one) => Number(one.textContent));
  };
  it('have round numbers that span the range', () => {
    expect(numbers([37, 61])).toEqual([30, 40, 50, 60, 70]);
    expect(numbers([-0.3, 0.3])).toEqual([-0.4, -0.2, 0, 0.2, 0.4]);
    expect(numbers([5, 5])).toEqual([5]);
    expect(numbers([2, 90], true)).toEqual([1, 10, 100]);
  });
  it('leave gaps where nothing is known', () => {
    expect(
      lineOf(
        [1, 2, null, 3],
        (index) => index,
        (value) => value,
      ),
    ).toBe('M0,1L1,2M3,3Z');
  });
});

describe('what changed', () => {
  const over: ProgressMeasure = {
    measure: 'inside_band',
    label: '',
    unit: '%',
    points: [],
    trend: changed(50.2, 78.4, 9),
    bands: [],
  };
  it('is said of a session that was compared, in percentage points', () => {
    const at = {
      session_id: 'd',
      at: '',
      value: 50,
      low: 49,
      high: 51,
      count: 5,
      orientation: '',
      template_version_id: null,
    };
    const here = { ...over, points: [at] };
    expect(verdict(here, 'd')).toBe('+28 percentage points ± 9');
    expect(verdictText(here)).toMatch(/^\+28 percentage points ± 9 since 1 Jan/);
    expect(verdict(here, 'a')).toBe('–');
  });
});

/** Pictures that are measured as this wide. */
function measuredAs(width: number): void {
  vi.stubGlobal(
    'ResizeObserver',
    class {
      constructor(private readonly seen: ResizeObserverCallback) {}
      observe() {
        const entry = { contentRect: { x: 0, y: 0, width, height: 210, top: 0, left: 0, bottom: 210, right: width } };
        this.seen([entry as ResizeObserverEntry], this as unknown as ResizeObserver);
      }
      unobserve() {}
      disconnect() {}
    },
  );
}

describe('on paper', () => {
  afterEach(() => vi.unstubAllGlobals());
  it('marks what is outside the band by colour, thickness and a bar with ends', () => {
    const flat = Array.from({ length: 101 }, () => 0);
    const curve = {
      channel: 'trunk_lean_forward_rad',
      label: 'Trunk lean',
      unit: 'rad',
      mean: flat,
      low: flat.map(() => -0.05),
      high: flat.map(() => 0.05),
      repetitions: [flat.map((_, phase) => (phase > 40 && phase < 60 ? 0.1 : 0)), flat],
    };
    const outside = [
      { repetition: 0, number: 1, from: 41, until: 60 },
      { repetition: 1, number: 2, from: 55, until: 70 },
    ];
    measuredAs(0);
    const { container } = render(<PhaseChart isOnPaper curve={curve} left={new Set()} outside={outside} />);
    expect(container.querySelectorAll('.chart-outside')).toHaveLength(2);
    // Two stretches that overlap are one bar.
    expect(container.querySelectorAll('.chart-outside-bar')).toHaveLength(1);
    expect(joined(outside)).toEqual([{ from: 41, until: 70 }]);
  });
  it.each([
    [316, '0 0 316 210'],
    [500, '0 0 380 210'],
    [0, '0 0 380 210'],
  ])('is drawn as wide as its place, %i px, so that its words are not shrunk', async (width, view) => {
    measuredAs(width);
    const values = Array.from({ length: 101 }, (_, phase) => phase);
    const curve = { channel: 'a', label: 'A', unit: 'deg', mean: values, low: values, high: values, repetitions: [] };
    const { container } = render(<PhaseChart isOnPaper curve={curve} left={new Set()} />);
    await act(() => new Promise((done) => requestAnimationFrame(() => done(undefined))));
    expect(container.querySelector('svg')?.getAttribute('viewBox')).toBe(view);
    const last = [...container.querySelectorAll('text')].find((one) => one.textContent === '100 %');
    expect(Number(last?.getAttribute('x'))).toBeLessThanOrEqual(Number(view.split(' ')[2]));
  });
});
