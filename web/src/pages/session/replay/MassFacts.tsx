// Where the centre of mass was, how well that is known, and what nobody measured.
import { Fragment } from 'react';
import { useMassCentre } from '../../../api/queries';
import type { MassCentre } from '../../../api/types';
import { Answer } from '../../../components/Feedback';
import { t } from '../../../i18n';
import { channelLabel, placementList } from '../../../lib/channels';
import { quantity } from '../../../lib/format';
import { spreadOf } from '../../../kinds/magnetic/magnetic';

function Found({ found }: { found: MassCentre }) {
  return (
    <>
      <dl className="facts">
        {found.curves.map((curve) => {
          const spread = spreadOf(curve.sigma_m);
          return (
            <Fragment key={curve.name}>
              <dt>{channelLabel(`centre_of_mass_${curve.name}_m`).text}</dt>
              <dd className="number">
                {curve.least_m === null || curve.most_m === null
                  ? t('mass.unknown')
                  : t('mass.range', {
                      low: quantity(curve.least_m, 'm'),
                      high: quantity(curve.most_m, 'm'),
                      sigma: spread ? quantity(spread.median, 'm') : t('mass.unknown'),
                    })}
              </dd>
            </Fragment>
          );
        })}
      </dl>
      <p className="muted small">
        {found.assumed.length > 0
          ? t('mass.assumed', { places: placementList(found.assumed) })
          : t('mass.nothingAssumed')}
      </p>
      <p className="muted small">{t('mass.how')}</p>
    </>
  );
}

/** What the result says of the centre of mass in numbers and words. */
export function MassFacts({ sessionId, resultId }: { sessionId: string; resultId: string }) {
  const found = useMassCentre(sessionId, resultId);
  return (
    <Answer of={found} lines={4}>
      {(data) => (data.reason ? <p className="muted">{data.reason}</p> : <Found found={data} />)}
    </Answer>
  );
}
