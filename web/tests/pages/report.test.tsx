import { describe, expect, it } from 'vitest';
import type { MeasureValue } from '../../src/api/types';
import { pathOf } from '../../src/charts/PaperChart';
import { niceTicks } from '../../src/charts/scales';
import { reportRows } from '../../src/lib/report';

const measure = (name: string, group: string, value: number | null = 1): MeasureValue => ({ measure: name, label: name, value, unit: 'rad', uncertainty: null, count: 3, template_value: null, group });

describe('rows of the report', () => {
  it('takes of each group before it takes more of one, and leaves out what is not known', () => {
    const summary = [measure('range:a', 'range'), measure('range:b', 'range'), measure('range:c', 'range'), measure('duration', 'timing'), measure('sparc', 'smoothness', null), measure('lean', 'compensation')];
    const rows = reportRows(summary, [], 4);
    expect(rows.map((row) => row.value.measure)).toEqual(['range:a', 'range:b', 'duration', 'lean']);
  });
  it('puts the progress of a measure beside it', () => {
    const over = { measure: 'duration', label: '', unit: 's', points: [], change: 1, minimal_detectable_change: 0.5, is_real_change: true };
    expect(reportRows([measure('duration', 'timing')], [over])[0]?.progress).toBe(over);
  });
});

describe('charts for paper', () => {
  it('have round ticks that span the range', () => {
    expect(niceTicks(37, 61, 4)).toEqual([30, 40, 50, 60, 70]);
    expect(niceTicks(-0.3, 0.3, 4)).toEqual([-0.4, -0.2, 0, 0.2, 0.4]);
    expect(niceTicks(5, 5, 4)).toEqual([5]);
  });
  it('leave gaps where nothing is known', () => {
    expect(pathOf([1, 2, null, 3], (index) => index, (value) => value)).toBe('M0.0 1.0L1.0 2.0M3.0 3.0');
  });
});
