// What a table is taken for, before anything is sent: a sentence and the first seconds of each sensor, and what that assumes.
import { useState } from 'react';
import { AxesChart, AxesLegend } from '../../charts/AxesChart';
import type { SensorPreview, TablePreview } from '../../api/types';
import { t } from '../../i18n';
import { number } from '../../lib/format';
import './FirstLook.css';

/** With more sensors than this only the first one's curves are open. */
const MOST_OPEN = 2;
const QUANTITIES = [
  { field: 'gyroscope_radps', name: 'csv.gyroscope', factor: 180 / Math.PI, unit: '°/s' },
  { field: 'accelerometer_mps2', name: 'csv.accelerometer', factor: 1, unit: 'm/s²' },
  { field: 'magnetometer_t', name: 'csv.magnetometer', factor: 1e6, unit: 'µT' },
] as const;

type Seen = Pick<TablePreview, 'sensors' | 'notes' | 'missing' | 'doubts'>;

export function FirstLook({ seen, isChanging }: { seen: Seen; isChanging: boolean }) {
  const { sensors, notes, missing, doubts } = seen;
  if ([sensors, notes, missing, doubts].every((one) => one.length === 0)) return null;
  const shownS = Math.max(0, ...sensors.map((one) => one.time_s.at(-1) ?? 0));
  return (
    <section className="stack first-look" aria-label={t('look.title')} aria-busy={isChanging}>
      {[...missing, ...doubts].map((reason) => (
        <p key={reason} className="alert-text">
          {reason}
        </p>
      ))}
      {sensors.length > 0 && (
        <div>
          <div className="line-head">
            <h3>{t('look.sensors', { count: sensors.length })}</h3>
            {shownS > 0 && (
              <span className="muted small">
                {t('look.seconds', { seconds: number(shownS, shownS < 9.95 ? 1 : 0) })}
              </span>
            )}
          </div>
          {shownS > 0 && <AxesLegend />}
          <ul className={sensors.length > MOST_OPEN ? 'plain-list look-sensors look-many' : 'plain-list look-sensors'}>
            {sensors.map((one, index) => (
              <Sensor key={one.where} sensor={one} isOpen={index === 0 || sensors.length <= MOST_OPEN} />
            ))}
          </ul>
        </div>
      )}
      {notes.length > 0 && (
        <div>
          <h3>{t('look.assumed')}</h3>
          <ul className="look-assumed">
            {notes.map((note) => (
              <li key={note}>{note}</li>
            ))}
          </ul>
        </div>
      )}
    </section>
  );
}

function Sensor({ sensor, isOpen: isOpenFirst }: { sensor: SensorPreview; isOpen: boolean }) {
  const [isOpen, setOpen] = useState(isOpenFirst);
  const curves = QUANTITIES.filter(({ field }) => sensor[field].length === 3);
  if (sensor.time_s.length < 2) {
    return (
      <li>
        <p>
          <Said sentence={sensor.sentence} />
        </p>
      </li>
    );
  }
  const place = sensor.sentence.split(': ', 1)[0] ?? sensor.where;
  return (
    <li>
      <details className="look-sensor" open={isOpen} onToggle={(event) => setOpen(event.currentTarget.open)}>
        <summary>
          <span>
            <Said sentence={sensor.sentence} />
          </span>
        </summary>
        <div className="look-curves">
          {(isOpen ? curves : []).map(({ field, name, factor, unit }) => (
            <AxesChart
              key={field}
              timeS={sensor.time_s}
              axes={sensor[field]}
              factor={factor}
              unit={unit}
              name={t(name)}
              label={(lowest, highest) => t('look.curve', { place, quantity: t(name), lowest, highest })}
            />
          ))}
        </div>
      </details>
    </li>
  );
}

/** The sentence of a sensor, the place that it begins with in bold. */
function Said({ sentence }: { sentence: string }) {
  const [place = '', ...rest] = sentence.split(': ');
  return rest.length === 0 ? (
    <>{sentence}</>
  ) : (
    <>
      <span className="strong">{place}</span>: {rest.join(': ')}
    </>
  );
}
