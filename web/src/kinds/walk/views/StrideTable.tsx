// Every stride of both feet in the order of time; choosing one marks its footprints in the map.
import { Button } from '@mantine/core';
import { useMemo } from 'react';
import { useStrides } from '../../../api/queries';
import type { Gait, Stride } from '../../../api/types';
import { Problem, ShowMore } from '../../../components/Feedback';
import { Measured } from '../../../components/Measured';
import { t } from '../../../i18n';
import { number } from '../../../lib/format';
import { isOutside, isWhole, measureText, strideCount } from '../gait';
import './StrideTable.css';

export interface ChosenStride {
  side: 'left' | 'right';
  number: number;
}

const TURNING_RAD = 0.35;

const COLUMNS = [
  { name: 'strides.length', text: (one: Stride) => measureText(one.length_m, 'm', one.length_sigma_m) },
  { name: 'strides.time', text: (one: Stride) => measureText(one.duration_s, 's') },
  { name: 'strides.stance', text: (one: Stride) => measureText(one.stance_s, 's') },
  { name: 'strides.swing', text: (one: Stride) => measureText(one.swing_s, 's') },
  { name: 'strides.clearance', text: (one: Stride) => measureText(one.clearance_m, 'm') },
  { name: 'strides.contact', text: (one: Stride) => measureText(one.contact_pitch_rad, 'rad') },
  { name: 'strides.toeOut', text: (one: Stride) => measureText(one.toe_out_rad, 'rad') },
  { name: 'strides.turn', text: (one: Stride) => measureText(one.turn_rad, 'rad') },
] as const;

function counts(stride: Stride): string {
  if (stride.is_counted) return t('strides.yes');
  if (isOutside(stride)) return t('strides.outside');
  if (stride.is_initiation) return t('strides.first');
  if (stride.is_termination) return t('strides.last');
  return Math.abs(stride.turn_rad ?? 0) > TURNING_RAD ? t('strides.turning') : '–';
}

export function StrideTable({
  gait,
  selected,
  onSelect,
}: {
  gait: Gait;
  selected: ChosenStride | null;
  onSelect: (stride: ChosenStride | null) => void;
}) {
  const whole = isWhole(gait);
  const pages = useStrides(gait.session_id, gait.result.id, !whole);
  const rows = useMemo(
    () =>
      whole
        ? gait.feet
            .flatMap((foot) => foot.strides.map((stride) => ({ side: foot.side, stride })))
            .sort((a, b) => (a.stride.contact_s ?? 0) - (b.stride.contact_s ?? 0))
        : (pages.data ?? []).map((stride) => ({ side: stride.side, stride })),
    [gait, whole, pages.data],
  );
  return (
    <section className="card" aria-labelledby="strides">
      <div className="card-head">
        <h2 id="strides">{t('strides.title')}</h2>
        {!whole && (
          <span className="muted end">
            {t('strides.shown', { shown: number(rows.length), count: number(strideCount(gait)) })}
          </span>
        )}
      </div>
      {!whole && rows.length === 0 && pages.error && <Problem error={pages.error} />}
      {/* eslint-disable-next-line jsx-a11y/no-noninteractive-tabindex -- a scrolling region must be reachable by keyboard */}
      <div className="table-scroll stride-scroll" role="group" aria-labelledby="strides" tabIndex={0}>
        <table className="plain-table stacked-table stride-table">
          <thead>
            <tr>
              <th scope="col">{t('strides.number')}</th>
              <th scope="col">{t('strides.foot')}</th>
              {COLUMNS.map(({ name }) => (
                <th scope="col" key={name}>
                  {t(name)}
                </th>
              ))}
              <th scope="col">{t('strides.counts')}</th>
            </tr>
          </thead>
          <tbody>
            {rows.map(({ side, stride }) => {
              const isSelected = selected?.side === side && selected.number === stride.number;
              return (
                <tr
                  key={`${side}${stride.number}`}
                  className={isSelected ? 'row-selected' : stride.is_counted ? '' : 'row-left-out'}
                >
                  <th scope="row">
                    <Button
                      size="compact-md"
                      variant={isSelected ? 'filled' : 'default'}
                      aria-pressed={isSelected}
                      aria-label={t('strides.select', { side: t(`numbers.${side}`), number: stride.number })}
                      onClick={() => onSelect(isSelected ? null : { side, number: stride.number })}
                    >
                      {stride.number}
                    </Button>
                  </th>
                  <td data-label={t('strides.foot')}>{t(`numbers.${side}`)}</td>
                  {COLUMNS.map(({ name, text }) => (
                    <td key={name} data-label={t(name)}>
                      <Measured text={text(stride)} />
                    </td>
                  ))}
                  <td data-label={t('strides.counts')}>{counts(stride)}</td>
                </tr>
              );
            })}
          </tbody>
        </table>
        {!whole && <ShowMore of={pages} />}
      </div>
    </section>
  );
}
