// The recorded curve with the band drawn on it: grips on the band and on the borders of phases, by mouse, touch and keys.
import { useMediaQuery } from '@mantine/hooks';
import { useId, useRef, type KeyboardEvent, type PointerEvent } from 'react';
import type { PhaseCurve } from '../../../api/types';
import { t } from '../../../i18n';
import { edgesOf, knotsFor, stretches, type Draft, type Edge } from '../../../lib/assessment/design';
import { displayUnit, number, quantity, tick } from '../../../lib/format';
import { ChartFrame, type Place } from '../../../charts/ChartFrame';
import { bandOf, fitted, lineOf, type Values } from '../../../charts/marks';
import { domainOf, factorFor, handlesOf, PAD, stepOf, type Handle } from './geometry';
import { phaseName } from './words';
import './BandChart.css';
import './editor.css';

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
  const isSmall = useMediaQuery('(max-width: 600px)') ?? false;
  const unit = displayUnit(curve.unit);
  const limits = draft.stops.filter((one) => one.kind === 'limit' && one.channel === curve.channel);
  const limitOf = (one: (typeof limits)[number]) => (one.limit ?? 0) * (curve.unit === 'm' ? 1 : 180 / Math.PI);
  const edges = edgesOf(curve, knotsFor(draft, curve.channel));
  const clip = useId();
  const isPlain = draft.watched.includes(curve.channel);
  // Where an edge is free the band reaches to the rim of the picture.
  const domain = domainOf(curve, limits.map(limitOf));
  const edge = (values: readonly (number | null)[], free: number) =>
    curve.mean.map((mean, index) => (mean === null ? null : (values[index] ?? free)));
  const [low, high] = [edge(edges.low, domain[0]), edge(edges.high, domain[1])];
  return (
    <div className="band-chart">
      <ChartFrame
        role="group"
        label={t('design.chart', { curve: curve.label })}
        height={isSmall ? 340 : 420}
        margin={PAD}
        x={{ domain: [0, 1], ticks: () => [0, 0.25, 0.5, 0.75, 1], text: (at) => `${number(at * 100)} %` }}
        y={{ domain, every: 56, text: (at) => tick(at * unit.factor, unit) }}
        behind={(at) => <Phases draft={draft} selected={selected} onSelect={onSelect} at={at} />}
      >
        {(at) => {
          const line = (values: Values) => lineOf(values, (index) => at.x(index / 100), at.y);
          return (
            <>
              <clipPath id={clip}>
                <rect x={at.left} y={at.top} width={at.right - at.left} height={at.bottom - at.top} />
              </clipPath>
              <g aria-hidden pointerEvents="none">
                <g clipPath={`url(#${clip})`}>
                  <path
                    className={isPlain ? 'band-area band-area-plain' : 'band-area'}
                    d={bandOf(low, high, (index) => at.x(index / 100), at.y)}
                  />
                  {curve.repetitions.map((one, index) =>
                    left.has(index) ? null : <path key={index} className="band-repetition" d={line(one)} />,
                  )}
                  <path className="band-edge" d={line(edges.high)} />
                  <path className="band-edge" d={line(edges.low)} />
                </g>
                <path className="band-mean" d={line(curve.mean)} />
                {limits.map((one, index) => (
                  <g key={index} className="band-limit">
                    <line x1={at.left} x2={at.right} y1={at.y(limitOf(one))} y2={at.y(limitOf(one))} />
                    <text x={at.right - 4} y={at.y(limitOf(one)) + (one.side === 'below' ? 18 : -6)} textAnchor="end">
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
                  at={at}
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
                    at={at}
                    isOn={handle.phase === selected}
                    onSelect={() => onSelect(handle.phase)}
                    onFactor={(factor) => onBand(handle.phase, handle.edge, factor)}
                  />
                ))}
            </>
          );
        }}
      </ChartFrame>
    </div>
  );
}

const LETTER = 9;

/** The phases behind the curve, the selected one on a ground of its own. */
function Phases({ draft, selected, onSelect, at }: Pick<Props, 'draft' | 'selected' | 'onSelect'> & { at: Place }) {
  return stretches(draft.phases).map(([start, end], index) => {
    const [from, room] = [at.x(start), at.x(end) - at.x(start)];
    return (
      <g key={index} aria-hidden onPointerDown={() => onSelect(index)}>
        <rect
          className={index === selected ? 'band-phase band-phase-on' : 'band-phase'}
          x={from}
          y={4}
          width={Math.max(0, room)}
          height={at.bottom - 4}
        />
        <text className="band-phase-name" x={from + room / 2} y={24} textAnchor="middle">
          {fitted(phaseName(draft.phases, index), room - 10, LETTER)}
        </text>
      </g>
    );
  });
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
  at,
  isOn,
  onSelect,
  onFactor,
}: {
  curve: PhaseCurve;
  handle: Handle;
  phaseTitle: string;
  at: Place;
  isOn: boolean;
  onSelect: () => void;
  onFactor: (factor: number | null) => void;
}) {
  const isFree = handle.value === null;
  const drag = useDrag((_, y) => {
    const isOut = handle.edge === 'above' ? y < at.top - OVER_RIM : y > at.bottom + OVER_RIM;
    onFactor(isOut ? null : factorFor(handle, at.y.invert(y)));
  });
  const onKeyDown = (event: KeyboardEvent) => {
    const far = event.shiftKey ? LARGE : 1;
    const step = { ArrowUp: far, ArrowRight: far, ArrowDown: -far, ArrowLeft: -far, PageUp: LARGE, PageDown: -LARGE }[
      event.key
    ];
    if (step !== undefined) onFactor(factorFor(handle, (handle.value ?? rimOf(handle, at)) + step * stepOf(curve)));
    else if (event.key.toLowerCase() === 'f') onFactor(isFree ? 1 : null);
    else return;
    event.preventDefault();
  };
  const x = at.x(handle.at / 100);
  const rim = handle.edge === 'above' ? at.top : at.bottom;
  const y = handle.value === null ? rim : Math.min(at.bottom, Math.max(at.top, at.y(handle.value)));
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
          {...((handle.edge === 'above' ? y < at.top + 34 : y > at.bottom - 34)
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
function rimOf(handle: Handle, at: Place): number {
  return at.y.invert(handle.edge === 'above' ? at.top : at.bottom);
}

function Border({ end, label, at, onMove }: { end: number; label: string; at: Place; onMove: (end: number) => void }) {
  const drag = useDrag((x) => onMove(at.x.invert(x)));
  const onKeyDown = (event: KeyboardEvent) => {
    const far = event.shiftKey ? LARGE : 1;
    const step = { ArrowRight: far, ArrowUp: far, ArrowLeft: -far, ArrowDown: -far, PageUp: LARGE, PageDown: -LARGE }[
      event.key
    ];
    if (step === undefined) return;
    onMove(end + step / 100);
    event.preventDefault();
  };
  const x = at.x(end);
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
      <line className="band-border-line" x1={x} x2={x} y1={10} y2={at.bottom} />
      <rect className="band-hit" x={x - 22} y={at.bottom - 6} width={44} height={44} />
      <circle className="band-pill" cx={x} cy={at.bottom + 16} r={13} />
      <path className="band-lines" d={`M${x - 3} ${at.bottom + 10}v12M${x + 3} ${at.bottom + 10}v12`} />
    </g>
  );
}
