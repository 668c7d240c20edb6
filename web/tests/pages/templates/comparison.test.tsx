// The measures of a comparison: units, uncertainty and count beside each number, and a reason where there is none.
import { screen, within } from '@testing-library/react';
import userEvent from '@testing-library/user-event';
import axe from 'axe-core';
import { describe, expect, it } from 'vitest';
import type { ComparisonDetail, MeasureValue, SessionDetail } from '../../../src/api/types';
import { ComparisonPanel } from '../../../src/pages/session/replay/ComparisonPanel';
import { renderPage } from '../render';

const measure = (change: Partial<MeasureValue>): MeasureValue => ({
  measure: 'joint_correlation',
  label: 'Shoulder and elbow together (correlation)',
  value: 0.91,
  unit: '1',
  uncertainty: 0.04,
  count: 4,
  template_value: 0.98,
  group: 'coordination',
  note: '',
  ...change,
});

const UNDEFINED = 'Undefined: the repetitions differ by 9° from their mean, too much for a movement of 4°.';

const open = () =>
  renderPage(
    <ComparisonPanel
      session={{ id: 's' } as SessionDetail}
      resultId="r"
      hasComparison
      selected={null}
      onSelect={() => undefined}
      onPhase={() => undefined}
      comparison={
        {
          id: 'c',
          template_name: 'Reach',
          repetition_count: 4,
          repetitions: [{ repetition: { number: 1, is_kept: true }, measures: [], outside_band: {} }],
          curves: [],
          findings: ['Compensation: the shoulder rose 5.0 cm more than in the template.'],
          summary: [
            measure({}),
            measure({ measure: 'joint_lag', label: 'Elbow behind shoulder', value: 62, uncertainty: 8, unit: 'ms' }),
            measure({
              measure: 'multiple_correlation:a',
              label: 'Elbow flexion, consistency (CMC)',
              group: 'shape',
              value: null,
              uncertainty: null,
              note: UNDEFINED,
            }),
          ],
          weighted_sum: {
            value: 71.25,
            uncertainty: 4.5,
            count: 3,
            template_value: 78.5,
            parts: [
              {
                measure: 'range:a',
                label: 'Elbow flexion, range of motion',
                unit: 'deg',
                weight: 1.5,
                value: 50,
                part: 75,
                template_value: 54,
                template_part: 81,
              },
              {
                measure: 'duration',
                label: 'Duration',
                unit: 's',
                weight: -1.25,
                value: 3,
                part: -3.75,
                template_value: 2,
                template_part: -2.5,
              },
            ],
          },
          other_side: [
            {
              measure: 'range:a',
              label: 'Elbow flexion, range of motion',
              unit: 'rad',
              value: (40 * Math.PI) / 180,
              other_value: (50 * Math.PI) / 180,
              other_count: 2,
              symmetry_ratio: Math.log(0.8),
              symmetry_ratio_sigma: 0.03,
              symmetry_angle_percent: -7.04,
            },
          ],
        } as unknown as ComparisonDetail
      }
    />,
    { answers: {} },
  );

describe('the measures of a comparison', () => {
  it('stand beside those of the other side, with how alike both are', async () => {
    open();
    await userEvent.click(screen.getByText('Beside the other side', { selector: 'summary' }));
    const table = within(screen.getByRole('table', { name: 'Beside the other side' }));
    const row = within(table.getByRole('row', { name: /Elbow flexion/ }));
    expect(row.getByText('On the affected side it is 20 % ± 2 % less (symmetry angle −7.0 %)')).toBeTruthy();
    expect(row.getByText('40°')).toBeTruthy();
    expect(row.getByText(/50°/)).toBeTruthy();
  });

  it('are summed as the therapist weighed them, with every part in sight', () => {
    open();
    const table = within(screen.getByRole('table', { name: 'Weighted sum' }));
    const text = (name: RegExp) => table.getByRole('row', { name }).textContent;
    expect(text(/Elbow flexion/)).toBe('Elbow flexion, range of motion50° · template: 54°× 1.575.00');
    expect(text(/Duration/)).toBe('Duration3.0 s · template: 2.0 s× −1.25−3.75');
    expect(text(/^Sum/)).toBe('Sum± 4.50 (mean of 3)template: 78.5071.25');
  });

  it('have unit, uncertainty and count, and say why one is undefined', async () => {
    open();
    await userEvent.click(screen.getByText('All measures', { selector: 'summary' }));
    const text = (name: RegExp) => screen.getByRole('row', { name }).textContent;
    expect(text(/correlation\)/)).toContain('0.91 ± 0.04 (mean of 4)');
    expect(text(/Elbow behind/)).toContain('62 ms ± 8 (mean of 4)');
    const without = screen.getByRole('row', { name: /onsistency/ });
    expect(without.textContent).toContain(UNDEFINED);
    expect(within(without).queryByText('0')).toBeNull();
    expect(without.textContent).not.toContain('mean of');
    expect(screen.getByRole('rowheader', { name: 'Shoulder and elbow together' })).toBeTruthy();
    const { violations } = await axe.run(document.body, {
      rules: { 'color-contrast': { enabled: false }, region: { enabled: false } },
    });
    expect(violations.map((one) => one.id)).toEqual([]);
  });
});
