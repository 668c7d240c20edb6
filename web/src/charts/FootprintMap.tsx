// Footprints from above: where each foot stood and pointed, and where mass and pressure went between them.
import { useEffect, useId, useMemo, useRef, useState } from 'react';
import { LegendStroke } from './Legend';
import type { Gait } from '../api/types';
import { t } from '../i18n';
import { number } from '../lib/format';
import { floorPath, isOutsideHold, mapFrame } from '../kinds/walk/gait';
import './FootprintMap.css';

/** Outline of a left shoe in metres, seen from above: sensor at the heel, x to the toes, y to the left. */
const SHOE =
  'M-0.055 0C-0.055 0.026-0.038 0.036-0.012 0.036C0.04 0.036 0.075 0.036 0.11 0.046C0.15 0.056 0.19 0.05 0.208 0.022C0.22-0.002 0.212-0.034 0.184-0.046C0.15-0.056 0.12-0.046 0.085-0.034C0.05-0.022 0.02-0.034-0.012-0.034C-0.038-0.034-0.055-0.026-0.055 0Z';

/** Pixels a metre from which a letter has room on a foot. */
const LETTERS_FROM = 80;

export interface MapParts {
  mass: boolean;
  pressure: boolean;
  support: boolean;
}

export interface FootprintMapProps {
  gait: Gait;
  parts: MapParts;
  /** Foot and number of the stride that is looked at. */
  selected: { side: 'left' | 'right'; number: number } | null;
}

export function FootprintMap({ gait, parts, selected }: FootprintMapProps) {
  const box = useRef<HTMLDivElement>(null);
  const [available, setAvailable] = useState(1080);
  const title = useId();
  useEffect(() => {
    if (!box.current) return;
    const observer = new ResizeObserver(([entry]) => entry && setAvailable(Math.max(280, entry.contentRect.width)));
    observer.observe(box.current);
    return () => observer.disconnect();
  }, []);
  const frame = useMemo(() => mapFrame(gait, available - 4), [gait, available]);
  const { scale, isUpright } = frame;
  const along = (frame.maxX - frame.minX) * scale;
  const across = (frame.maxY - frame.minY) * scale;
  // The scale below has its place, however narrow the walk is.
  const width = isUpright ? Math.max(across, scale + 56) : along;
  const height = (isUpright ? along : across) + 34;
  const count = (side: 'left' | 'right') => gait.feet.find((foot) => foot.side === side)?.footholds.length ?? 0;
  const floor = height - 34;
  const middle = 0.065 * scale;
  return (
    // eslint-disable-next-line jsx-a11y/no-noninteractive-tabindex -- a scrolling region must be reachable by keyboard
    <div className="map-scroll" ref={box} role="group" aria-label={t('map.title')} tabIndex={0}>
      <svg width={width} height={height} viewBox={`0 0 ${width} ${height}`} role="img" aria-labelledby={title}>
        <title id={title}>
          {t(isUpright ? 'map.summaryUp' : 'map.summary', {
            left: count('left'),
            right: count('right'),
            length: number(frame.maxX - frame.minX - 0.6, 1),
          })}
        </title>
        <g transform={isUpright ? `translate(${(width - across) / 2} ${along}) rotate(-90)` : undefined}>
          {Array.from({ length: Math.ceil(frame.maxX) - Math.ceil(frame.minX) }, (_, index) => {
            const x = (Math.ceil(frame.minX) + index - frame.minX) * scale;
            return <path key={index} d={`M${x} 0V${across}`} stroke="var(--tm-line)" strokeWidth="1" />;
          })}
          {parts.support &&
            gait.balance?.support.map(
              (one) =>
                one.outline_m.length > 2 && (
                  <path
                    key={one.time_s}
                    d={`${floorPath(one.outline_m, frame)}Z`}
                    fill="var(--tm-series-4)"
                    fillOpacity="0.05"
                    stroke="var(--tm-series-4)"
                    strokeOpacity="0.4"
                    strokeWidth="1"
                  />
                ),
            )}
          {gait.feet.map((foot) =>
            foot.footholds.map((hold, index) => {
              const isLeft = foot.side === 'left';
              const isSelected =
                selected !== null &&
                selected.side === foot.side &&
                (selected.number === index || selected.number === index + 1);
              const x = (hold.x_m - frame.minX) * scale;
              const y = (frame.maxY - hold.y_m) * scale;
              const heading = (hold.heading_rad * 180) / Math.PI;
              return (
                <g
                  key={`${foot.side}${index}`}
                  transform={`translate(${x.toFixed(1)} ${y.toFixed(1)}) rotate(${(-heading).toFixed(1)})`}
                  className={`print print-${foot.side}`}
                  data-selected={isSelected || undefined}
                  data-outside={isOutsideHold(foot, index) || undefined}
                >
                  <g transform={`scale(${scale} ${isLeft ? -scale : scale})`}>
                    <path d={SHOE} vectorEffect="non-scaling-stroke" />
                  </g>
                  {scale >= LETTERS_FROM && (
                    <text
                      x={middle}
                      y="4"
                      fontSize={Math.max(10, Math.min(14, 0.08 * scale))}
                      textAnchor="middle"
                      // A letter stands upright, whichever way the foot points.
                      transform={`rotate(${(heading + (isUpright ? 90 : 0)).toFixed(1)} ${middle} 0)`}
                    >
                      {isLeft ? 'L' : 'R'}
                    </text>
                  )}
                </g>
              );
            }),
          )}
          {parts.pressure && gait.balance && (
            <path
              d={floorPath(gait.balance.pressure_m, frame)}
              fill="none"
              stroke="var(--tm-series-3)"
              strokeWidth="1.8"
              strokeDasharray="5 3"
              strokeLinejoin="round"
            />
          )}
          {parts.mass && gait.balance && (
            <path
              d={floorPath(gait.balance.centre_m, frame)}
              fill="none"
              stroke="var(--tm-ink)"
              strokeWidth="3.2"
              strokeLinejoin="round"
              strokeLinecap="round"
            />
          )}
        </g>
        <g transform={`translate(8 ${floor + 20})`}>
          <path d={`M0 -5V5M0 0H${scale}M${scale} -5V5`} stroke="var(--tm-muted)" strokeWidth="1.5" />
          <text x={scale + 8} y="5" fontSize="14" fill="var(--tm-muted)">
            {t('map.scale')}
          </text>
        </g>
      </svg>
    </div>
  );
}

/** What the marks of the map mean, in words. */
export function MapLegend({ hasBalance }: { hasBalance: boolean }) {
  return (
    <ul className="legend plain-list">
      <li>
        <svg width="34" height="16" aria-hidden className="print-left">
          <rect x="1" y="2" width="32" height="12" rx="6" />
        </svg>
        {t('map.leftFoot')}
      </li>
      <li>
        <svg width="34" height="16" aria-hidden className="print-right">
          <rect x="1.5" y="2" width="31" height="12" rx="6" />
        </svg>
        {t('map.rightFoot')}
      </li>
      {hasBalance && (
        <>
          <LegendStroke stroke="var(--tm-ink)" strokeWidth="3.2">
            {t('map.mass')}
          </LegendStroke>
          <LegendStroke stroke="var(--tm-series-3)" strokeWidth="1.8" strokeDasharray="5 3">
            {t('map.pressure')}
          </LegendStroke>
        </>
      )}
    </ul>
  );
}
