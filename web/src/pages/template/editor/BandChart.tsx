// The recorded curve with the band drawn on it: grips on the band and on the borders of phases, by mouse, touch and keys.
import { useElementSize, useMediaQuery } from '@mantine/hooks';
import { useId, useRef, type KeyboardEvent, type PointerEvent } from 'react';
import type { PhaseCurve } from '../../../api/types';
import { t } from '../../../i18n';
import { edgesOf, knotsFor, stretches, type Draft, type Edge } from '../../../lib/assessment/design';
import { displayUnit, number, quantity, tick } from '../../../lib/format';
import { areaOf, factorFor, handlesOf, lineOf, PAD, scalesOf, stepOf, type Handle, type Scales } from './geometry';
import { phaseName } from './words';

const FALLBACK_WIDTH = 820;
const LARGE = 5;
const OVER_RIM = 4;

interface Props {
  curve: PhaseCurve;
  draft: Draft;
  left: ReadonlySet<number>;
  selected: number;
  onSelect: (phase: number) => void;
  onBand: (phase: number, edge: Edge, factor: number | null) => void;
  onBorder: (phase: number, end: number) => void;
}

export function BandChart({ curve, draft, left, selected, onSelect, onBand, onBorder }: Props) {
  const { ref, width: measured } = useElementSize();
  const isSmall = useMediaQuery('(max-width: 600px)') ?? false;
  const width = measured || FALLBACK_WIDTH;
  const height = isSmall ? 340 : 420;
  const unit = displayUnit(curve.unit);
  const limits = draft.stops.filter((one) => one.kind === 'limit' && one.channel === curve.channel);
  const limitOf = (one: (typeof limits)[number]) => (one.limit ?? 0) * (curve.unit === 'm' ? 1 : 180 / Math.PI);
  const scales = scalesOf(curve, width, height, limits.map(limitOf));
  const edges = edgesOf(curve, knotsFor(draft, curve.channel));
  const clip = useId();
  const parts = stretches(draft.phases);
  const isPlain = draft.watched.includes(curve.channel);
  return (
    <div ref={ref} className="band-chart">
      <svg width={width} height={height} role="group" aria-label={t('design.chart', { curve: curve.label })}>
        <defs>
          <clipPath id={clip}>
            <rect
              x={PAD.left}
              y={scales.top}
              width={width - PAD.left - PAD.right}
              height={scales.bottom - scales.top}
            />
          </clipPath>
        </defs>
        {parts.map(([start, end], index) => (
          <g key={index} aria-hidden onPointerDown={() => onSelect(index)}>
            <rect
              className={index === selected ? 'band-phase band-phase-on' : 'band-phase'}
              x={scales.x(start)}
              y={4}
              width={Math.max(0, scales.x(end) - scales.x(start))}
              height={scales.bottom - 4}
            />
            <PhaseTitle x={(scales.x(start) + scales.x(end)) / 2} room={scales.x(end) - scales.x(start)}>
              {phaseName(draft.phases, index)}
            </PhaseTitle>
          </g>
        ))}
        <g aria-hidden pointerEvents="none">
          {scales.ticks.map((at) => (
            <g key={at}>
              <line className="band-grid" x1={PAD.left} x2={width - PAD.right} y1={scales.y(at)} y2={scales.y(at)} />
              <text className="band-tick" x={PAD.left - 8} y={scales.y(at) + 5} textAnchor="end">
                {tick(at * unit.factor, unit)}
              </text>
            </g>
          ))}
          {[0, 0.25, 0.5, 0.75, 1].map((at) => (
            <text
              key={at}
              className="band-tick"
              x={scales.x(at) + (at === 1 ? PAD.right - 2 : 0)}
              y={height - 6}
              textAnchor={at === 1 ? 'end' : 'middle'}
            >
              {number(at * 100)} %
            </text>
          ))}
          <g clipPath={`url(#${clip})`}>
            <path className={isPlain ? 'band-area band-area-plain' : 'band-area'} d={areaOf(curve, edges, scales)} />
            {curve.repetitions.map((one, index) =>
              left.has(index) ? null : <path key={index} className="band-repetition" d={lineOf(one, scales)} />,
            )}
            <path className="band-edge" d={lineOf(edges.high, scales)} />
            <path className="band-edge" d={lineOf(edges.low, scales)} />
          </g>
          <path className="band-mean" d={lineOf(curve.mean, scales)} />
          {limits.map((one, index) => (
            <g key={index} className="band-limit">
              <line x1={PAD.left} x2={width - PAD.right} y1={scales.y(limitOf(one))} y2={scales.y(limitOf(one))} />
              <text
                x={width - PAD.right - 4}
                y={scales.y(limitOf(one)) + (one.side === 'below' ? 18 : -6)}
                textAnchor="end"
              >
                {t('design.limitLine', { value: quantity(limitOf(one), curve.unit) })}
              </text>
            </g>
          ))}
        </g>
        {draft.phases.slice(0, -1).map((one, index) => (
          <Border
            key={index}
            end={one.end}
            label={t('design.border', {
              before: phaseName(draft.phases, index),
              after: phaseName(draft.phases, index + 1),
            })}
            scales={scales}
            onMove={(end) => onBorder(index, end)}
          />
        ))}
        {!isPlain &&
          handlesOf(curve, draft).map((handle) => (
            <Grip
              key={`${handle.phase}-${handle.edge}`}
              curve={curve}
              handle={handle}
              phaseTitle={phaseName(draft.phases, handle.phase)}
              scales={scales}
              isOn={handle.phase === selected}
              onSelect={() => onSelect(handle.phase)}
              onFactor={(factor) => onBand(handle.phase, handle.edge, factor)}
            />
          ))}
      </svg>
    </div>
  );
}

