import { Button, SegmentedControl } from '@mantine/core';
import { Fragment, useState } from 'react';
import measures from '../../../api/measures.json';
import type { ComparisonDetail, MeasureValue } from '../../../api/types';
import { Measured } from '../../../components/Measured';
import { t } from '../../../i18n';
import { isOfStrides, primaryChannel } from '../../../lib/assessment/comparison';
import { quantity, uncertain } from '../../../lib/format';
import './RepetitionTable.css';

/** So many columns have room beside each other on a tablet. */
const MOST_BESIDE = 7;

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

type Part = 'main' | 'movement';

/** What a column is of: what a therapist asks first, or how the hand went there. */
const partOf = (column: MeasureValue): Part =>
  ['smoothness', 'coordination', 'path'].includes(column.group) ? 'movement' : 'main';

function Value({ of }: { of: MeasureValue | undefined }) {
  return <Measured text={of ? uncertain(of.value ?? null, of.uncertainty ?? null, of.unit) : '–'} />;
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
  // Where all columns have no room beside each other, a switch shows one part of them: nobody scrolls to the side.
  const [part, setPart] = useState<Part>('main');
  const hasParts = columns.length > MOST_BESIDE && new Set(columns.map(partOf)).size > 1;
  const inPart = (column: MeasureValue) => (hasParts && partOf(column) !== part ? 'column-folded' : '');
  return (
    <section className="card" aria-labelledby="by-repetition">
      <div className="card-head">
        <h2 id="by-repetition">{t(areStrides ? 'repetition.tableStrides' : 'repetition.table')}</h2>
        {hasParts && (
          <SegmentedControl
            className="end column-parts"
            aria-label={t('repetition.parts')}
            value={part}
            onChange={(value) => setPart(value as Part)}
            data={[
              { value: 'main', label: t('repetition.partMain') },
              { value: 'movement', label: t('repetition.partMovement') },
            ]}
          />
        )}
      </div>
      {/* eslint-disable-next-line jsx-a11y/no-noninteractive-tabindex -- a scrolling region must be reachable by keyboard */}
      <div className="table-scroll" role="group" aria-labelledby="by-repetition" tabIndex={0}>
        <table className="plain-table wide-table stacked-table">
          <thead>
            <tr>
              <th scope="col">{t(areStrides ? 'repetition.oneStride' : 'repetition.one')}</th>
              {columns.map((column) => (
                <th scope="col" key={column.measure} className={inPart(column)}>
                  {column.label}
                </th>
              ))}
            </tr>
          </thead>
          <tbody>
            {comparison.repetitions.map((one, index) => {
              const said = [
                ...(one.repetition.is_kept ? [] : [one.repetition.reason || t('repetition.leftOut')]),
                ...(one.repetition.counted === 'partial' ? [t('repetition.partial')] : []),
              ].join(' · ');
              const look = `${one.repetition.is_kept ? '' : 'row-left-out'} ${selected === index ? 'row-selected' : ''}`;
              return (
                <Fragment key={one.repetition.number}>
                  <tr className={`${look} ${said ? 'row-explained' : ''}`}>
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
                    </th>
                    {columns.map((column) => (
                      <td className={inPart(column)} key={column.measure} data-label={column.label}>
                        <Value of={one.measures.find((measure) => measure.measure === column.measure)} />
                      </td>
                    ))}
                  </tr>
                  {said && (
                    <tr className={look}>
                      <td className="row-said small" colSpan={1 + columns.filter((column) => !inPart(column)).length}>
                        {said}
                      </td>
                    </tr>
                  )}
                </Fragment>
              );
            })}
          </tbody>
          <tfoot>
            <tr>
              <th scope="row">
                {t(areStrides ? 'repetition.meanStrides' : 'repetition.mean', { count: comparison.repetition_count })}
              </th>
              {columns.map((column) => (
                <td className={`strong ${inPart(column)}`} key={column.measure} data-label={column.label}>
                  <Value of={column} />
                </td>
              ))}
            </tr>
            <tr>
              <th scope="row">{t('compare.template')}</th>
              {columns.map((column) => (
                <td className={`number muted ${inPart(column)}`} key={column.measure} data-label={column.label}>
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
