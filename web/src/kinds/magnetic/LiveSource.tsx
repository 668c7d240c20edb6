// A magnetic session while it happens: how far each sensor is and how well that is known, and what the source does.
import { IconAlertTriangle, IconCheck } from '@tabler/icons-react';
import { useEffect, useState } from 'react';
import { Notice } from '../../components/Feedback';
import { t } from '../../i18n';
import { placementLabel } from '../../lib/channels';
import { number, quantity, uncertain } from '../../lib/format';
import { SIGMAS, isStarting, milliampereHours, needsHand, pulsesIn, stateKeys, type Pulse } from './magnetic';
import type { Player } from '../../player/types';
import { PulseTimeline } from './PulseTimeline';
import './LiveSource.css';

const WINDOW_S = 20;
const REFRESH_MS = 250;
const OF_NOW_S = 1.5;

interface Reading {
  pulses: Pulse[];
  fromS: number;
  untilS: number;
  onTimeS: number;
  chargeAs: number;
  sensors: { name: string; distanceM: number; sigmaM: number; bits: number }[];
}

/** The newest of everything, and the pulses of the last seconds. */
export function readSource(player: Player, sensors: readonly string[]): Reading | null {
  const { timeS } = player.clock();
  const own = sensors.flatMap((name) => [`${name}_distance_m`, `${name}_distance_sigma_m`, `${name}_state`]);
  const read = player.read(
    timeS - WINDOW_S,
    timeS + 1e-6,
    ['source_coil', 'source_current_a', 'source_on_time_s', 'source_charge_as', ...own],
    8000,
  );
  const last = read.timeS.length - 1;
  // In silence the clock goes on: what came a while ago is not of now.
  if (timeS - (read.timeS[last] ?? -Infinity) > OF_NOW_S) return null;
  const at = (column: number) => read.values[column]?.[last] ?? NaN;
  return {
    pulses: pulsesIn(read.timeS, read.values[0] ?? [], read.values[1] ?? []),
    fromS: timeS - WINDOW_S,
    untilS: timeS,
    onTimeS: at(2),
    chargeAs: at(3),
    sensors: sensors.map((name, index) => ({
      name,
      distanceM: at(4 + 3 * index),
      sigmaM: at(5 + 3 * index),
      bits: at(6 + 3 * index) || 0,
    })),
  };
}

/** Read a few times a second; null before anything has come. */
function useReading(player: Player, sensors: readonly string[]): Reading | null {
  const [reading, setReading] = useState<Reading | null>(null);
  const names = sensors.join();
  useEffect(() => {
    const timer = setInterval(() => setReading(readSource(player, names.split(','))), REFRESH_MS);
    return () => clearInterval(timer);
  }, [player, names]);
  return reading;
}

/** What to do until the first position is known; nothing afterwards. */
export function SourceStart({ player, sensors }: { player: Player; sensors: readonly string[] }) {
  const reading = useReading(player, sensors);
  if (reading && !reading.sensors.some((one) => isStarting(one.bits))) return null;
  return <Notice>{t('magnetic.help')}</Notice>;
}

export function LiveSource({
  player,
  sensors,
  source,
}: {
  player: Player;
  sensors: readonly string[];
  source: string;
}) {
  const reading = useReading(player, sensors);
  if (!reading) return null;
  const timeS = Math.max(reading.untilS, 1e-6);
  return (
    <section className="card" aria-labelledby="source">
      <div className="card-head">
        <h2 id="source">{t('magnetic.title')}</h2>
      </div>
      <ul className="plain-list lines">
        {reading.sensors.map((one) => {
          const isBad = needsHand(one.bits);
          const Icon = isBad ? IconAlertTriangle : IconCheck;
          const [distance, spread] = uncertain(one.distanceM, SIGMAS * one.sigmaM, 'm').split(' ± ');
          return (
            <li key={one.name}>
              <span className="strong">
                {t('magnetic.fromTo', { source: placementLabel(source), sensor: placementLabel(one.name) })}
              </span>
              <p className="distance-now">
                <span className="number strong value" data-testid={`distance-${one.name}`}>
                  {distance}
                </span>
                {spread !== undefined && (
                  <span className="number muted">{t('magnetic.spread', { value: `${spread} cm` })}</span>
                )}
              </p>
              <span className={isBad ? 'alert-text small' : 'muted small'} style={{ display: 'block' }}>
                <Icon size={16} aria-hidden />{' '}
                {stateKeys(one.bits)
                  .map((key) => t(key as 'magnetic.sound'))
                  .join('. ')}
              </span>
            </li>
          );
        })}
      </ul>
      <p className="muted small">{t('magnetic.spreadHelp')}</p>
      <h3>{t('magnetic.actuation')}</h3>
      <PulseTimeline pulses={reading.pulses} fromS={reading.fromS} untilS={reading.untilS} isLive />
      <dl className="facts">
        <dt>{t('magnetic.onTime')}</dt>
        <dd className="number">
          {quantity(reading.onTimeS, 's')} ·{' '}
          {t('magnetic.share', { percent: number((100 * reading.onTimeS) / timeS, 1) })}
        </dd>
        <dt>{t('magnetic.charge')}</dt>
        <dd className="number" data-testid="charge">{`${number(milliampereHours(reading.chargeAs), 2)} mAh`}</dd>
      </dl>
    </section>
  );
}
