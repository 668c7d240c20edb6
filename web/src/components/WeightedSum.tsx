// The sum that the therapist defined on the template, with every part of it: no number that hides what it is made of.
import { useId } from 'react';
import type { WeightedSum as Sum } from '../api/types';
import { t } from '../i18n';
import { digitsFor, number, pair, plainTick, weighedQuantity } from '../lib/format';
import './WeightedSum.css';

const DIGITS = 2;
/** Weights are shown as they were typed. */
const WEIGHT_DIGITS = 3;

export function WeightedSum({ sum, isPaper }: { sum: Sum; isPaper?: boolean }) {
  const title = useId();
  // The sum, its parts and the template's have the same digits: they stand below each other.
  const digits = digitsFor(sum.uncertainty ?? 0, DIGITS);
  const [value, spread] =
    sum.value === null || sum.uncertainty === null
      ? [number(sum.value, digits)]
      : pair(sum.value, sum.uncertainty, DIGITS);
  const note = isPaper ? 'paper-note' : 'muted small';
  return (
    <section className={isPaper ? 'paper-sum' : 'sum-part'} aria-labelledby={title}>
      <h3 id={title}>{t('compare.sum')}</h3>
      <p className={note}>{t('compare.sumLead')}</p>
      <table className={isPaper ? 'paper-table weighted' : 'plain-table measures weighted stacked-table'}>
        <caption className="visually-hidden">{t('compare.sum')}</caption>
        <thead>
          <tr>
            <th scope="col">{t('compare.measure')}</th>
            <th scope="col" className="number">
              {t('compare.weight')}
            </th>
            <th scope="col" className="number">
              {t('compare.part')}
            </th>
          </tr>
        </thead>
        <tbody>
          {sum.parts.map((one) => (
            <tr key={one.measure}>
              <th scope="row">
                {one.label}
                <span className="measure-note muted small">
                  {weighedQuantity(one.value, one.unit)}
                  {one.template_value !== null &&
                    ` · ${t('design.weightTemplate', { value: weighedQuantity(one.template_value, one.unit) })}`}
                </span>
              </th>
              <td className="number" data-label={t('compare.weight')}>
                × {plainTick(one.weight, WEIGHT_DIGITS)}
              </td>
              <td className="number" data-label={t('compare.part')}>
                {number(one.part, digits)}
              </td>
            </tr>
          ))}
        </tbody>
        <tfoot>
          <tr>
            <th scope="row" colSpan={2}>
              {t('compare.sumOf')}
              {sum.count > 0 && (
                <span className="measure-note muted small">
                  {spread !== undefined && `± ${spread} `}
                  {t('compare.count', { count: sum.count })}
                </span>
              )}
              {sum.template_value !== null && (
                <span className="measure-note muted small">
                  {t('design.weightTemplate', { value: number(sum.template_value, digits) })}
                </span>
              )}
            </th>
            <td className="number strong" data-label={t('compare.thisSession')}>
              {value}
            </td>
          </tr>
        </tfoot>
      </table>
      {sum.value === null && <p className={note}>{t('compare.sumMissing')}</p>}
    </section>
  );
}
