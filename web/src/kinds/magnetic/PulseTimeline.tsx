// Which coil was on when: three lanes, a bar a pulse.
import { t } from '../../i18n';
import { number, position } from '../../lib/format';
import type { Pulse } from './magnetic';
import { COIL_COLOURS } from './coils';
import './PulseTimeline.css';

const WIDTH = 1000;
/** A pulse of 30 ms must be seen in a picture of half an hour; thousandths of the width. */
const LEAST = 4;
const LANES = [1, 2, 3] as const;

export interface PulseTimelineProps {
  pulses: readonly Pulse[];
  fromS: number;
  untilS: number;
  /** Marks this moment. */
  nowS?: number;
  /** Live: counts back from now, so that the axis stands still. */
  isLive?: boolean;
}

export function PulseTimeline({ pulses, fromS, untilS, nowS, isLive = false }: PulseTimelineProps) {
  const spanS = Math.max(untilS - fromS, 1e-6);
  const x = (atS: number) => ((atS - fromS) / spanS) * WIDTH;
  const shown = pulses.filter((one) => one.endS > fromS && one.startS < untilS);
  const isInside = nowS !== undefined && nowS >= fromS && nowS <= untilS;
  return (
    <div data-testid="pulses">
      <div
        className="pulses"
        role="img"
        aria-label={t('magnetic.timeline', { seconds: number(spanS, 0), count: shown.length })}
      >
        {LANES.map((coil) => (
          <div className="pulse-lane" key={coil}>
            <span className="muted small">{t('magnetic.coil', { number: coil })}</span>
            <svg viewBox={`0 0 ${WIDTH} 10`} preserveAspectRatio="none" aria-hidden>
              {shown
                .filter((one) => Math.min(one.coil, LANES.length) === coil)
                .map((one) => {
                  const start = Math.max(x(one.startS), 0);
                  return (
                    <rect
                      key={one.startS}
                      x={start}
                      y={0}
                      width={Math.max(x(Math.min(one.endS, untilS)) - start, LEAST)}
                      height={10}
                      fill={`var(${COIL_COLOURS[one.coil - 1] ?? '--tm-alert'})`}
                    >
                      <title>
                        {t('magnetic.pulse', {
                          number: one.coil,
                          current: number(one.currentA, 2),
                          at: number(one.startS, 2),
                        })}
                      </title>
                    </rect>
                  );
                })}
              {isInside && (
                <line
                  x1={x(nowS)}
                  x2={x(nowS)}
                  y1={0}
                  y2={10}
                  stroke="var(--tm-ink)"
                  strokeWidth="2"
                  vectorEffect="non-scaling-stroke"
                />
              )}
            </svg>
          </div>
        ))}
        <div className="pulse-axis muted small number" aria-hidden>
          <span>{isLive ? `${number(fromS - untilS, 0)} s` : position(fromS, 0)}</span>
          <span>{isLive ? t('traces.now') : position(untilS, 0)}</span>
        </div>
      </div>
      {shown.length === 0 && <p className="muted small">{t('magnetic.noPulses')}</p>}
    </div>
  );
}
