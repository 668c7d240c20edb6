// Where the centre of mass was, how well that is known, and what nobody measured.
import { Fragment } from 'react';
import { useSeries } from '../../../api/queries';
import type { Series } from '../../../api/types';
import { QueryBoundary } from '../../../components/Feedback';
import { t } from '../../../i18n';
import { channelLabel, placementList } from '../../../lib/channels';
import { quantity, spreadAlone } from '../../../lib/format';
import { spreadOf } from '../../../lib/spread';

function Found({ found }: { found: Series }) {
  return (
    <>
      <dl className="facts">
        {found.curves.map((curve) => {
          const spread = spreadOf(curve.sigma ?? []);
          return (
            <Fragment key={curve.name}>
              <dt>{channelLabel(curve.name).text}</dt>
              <dd className="number">
                {curve.least === null || curve.most === null
                  ? t('mass.unknown')
                  : t('mass.range', {
                      low: quantity(curve.least, 'm'),
                      high: quantity(curve.most, 'm'),
                      sigma: spread ? `${spreadAlone(100 * spread.median, 1)} cm` : t('mass.unknown'),
                    })}
              </dd>
            </Fragment>
          );
        })}
      </dl>
      <p className="muted small">
        {found.unworn.length > 0
          ? t('mass.assumed', { places: placementList(found.unworn) })
          : t('mass.nothingAssumed')}
      </p>
      <p className="muted small">{t('mass.how')}</p>
    </>
  );
}

/** What the result says of the centre of mass in numbers and words. */
export function MassFacts({ sessionId, resultId }: { sessionId: string; resultId: string }) {
  const found = useSeries(sessionId, 'mass_centre', resultId);
  return (
    <QueryBoundary of={found} lines={4}>
      {(data) =>
        data.reasons.mass_centre ? <p className="muted">{data.reasons.mass_centre}</p> : <Found found={data} />
      }
    </QueryBoundary>
  );
}
