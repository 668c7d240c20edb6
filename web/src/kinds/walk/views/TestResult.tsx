// The result of a walking test in large figures, with what the sensors could not tell.
import type { Gait } from '../../../api/types';
import { t } from '../../../i18n';
import { number, pair } from '../../../lib/format';
import './views.css';
import './TestResult.css';

function Figure({ name, value, more }: { name: string; value: string; more?: string }) {
  return (
    <div className="figure-large">
      <dt>{name}</dt>
      <dd>
        <span className="number">{value}</span> {more && <span className="muted small number">{more}</span>}
      </dd>
    </div>
  );
}

export function TestResult({ gait }: { gait: Gait }) {
  const { test } = gait;
  const [distance, spread] = test ? pair(test.distance_m, test.distance_sigma_m, test.distance_m < 100 ? 2 : 0) : [];
  const reasons = [...(test?.reasons ?? []), ...gait.reasons];
  return (
    <section className="card" aria-labelledby="test-result">
      <div className="card-head">
        <h2 id="test-result">{test ? t(`walk.kind.${test.kind}`) : t('walk.result')}</h2>
        <span className="muted small">{t('walk.fromFirstStep')}</span>
      </div>
      {test && (
        <dl className="figures-large">
          <Figure name={t('walk.time')} value={`${number(test.time_s, 1)} s`} />
          <Figure name={t('walk.distance')} value={`${distance} m`} more={`± ${spread}`} />
          <Figure name={t('walk.speed')} value={`${number(test.speed_mps, 2)} m/s`} />
          <Figure name={t('walk.steps')} value={number(test.step_count)} />
          <Figure name={t('walk.turns')} value={number(test.turn_count)} />
          {test.turn_s !== null && <Figure name={t('walk.turning')} value={`${number(test.turn_s, 1)} s`} />}
          {test.pause_count > 0 && <Figure name={t('walk.pauses')} value={number(test.pause_count)} />}
        </dl>
      )}
      {test && test.kind === 'six_minute_walk' && (
        <>
          <p className="strong">{t('walk.minutes')}</p>
          <ol className="minute-bars plain-list">
            {test.minutes_m.map((metres, index) => (
              <li key={index}>
                <span className="small">{t('walk.minute', { number: index + 1 })}</span>
                <span
                  className="minute-bar"
                  style={{ width: `${(100 * metres) / Math.max(1, ...test.minutes_m)}%` }}
                  aria-hidden
                />
                <span className="number">{number(metres)} m</span>
              </li>
            ))}
          </ol>
        </>
      )}
      {reasons.length > 0 && (
        <>
          <p className="muted small">{t('walk.limits')}</p>
          <ul className="small">
            {reasons.map((reason) => (
              <li key={reason}>{reason}</li>
            ))}
          </ul>
        </>
      )}
    </section>
  );
}