const LETTER = 9;

function PhaseTitle({ x, room, children }: { x: number; room: number; children: string }) {
  const letters = Math.floor((room - 10) / LETTER);
  const text = children.length > letters ? `${children.slice(0, Math.max(1, letters - 1))}…` : children;
  return (
    <text className="band-phase-name" x={x} y={24} textAnchor="middle">
      {text}
    </text>
  );
}

/** Follow a pointer from a handle until it is let go, in the coordinates of the picture. */
function useDrag(onDrag: (x: number, y: number) => void) {
  const isDown = useRef(false);
  const at = (event: PointerEvent<SVGGElement>) => {
    const box = event.currentTarget.ownerSVGElement?.getBoundingClientRect();
    if (box) onDrag(event.clientX - box.left, event.clientY - box.top);
  };
  return {
    onPointerDown: (event: PointerEvent<SVGGElement>) => {
      isDown.current = true;
      event.currentTarget.setPointerCapture?.(event.pointerId);
      event.currentTarget.focus();
      event.preventDefault();
    },
    onPointerMove: (event: PointerEvent<SVGGElement>) => {
      if (isDown.current) at(event);
    },
    onPointerUp: () => {
      isDown.current = false;
    },
    onPointerCancel: () => {
      isDown.current = false;
    },
  };
}

