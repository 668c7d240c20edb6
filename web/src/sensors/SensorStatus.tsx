// What is measured, what is stored on this device and what was sent: only what is known here.
import { t } from '../i18n';
import { placementLabel } from '../lib/channels';
import type { Placement } from '../api/types';
import type { LinkState } from './gateway/link';
import type { RecorderState } from './gateway/recorder';
import type { RunSnapshot } from './run';

/** Fewer seconds are on their way at any time. */
const ON_THE_WAY_S = 3;

export const secondsText = (seconds: number) => t('sensors.seconds', { count: Math.max(1, Math.round(seconds)) });

function linkWords(recorder: RecorderState): string {
  const { status } = recorder.link;
  if (status === 'open' && recorder.waitingS > ON_THE_WAY_S)
    return t('sensors.link.behind', { seconds: secondsText(recorder.waitingS) });
  if (status === 'lost' && recorder.link.isBlocked) return t('sensors.link.blocked');
  return t(`sensors.link.${status}`);
}

/** Why nothing more is sent, in words for the patient. */
export const refusalWords = ({ code, reason }: LinkState) => (code === 'superseded' ? t('sensors.takenOver') : reason);

/** The parts that are wrong, in the order in which they matter. */
function troubles(run: RunSnapshot): string[] {
  const recorder = run.gateway?.recorder;
  const isOver = recorder?.link.status === 'ended';
  return [
    run.gateway?.broken && t('sensors.broken'),
    recorder?.isFull && t('sensors.full'),
    recorder?.lostPackets && t('sensors.lost', { count: recorder.lostPackets }),
    recorder?.link.status === 'refused' && refusalWords(recorder.link),
    !isOver && run.isSilent && t('sensors.silent'),
    !isOver && !run.isAwake && t('sensors.asleep'),
  ].filter((one): one is string => Boolean(one));
}

function Worn({ run }: { run: RunSnapshot }) {
  const places = Object.entries(run.sensors);
  if (places.length === 0) return null;
  return (
    <ul className="sensor-list">
      {places.map(([place, state]) => (
        <li key={place} data-status={state.status}>
          <span className="strong">{placementLabel(place as Placement)}</span> {state.name}:{' '}
          {t(`sensors.status.${state.status}`)}
          {state.batteryPercent !== null && `, ${t('sensors.battery', { percent: state.batteryPercent })}`}
        </li>
      ))}
    </ul>
  );
}

export function SensorStatus({ run }: { run: RunSnapshot }) {
  const recorder = run.gateway?.recorder ?? null;
  const wrong = troubles(run);
  const status = recorder?.link.status;
  const isBehind = recorder !== null && recorder.waitingS > ON_THE_WAY_S;
  return (
    <section
      className="card sensor-status"
      data-link={status}
      data-waiting={recorder?.waiting}
      data-stored={recorder?.stored}
    >
      {recorder && (
        <p className="strong" role="status">
          {linkWords(recorder)}
        </p>
      )}
      <Worn run={run} />
      {recorder && status === 'open' && !isBehind && <p className="muted">{t('sensors.allSent')}</p>}
      {recorder && status !== 'open' && recorder.waiting > 0 && (
        <p className="muted">{t('sensors.stored', { seconds: secondsText(recorder.waitingS) })}</p>
      )}
      {wrong.map((one) => (
        <p key={one} role="alert">
          {one}
        </p>
      ))}
    </section>
  );
}
