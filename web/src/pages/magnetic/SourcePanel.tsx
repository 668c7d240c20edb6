// What the source of a stored session did: every pulse, what it cost, and the accuracy that it bought.
import { Fragment, useMemo } from 'react';
import { useSourceUse } from '../../api/queries';
import type { SourceUse } from '../../api/types';
import { LineChart } from '../../charts/LineChart';
import { Answer } from '../../components/Feedback';
import { t } from '../../i18n';
import { placementLabel } from '../../lib/channels';
import { number, quantity } from '../../lib/format';
import { spreadOf, type Pulse } from '../../lib/magnetic';
import { PulseTimeline } from './PulseTimeline';

function pulsesOf(use: SourceUse): Pulse[] {
  return use.start_s.map((startS, index) => ({
    startS,
    endS: startS + (use.length_s[index] ?? 0),
    coil: use.coil[index] ?? 0,
    currentA: use.current_a[index] ?? 0,
  }));
}

function Account({ use }: { use: SourceUse }) {
  const pulses = useMemo(() => pulsesOf(use), [use]);
  const charge = useMemo(() => [{ name: t('magnetic.charge'), x: use.time_s, y: use.charge_curve_as }], [use]);
  const sigma = useMemo(
    () =>
      Object.entries(use.sigma_m).map(([name, values]) => ({
        name: placementLabel(name),
        x: use.time_s,
        y: values.map((one) => (one === null ? null : 1000 * one)),
      })),
    [use],
  );
  return (
    <div className="stack">
      <section aria-labelledby="pulses">
        <h3 id="pulses">{t('magnetic.actuation')}</h3>
        <PulseTimeline pulses={pulses} fromS={0} untilS={use.duration_s} />
      </section>
      <section aria-labelledby="energy">
        <h3 id="energy">{t('magnetic.energy')}</h3>
        <dl className="facts">
          <dt>{t('magnetic.pulses')}</dt>
          <dd className="number">{number(use.pulse_count)}</dd>
          <dt>{t('magnetic.onTime')}</dt>
          <dd className="number">
            {quantity(use.on_time_s, 's')} · {t('magnetic.share', { percent: number((100 * use.on_time_s) / Math.max(use.duration_s, 1e-6), 1) })}
          </dd>
          <dt>{t('magnetic.charge')}</dt>
          <dd className="number">{`${number(use.charge_as, 2)} A s`}</dd>
          <dt>{t('magnetic.heat')}</dt>
          <dd className="number">{`${number(use.current_squared_a2s, 2)} A² s`}</dd>
          {Object.entries(use.sigma_m).map(([name, values]) => {
            const spread = spreadOf(values);
            return spread ? (
              <Fragment key={name}>
                <dt>{t('magnetic.sigma', { place: placementLabel(name) })}</dt>
                <dd className="number">{t('magnetic.sigmaText', { median: quantity(spread.median, 'm'), worst: quantity(spread.worst, 'm') })}</dd>
              </Fragment>
            ) : null;
          })}
          {Object.entries(use.inertial_only_s)
            .filter(([, seconds]) => seconds > 0)
            .map(([name, seconds]) => (
              <Fragment key={name}>
                <dt>{t('magnetic.alone', { place: placementLabel(name) })}</dt>
                <dd className="number">{quantity(seconds, 's')}</dd>
              </Fragment>
            ))}
        </dl>
      </section>
      <LineChart lines={charge} xTitle={t('magnetic.timeAxis')} yTitle={t('magnetic.chargeAxis')} label={t('magnetic.chargeChart')} height={170} />
      <LineChart lines={sigma} xTitle={t('magnetic.timeAxis')} yTitle={t('magnetic.sigmaAxis')} label={t('magnetic.sigmaChart')} height={190} />
    </div>
  );
}

export function SourcePanel({ sessionId, resultId }: { sessionId: string; resultId: string | null }) {
  const use = useSourceUse(sessionId, resultId);
  return (
    <>
      <h2 className="visually-hidden">{t('magnetic.title')}</h2>
      <Answer of={use} lines={6}>
        {(data) => <Account use={data} />}
      </Answer>
    </>
  );
}