function Grip({
  curve,
  handle,
  phaseTitle,
  scales,
  isOn,
  onSelect,
  onFactor,
}: {
  curve: PhaseCurve;
  handle: Handle;
  phaseTitle: string;
  scales: Scales;
  isOn: boolean;
  onSelect: () => void;
  onFactor: (factor: number | null) => void;
}) {
  const isFree = handle.value === null;
  const drag = useDrag((_, y) => {
    const isOut = handle.edge === 'above' ? y < scales.top - OVER_RIM : y > scales.bottom + OVER_RIM;
    onFactor(isOut ? null : factorFor(handle, scales.valueAt(y)));
  });
  const onKeyDown = (event: KeyboardEvent) => {
    const far = event.shiftKey ? LARGE : 1;
    const step = { ArrowUp: far, ArrowRight: far, ArrowDown: -far, ArrowLeft: -far, PageUp: LARGE, PageDown: -LARGE }[
      event.key
    ];
    if (step !== undefined) onFactor(factorFor(handle, (handle.value ?? rimOf(handle, scales)) + step * stepOf(curve)));
    else if (event.key.toLowerCase() === 'f') onFactor(isFree ? 1 : null);
    else return;
    event.preventDefault();
  };
  const x = scales.x(handle.at / 100);
  const rim = handle.edge === 'above' ? scales.top : scales.bottom;
  const y = handle.value === null ? rim : Math.min(scales.bottom, Math.max(scales.top, scales.y(handle.value)));
  const away = handle.factor === null ? null : handle.factor * handle.width;
  const shown = handle.value === null ? null : handle.value * displayUnit(curve.unit).factor;
  return (
    <g
      className={isOn ? 'band-grip band-grip-on' : 'band-grip'}
      role="slider"
      tabIndex={0}
      aria-orientation="vertical"
      aria-label={t(handle.edge === 'above' ? 'design.gripAbove' : 'design.gripBelow', { phase: phaseTitle })}
      aria-valuenow={shown === null ? undefined : Number(shown.toFixed(1))}
      aria-valuetext={
        away === null || handle.value === null
          ? t('design.free')
          : t(handle.edge === 'above' ? 'design.valueAbove' : 'design.valueBelow', {
              value: quantity(handle.value, curve.unit),
              away: quantity(away, curve.unit),
            })
      }
      transform={`translate(${x} ${y})`}
      onFocus={onSelect}
      onKeyDown={onKeyDown}
      {...drag}
    >
      <rect className="band-hit" x={-24} y={-22} width={48} height={44} />
      <rect className="band-pill" x={-20} y={-10} width={40} height={20} rx={10} />
      <path className="band-lines" d="M-8 -3h16M-8 3h16" />
      {(isFree || isOn) && (
        // At the rim beside the grip: between two grips of a narrow band is no room.
        <text
          className="band-value"
          {...((handle.edge === 'above' ? y < scales.top + 34 : y > scales.bottom - 34)
            ? { x: 26, y: 5, textAnchor: 'start' }
            : { y: handle.edge === 'above' ? -18 : 30, textAnchor: 'middle' })}
        >
          {isFree ? t('design.free') : quantity(away, curve.unit)}
        </text>
      )}
    </g>
  );
}

/** Where the rim of the picture lies, for a key pressed on a free edge. */
function rimOf(handle: Handle, scales: Scales): number {
  return scales.valueAt(handle.edge === 'above' ? scales.top : scales.bottom);
}

function Border({
  end,
  label,
  scales,
  onMove,
}: {
  end: number;
  label: string;
  scales: Scales;
  onMove: (end: number) => void;
}) {
  const drag = useDrag((x) => onMove(scales.phaseAt(x)));
  const onKeyDown = (event: KeyboardEvent) => {
    const far = event.shiftKey ? LARGE : 1;
    const step = { ArrowRight: far, ArrowUp: far, ArrowLeft: -far, ArrowDown: -far, PageUp: LARGE, PageDown: -LARGE }[
      event.key
    ];
    if (step === undefined) return;
    onMove(end + step / 100);
    event.preventDefault();
  };
  const x = scales.x(end);
  return (
    <g
      className="band-border"
      role="slider"
      tabIndex={0}
      aria-orientation="horizontal"
      aria-label={label}
      aria-valuemin={0}
      aria-valuemax={100}
      aria-valuenow={Math.round(100 * end)}
      aria-valuetext={t('design.ofMovement', { percent: Math.round(100 * end) })}
      onKeyDown={onKeyDown}
      {...drag}
    >
      <line className="band-border-line" x1={x} x2={x} y1={10} y2={scales.bottom} />
      <rect className="band-hit" x={x - 22} y={scales.bottom - 6} width={44} height={44} />
      <circle className="band-pill" cx={x} cy={scales.bottom + 16} r={13} />
      <path className="band-lines" d={`M${x - 3} ${scales.bottom + 10}v12M${x + 3} ${scales.bottom + 10}v12`} />
    </g>
  );
}
