// The footprints of a walk with the ways of the centre of mass and of pressure, and where the mass leans.
import { Checkbox, Group } from '@mantine/core';
import { useState } from 'react';
import type { Gait } from '../../../api/types';
import { FootprintMap, MapLegend, type MapParts } from '../../../charts/FootprintMap';
import { t } from '../../../i18n';
import { number, quantity } from '../../../lib/format';
import { isOutside, isWhole, leaning } from '../gait';
import type { ChosenStride } from './StrideTable';

const LEANS = [
  ['centre_to_left_standing', 'standing'],
  ['centre_to_left', 'walking'],
] as const;
const PARTS = ['mass', 'pressure', 'support'] as const;

export function MapCard({ gait, selected }: { gait: Gait; selected: ChosenStride | null }) {
  const [parts, setParts] = useState<MapParts>({ mass: true, pressure: true, support: false });
  const { balance } = gait;
  const leans = LEANS.flatMap(([name, when]) => (balance ? [{ when, lean: leaning(balance.measures, name) }] : []));
  return (
    <section className="card" aria-labelledby="footprints">
      <div className="card-head">
        <h2 id="footprints">{t('map.title')}</h2>
        {balance && (
          <Group className="end" gap="md" role="group" aria-label={t('map.show')}>
            {PARTS.map((part) => (
              <Checkbox
                key={part}
                label={t(`map.${part}`)}
                checked={parts[part]}
                onChange={(event) => setParts({ ...parts, [part]: event.currentTarget.checked })}
              />
            ))}
          </Group>
        )}
      </div>
      <FootprintMap gait={gait} parts={parts} selected={selected} />
      <MapLegend hasBalance={balance !== null} />
      {!isWhole(gait) && (
        <p className="muted small">
          {t('map.beginning', { count: Math.max(...gait.feet.map((foot) => foot.strides.length)) })}
        </p>
      )}
      {gait.feet.some((foot) => foot.strides.some(isOutside)) && <p className="muted small">{t('map.outside')}</p>}
      {balance && (
        <>
          <p className="strong">{t('balance.where')}</p>
          <ul>
            {leans.map(
              ({ when, lean }) =>
                lean && (
                  <li key={when}>
                    {lean.side === 'middle'
                      ? t(`balance.${when}.middle`)
                      : t(`balance.${when}.${lean.side}`, { distance: lean.distance })}
                  </li>
                ),
            )}
          </ul>
          <p className="muted small">{t('balance.mass', { mass: number(balance.mass_kg, 1) })}</p>
        </>
      )}
      {balance ? (
        <p className="muted small">
          {t(`map.apart.${balance.apart_source}`, { width: quantity(balance.apart_m, 'm') })}
        </p>
      ) : (
        !gait.has_step_width && gait.feet.length > 1 && <p className="muted small">{t('map.drawnApart')}</p>
      )}
    </section>
  );
}
