// Which coil was on when: three lanes, a bar a pulse.
import { t } from '../../i18n';
import { number } from '../../lib/format';
import type { Pulse } from '../../lib/magnetic';

const COLOURS = ['--tm-series-1', '--tm-series-2', '--tm-series-3'] as const;
const LANE = 26;
const LEFT = 64;
/** A pulse of 30 ms must be seen in a picture of half an hour. */
const LEAST = 2;

export function PulseTimeline({ pulses, fromS, untilS, nowS, width = 600 }: { pulses: readonly Pulse[]; fromS: number; untilS: number; nowS?: number; width?: number }) {
  const spanS = Math.max(untilS - fromS, 1e-6);
  const x = (atS: number) => LEFT + ((atS - fromS) / spanS) * (width - LEFT);
  const shown = pulses.filter((one) => one.endS > fromS && one.startS < untilS);
  const lanes = [1, 2, 3];
  return (
    <div data-testid="pulses">
      <svg
        viewBox={`0 0 ${width} ${LANE * lanes.length + 20}`}
        width="100%"
        role="img"
        aria-label={t('magnetic.timeline', { seconds: number(spanS, 0), count: shown.length })}
      >
        {lanes.map((coil) => (
          <g key={coil}>
            <text x={0} y={LANE * (coil - 1) + 18} fontSize="14" fill="var(--tm-muted)">
              {t('magnetic.coil', { number: coil })}
            </text>
            <line x1={LEFT} x2={width} y1={LANE * coil - 2} y2={LANE * coil - 2} stroke="var(--tm-line)" />
          </g>
        ))}
        {shown.map((one) => {
          const start = Math.max(x(one.startS), LEFT);
          return (
            <rect
              key={`${one.startS}/${one.coil}`}
              x={start}
              y={LANE * (Math.min(one.coil, 3) - 1) + 4}
              width={Math.max(x(Math.min(one.endS, untilS)) - start, LEAST)}
              height={LANE - 8}
              fill={`var(${COLOURS[one.coil - 1] ?? '--tm-alert'})`}
            >
              <title>{t('magnetic.pulse', { number: one.coil, current: number(one.currentA, 2), at: number(one.startS, 2) })}</title>
            </rect>
          );
        })}
        {nowS !== undefined && nowS >= fromS && nowS <= untilS && <line x1={x(nowS)} x2={x(nowS)} y1={0} y2={LANE * lanes.length} stroke="var(--tm-text)" strokeWidth="1.5" />}
        <text x={LEFT} y={LANE * lanes.length + 16} fontSize="13" fill="var(--tm-muted)">
          {`${number(fromS, 0)} s`}
        </text>
        <text x={width} y={LANE * lanes.length + 16} fontSize="13" textAnchor="end" fill="var(--tm-muted)">
          {`${number(untilS, 0)} s`}
        </text>
      </svg>
      {shown.length === 0 && <p className="muted small">{t('magnetic.noPulses')}</p>}
    </div>
  );
}
