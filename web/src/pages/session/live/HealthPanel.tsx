// How each sensor does: quiet while all is well, plain words when a hand is needed, numbers on request.
import { IconAlertTriangle, IconCheck, IconCircleDashed, IconMagnet, IconWifiOff } from '@tabler/icons-react';
import type { HealthMessage, Placement, SensorHealth } from '../../../api/types';
import { t } from '../../../i18n';
import { placementLabel, placementList } from '../../../lib/channels';
import { number } from '../../../lib/format';
import './HealthPanel.css';

interface Trouble {
  text: string;
  isUrgent: boolean;
  Icon: typeof IconCheck;
}

const NOTABLE_LOSS_PERCENT = 1;
/** Less is evened out by the reorder window without harm. */
const NOTABLE_JITTER_MS = 40;
const LOW_BATTERY_PERCENT = 15;

/** What is wrong with a sensor, the most pressing first; empty while all is well. */
export function troubles(sensor: SensorHealth): Trouble[] {
  const found: Trouble[] = [];
  if (sensor.status === 'lost') found.push({ text: t('health.lost'), isUrgent: true, Icon: IconWifiOff });
  if (sensor.status === 'noisy') found.push({ text: t('health.noisy'), isUrgent: false, Icon: IconAlertTriangle });
  if (sensor.saturated) found.push({ text: t('health.saturated'), isUrgent: false, Icon: IconAlertTriangle });
  if (sensor.status !== 'lost' && sensor.loss_percent >= NOTABLE_LOSS_PERCENT)
    found.push({
      text: t('health.loss', { percent: number(sensor.loss_percent, 1) }),
      isUrgent: false,
      Icon: IconAlertTriangle,
    });
  if (sensor.jitter_ms >= NOTABLE_JITTER_MS)
    found.push({
      text: t('health.jitter', { ms: number(sensor.jitter_ms) }),
      isUrgent: false,
      Icon: IconAlertTriangle,
    });
  if (sensor.magnetic_disturbance) found.push({ text: t('health.magnet'), isUrgent: false, Icon: IconMagnet });
  // While it starts no direction can be known yet: that is no trouble of the sensor.
  else if (!sensor.heading_trusted && !sensor.is_starting && sensor.status !== 'lost')
    found.push({ text: t('health.heading'), isUrgent: false, Icon: IconAlertTriangle });
  if (typeof sensor.battery_percent === 'number' && sensor.battery_percent < LOW_BATTERY_PERCENT)
    found.push({
      text: t('health.battery', { percent: number(sensor.battery_percent) }),
      isUrgent: false,
      Icon: IconAlertTriangle,
    });
  return found;
}

/** Its direction is not known yet, and cannot be. */
function isUnknown(sensor: SensorHealth): boolean {
  return !sensor.heading_trusted && (sensor.is_starting ?? false);
}

/** Troubles that every sensor has in the same words: they are the gateway's, and said once. */
export function sharedTroubles(sensors: readonly SensorHealth[]): Trouble[] {
  const [first, ...others] = sensors.map(troubles);
  if (!first || others.length === 0) return [];
  return first.filter((one) => others.every((list) => list.some((other) => other.text === one.text)));
}

function TroubleLines({ list }: { list: readonly Trouble[] }) {
  return (
    <ul className="plain-list sensor-troubles">
      {list.map(({ text, isUrgent, Icon }) => (
        <li key={text} className={isUrgent ? 'alert-text' : 'strong'}>
          <Icon size={17} aria-hidden /> {text}
        </li>
      ))}
    </ul>
  );
}

/** Not good yet, and nothing is wrong: before the calibration the direction cannot be known, however long it takes. */
function NotYet({ isUncalibrated }: { isUncalibrated: boolean }) {
  return (
    <>
      <IconCircleDashed size={17} aria-hidden /> {t(isUncalibrated ? 'health.uncalibrated' : 'health.starting')}
    </>
  );
}

function Sensor({
  sensor,
  shared,
  isUncalibrated,
}: {
  sensor: SensorHealth;
  shared: readonly Trouble[];
  isUncalibrated: boolean;
}) {
  const wrong = troubles(sensor).filter((one) => !shared.some((other) => other.text === one.text));
  return (
    <li className={wrong.some((one) => one.isUrgent) ? 'sensor sensor-urgent' : 'sensor'}>
      <span className="sensor-name">{placementLabel(sensor.placement)}</span>
      {wrong.length === 0 && shared.length > 0 ? null : wrong.length === 0 && isUnknown(sensor) ? (
        <span className="muted">
          <NotYet isUncalibrated={isUncalibrated} />
        </span>
      ) : wrong.length === 0 ? (
        <span className="sensor-good">
          <IconCheck size={17} aria-hidden /> {t('health.good')}
        </span>
      ) : (
        <TroubleLines list={wrong} />
      )}
    </li>
  );
}

