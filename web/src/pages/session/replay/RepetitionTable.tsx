import { Button } from '@mantine/core';
import measures from '../../../api/measures.json';
import type { ComparisonDetail, MeasureValue } from '../../../api/types';
import { t } from '../../../i18n';
import { isOfStrides, primaryChannel } from '../../../lib/assessment/comparison';
import { quantity, uncertain } from '../../../lib/format';

/** The main measures of a repetition; a beginning of names gives one of them, or two kinds of compensation. */
function columnsOf(summary: readonly MeasureValue[]): MeasureValue[] {
  const primary = primaryChannel(summary);
  return measures.repetition.main.flatMap((start) => {
    const found = summary.filter((one) =>
      start.endsWith(':') ? one.measure.startsWith(start) : one.measure === start,
    );
    if (start === 'range:')
      return found.filter((one) => primary === null || one.measure === `range:${primary}`).slice(0, 1);
    return found.slice(0, start === 'compensation:' ? 2 : 1);
  });
}

/** One line a repetition: each number with its unit and uncertainty, and last the summary with its count. */
export function RepetitionTable({
  comparison,
  selected,
  onSelect,
}: {
  comparison: ComparisonDetail;
  selected: number | null;
  onSelect: (repetition: number) => void;
}) {
  const columns = columnsOf(comparison.summary);
  const areStrides = isOfStrides(comparison);
  return (
    <section className="card" aria-labelledby="by-repetition">
      <div className="card-head">
        <h2 id="by-repetition">{t(areStrides ? 'repetition.tableStrides' : 'repetition.table')}</h2>
      </div>
      {/* eslint-disable-next-line jsx-a11y/no-noninteractive-tabindex -- a scrolling region must be reachable by keyboard */}
      <div className="table-scroll" role="group" aria-labelledby="by-repetition" tabIndex={0}>
        <table className="plain-table wide-table stacked-table">
          <thead>
            <tr>
              <th scope="col">{t(areStrides ? 'repetition.oneStride' : 'repetition.one')}</th>
              {columns.map((column) => (
                <th scope="col" key={column.measure}>
                  {column.label}
                </th>
              ))}
            </tr>
          </thead>
          <tbody>
            {comparison.repetitions.map((one, index) => (
              <tr
                key={one.repetition.number}
                className={`${one.repetition.is_kept ? '' : 'row-left-out'} ${selected === index ? 'row-selected' : ''}`}
              >
                <th scope="row">
                  <Button
                    size="compact-md"
                    variant={selected === index ? 'filled' : 'default'}
                    onClick={() => onSelect(index)}
                    aria-label={t(areStrides ? 'repetition.showStride' : 'repetition.show', {
                      number: one.repetition.number,
                    })}
                  >
                    {one.repetition.number}
                  </Button>
                  {!one.repetition.is_kept && (
                    <span className="muted small"> {one.repetition.reason || t('repetition.leftOut')}</span>
                  )}
                  {one.repetition.counted === 'partial' && (
                    <span className="muted small"> {t('repetition.partial')}</span>
                  )}
                </th>
                {columns.map((column) => {
                  const value = one.measures.find((measure) => measure.measure === column.measure);
                  return (
                    <td className="number" key={column.measure} data-label={column.label}>
                      {value ? uncertain(value.value ?? null, value.uncertainty ?? null, value.unit) : '–'}
                    </td>
                  );
                })}
              </tr>
            ))}
          </tbody>
          <tfoot>
            <tr>
              <th scope="row">
                {t(areStrides ? 'repetition.meanStrides' : 'repetition.mean', { count: comparison.repetition_count })}
              </th>
              {columns.map((column) => (
                <td className="number strong" key={column.measure} data-label={column.label}>
                  {uncertain(column.value ?? null, column.uncertainty ?? null, column.unit)}
                </td>
              ))}
            </tr>
            <tr>
              <th scope="row">{t('compare.template')}</th>
              {columns.map((column) => (
                <td className="number muted" key={column.measure} data-label={column.label}>
                  {quantity(column.template_value, column.unit)}
                </td>
              ))}
            </tr>
          </tfoot>
        </table>
      </div>
      <p className="muted small">{t('repetition.tableHelp')}</p>
    </section>
  );
}
