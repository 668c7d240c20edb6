// A stored session with a source: how far apart, how exactly that is known, every pulse, and what they cost.
import { Fragment, useMemo } from 'react';
import { useSourceUse } from '../../api/queries';
import type { SourceUse } from '../../api/types';
import { LineChart } from '../../charts/LineChart';
import { Traces } from '../../charts/Traces';
import { QueryBoundary } from '../../components/Feedback';
import { t } from '../../i18n';
import { placementLabel } from '../../lib/channels';
import { number, quantity, spreadAlone } from '../../lib/format';
import { spreadOf } from '../../lib/spread';
import { SIGMAS, milliampereHours, type Pulse } from './magnetic';
import { useClockText } from '../../player/hooks';
import type { ReplayPlayer } from '../../player/replay';
import { BenchPanel } from './BenchPanel';
import { PulseTimeline } from './PulseTimeline';

const spreadText = (sigmaM: number) => `${spreadAlone(100 * SIGMAS * sigmaM, 1)} cm`;

/** Times count from the beginning of what is replayed. */
function pulsesOf(use: SourceUse, zeroS: number): Pulse[] {
  return use.start_s.map((startS, index) => ({
    startS: startS - zeroS,
    endS: startS - zeroS + (use.length_s[index] ?? 0),
    coil: use.coil[index] ?? 0,
    currentA: use.current_a[index] ?? 0,
  }));
}

function Pulses({ use, player }: { use: SourceUse; player: ReplayPlayer }) {
  const { startS, endS } = player.clock();
  const pulses = useMemo(() => pulsesOf(use, startS), [use, startS]);
  const timeS = useClockText(player);
  return <PulseTimeline pulses={pulses} fromS={0} untilS={endS - startS} nowS={timeS - startS} />;
}

function Exactness({ use, zeroS }: { use: SourceUse; zeroS: number }) {
  const sigma = useMemo(
    () =>
      Object.entries(use.sigma_m).map(([name, values]) => ({
        name: placementLabel(name),
        x: use.time_s.map((at) => at - zeroS),
        y: values.map((one) => (one === null ? null : 1000 * SIGMAS * one)),
      })),
    [use, zeroS],
  );
  return (
    <section aria-labelledby="exactness">
      <h3 id="exactness">{t('magnetic.exactness')}</h3>
      <dl className="facts">
        {Object.entries(use.sigma_m).map(([name, values]) => {
          const spread = spreadOf(values);
          const aloneS = use.inertial_only_s[name] ?? 0;
          return (
            <Fragment key={name}>
              {spread && (
                <>
                  <dt>{t('magnetic.sigma', { place: placementLabel(name) })}</dt>
                  <dd className="number">
                    {t('magnetic.sigmaText', {
                      median: spreadText(spread.median),
                      worst: spreadText(spread.worst),
                    })}
                  </dd>
                </>
              )}
              {aloneS > 0 && (
                <>
                  <dt>{t('magnetic.alone', { place: placementLabel(name) })}</dt>
                  <dd className="number">{quantity(aloneS, 's')}</dd>
                </>
              )}
            </Fragment>
          );
        })}
      </dl>
      <LineChart
        lines={sigma}
        xTitle={t('magnetic.timeAxis')}
        yTitle={t('magnetic.sigmaAxis')}
        label={t('magnetic.sigmaChart')}
        height={190}
      />
    </section>
  );
}

function Energy({ use, zeroS }: { use: SourceUse; zeroS: number }) {
  const charge = useMemo(
    () => [
      {
        name: t('magnetic.charge'),
        x: use.time_s.map((at) => at - zeroS),
        y: use.charge_curve_as.map(milliampereHours),
      },
    ],
    [use, zeroS],
  );
  return (
    <section aria-labelledby="energy">
      <h3 id="energy">{t('magnetic.energy')}</h3>
      <dl className="facts">
        <dt>{t('magnetic.pulses')}</dt>
        <dd className="number">{number(use.pulse_count)}</dd>
        <dt>{t('magnetic.onTime')}</dt>
        <dd className="number">
          {quantity(use.on_time_s, 's')} ·{' '}
          {t('magnetic.share', { percent: number((100 * use.on_time_s) / Math.max(use.duration_s, 1e-6), 1) })}
        </dd>
        <dt>{t('magnetic.charge')}</dt>
        <dd className="number">{`${number(milliampereHours(use.charge_as), 2)} mAh`}</dd>
      </dl>
      <LineChart
        lines={charge}
        xTitle={t('magnetic.timeAxis')}
        yTitle={t('magnetic.chargeAxis')}
        label={t('magnetic.chargeChart')}
        height={170}
      />
      {/* Of the makers of coils: what it means in degrees depends on the coil. */}
      <details className="as-table">
        <summary>{t('magnetic.forMakers')}</summary>
        <p className="small">{t('magnetic.heat', { load: `${number(use.current_squared_a2s, 2)} A² s` })}</p>
      </details>
    </section>
  );
}

export interface SourcePanelProps {
  sessionId: string;
  resultId: string | null;
  player: ReplayPlayer;
  /** Columns of the distances. */
  distances: readonly string[];
  onSeek: (sinceStartS: number) => void;
}

export function SourcePanel({ sessionId, resultId, player, distances, onSeek }: SourcePanelProps) {
  const use = useSourceUse(sessionId, resultId);
  const { startS } = player.clock();
  return (
    <>
      <h2 className="visually-hidden">{t('magnetic.title')}</h2>
      <div className="stack">
        <section aria-labelledby="apart">
          <h3 id="apart">{t('magnetic.distances')}</h3>
          <p className="muted small">{t('magnetic.curveHelp')}</p>
          <Traces player={player} channels={distances} onSeek={onSeek} />
        </section>
        <QueryBoundary of={use} lines={6}>
          {(data) => (
            <>
              <section aria-labelledby="pulses">
                <h3 id="pulses">{t('magnetic.actuation')}</h3>
                <p className="muted small">{t('magnetic.pulseHelp')}</p>
                <Pulses use={data} player={player} />
              </section>
              <Exactness use={data} zeroS={startS} />
              <Energy use={data} zeroS={startS} />
              <BenchPanel sessionId={sessionId} />
            </>
          )}
        </QueryBoundary>
      </div>
    </>
  );
}