/** What needs a hand, beside the delay: the cards of the sensors stand below the picture. */
export function SensorLine({
  health,
  isUncalibrated = false,
}: {
  health: HealthMessage | null;
  /** The session waits for its calibration. */
  isUncalibrated?: boolean;
}) {
  if (!health) return null;
  const wrong = health.sensors
    .map((one) => ({ place: one.placement, list: troubles(one) }))
    .filter((one) => one.list.length);
  const urgent = wrong.filter((one) => one.list.some((trouble) => trouble.isUrgent));
  const said = urgent.length ? urgent : wrong;
  const first = said[0]?.list[0];
  if (!first)
    return (
      <span className="live-sensors muted">
        {health.sensors.some(isUnknown) ? (
          <NotYet isUncalibrated={isUncalibrated} />
        ) : (
          <>
            <IconCheck size={17} aria-hidden /> {t('health.allGood', { count: health.sensors.length })}
          </>
        )}
      </span>
    );
  const same = said.filter((one) => one.list[0]?.text === first.text);
  const places =
    same.length === health.sensors.length && same.length > 1
      ? t('health.all')
      : placementList(same.map((one) => one.place));
  return (
    <a href="#health" className={first.isUrgent ? 'live-sensors alert-text' : 'live-sensors strong'}>
      <first.Icon size={17} aria-hidden /> {t('health.line', { places, trouble: first.text })}
      {said.length > same.length && ` ${t('health.more', { count: said.length - same.length })}`}
    </a>
  );
}

export function HealthPanel({
  health: reported,
  placements,
  isOutOfReach = false,
  isUncalibrated = false,
}: {
  health: HealthMessage | null;
  placements: readonly Placement[];
  isOutOfReach?: boolean;
  isUncalibrated?: boolean;
}) {
  // What was good a while ago may not be now.
  const health = isOutOfReach ? null : reported;
  const lost = health?.sensors.filter((sensor) => sensor.status === 'lost') ?? [];
  const shared = health ? sharedTroubles(health.sensors) : [];
  return (
    <section className="card" aria-labelledby="health">
      <div className="card-head">
        <h2 id="health">{t('health.title')}</h2>
      </div>
      <p className="visually-hidden" role="status">
        {lost.length > 0 && t('health.lostList', { places: placementList(lost.map((sensor) => sensor.placement)) })}
      </p>
      {health ? (
        <>
          {shared.length > 0 && (
            <div className="shared-troubles">
              <span>{t('health.all')}</span>
              <TroubleLines list={shared} />
            </div>
          )}
          <ul className="plain-list sensors">
            {health.sensors.map((sensor) => (
              <Sensor key={sensor.placement} sensor={sensor} shared={shared} isUncalibrated={isUncalibrated} />
            ))}
          </ul>
          <details className="as-table">
            <summary>{t('health.numbers')}</summary>
            <table className="plain-table">
              <thead>
                <tr>
                  <th scope="col">{t('health.sensor')}</th>
                  <th scope="col">{t('health.lossColumn')}</th>
                  <th scope="col">{t('health.jitterColumn')}</th>
                </tr>
              </thead>
              <tbody>
                {health.sensors.map((sensor) => (
                  <tr key={sensor.placement}>
                    <th scope="row">{placementLabel(sensor.placement)}</th>
                    <td className="number">{number(sensor.loss_percent, 1)} %</td>
                    <td className="number">{number(sensor.jitter_ms, 1)} ms</td>
                  </tr>
                ))}
              </tbody>
            </table>
            <dl className="facts small">
              <dt>{t('health.stored')}</dt>
              <dd className="number">{number(health.packets_stored)}</dd>
              <dt>{t('health.missing')}</dt>
              <dd className="number">{number(health.packets_missing)}</dd>
              {typeof health.clock_skew_ppm === 'number' && (
                <>
                  <dt>{t('health.skew')}</dt>
                  <dd className="number">{number(health.clock_skew_ppm, 1)} ppm</dd>
                </>
              )}
            </dl>
          </details>
        </>
      ) : (
        <ul className="plain-list sensors">
          {placements.map((placement) => (
            <li key={placement} className="sensor">
              <span className="sensor-name">{placementLabel(placement)}</span>
              <span className="muted">{t(isOutOfReach ? 'health.unknown' : 'health.waiting')}</span>
            </li>
          ))}
        </ul>
      )}
    </section>
  );
}
