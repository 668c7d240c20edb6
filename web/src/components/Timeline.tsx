// The time line of a replay: a slider for hand and keyboard, repetitions as blocks, events as marks.
import { ActionIcon, Button, SegmentedControl } from '@mantine/core';
import {
  IconPlayerPauseFilled,
  IconPlayerPlayFilled,
  IconPlayerSkipBackFilled,
  IconPlayerSkipForwardFilled,
} from '@tabler/icons-react';
import type { KeyboardEvent } from 'react';
import type { Repetition, SessionEvent } from '../api/types';
import { t } from '../i18n';
import { eventText } from '../lib/events';
import { plainTick, position } from '../lib/format';
import { repetitionAt } from '../lib/assessment/warp';
import { useClockText, useSnapshot } from '../player/hooks';
import type { Player } from '../player/types';
import './Timeline.css';

export interface TimelineProps {
  player: Player;
  repetitions: readonly Repetition[];
  events: readonly SessionEvent[];
  onRepetition?: (repetition: Repetition) => void;
  /** They are the strides of a walk. */
  areStrides?: boolean;
}

const SPEEDS = ['0.25', '0.5', '1', '2'] as const;
const SHOWN_EVENTS = new Set([
  'gap',
  'sensor_lost',
  'sensor_back',
  'sensor_slipped',
  'forces_lost',
  'forces_back',
  'mark',
  'error',
  'calibration',
  'calibration_checked',
  'implausible',
  'not_practised',
  'cue',
  'pain',
  'guidance_pause',
  'guidance_stop',
  'guidance_off',
  'limit_at_rest',
]);

export function Timeline({ player, repetitions, events, onRepetition, areStrides = false }: TimelineProps) {
  const numbered = (number: number) => t(areStrides ? 'repetition.stride' : 'repetition.numbered', { number });
  const { isPlaying, speed } = useSnapshot(player);
  const timeS = useClockText(player, 50);
  const { startS, endS } = player.clock();
  const length = Math.max(endS - startS, 1e-3);
  const share = (at: number) => `${(100 * Math.min(Math.max(at - startS, 0), length)) / length}%`;
  const here = repetitionAt(repetitions, timeS);
  const shown = events.filter(
    (event) => SHOWN_EVENTS.has(event.kind) && event.time_s >= startS && event.time_s <= endS,
  );
  const jump = (direction: 1 | -1) => {
    const starts = repetitions.map((one) => one.start_s);
    const target =
      direction > 0 ? starts.find((start) => start > timeS + 0.05) : starts.findLast((start) => start < timeS - 0.3);
    player.seek(target ?? (direction > 0 ? endS : startS));
  };
  const step = (event: KeyboardEvent<HTMLInputElement>) => {
    const seconds = event.key === 'PageUp' || event.key === 'PageDown' ? 5 : event.shiftKey ? 1 : 0.1;
    const direction = { ArrowLeft: -1, ArrowDown: -1, PageDown: -1, ArrowRight: 1, ArrowUp: 1, PageUp: 1 }[event.key];
    if (direction === undefined) return;
    event.preventDefault();
    player.seek(player.clock().timeS + direction * seconds);
  };
  return (
    <div className="timeline">
      <div className="timeline-track">
        <div className="timeline-blocks" aria-hidden>
          {repetitions.map((one) => (
            <span
              key={one.number}
              className={`block ${one.is_kept ? '' : 'block-dropped'} ${here?.number === one.number ? 'block-here' : ''}`}
              style={{ left: share(one.start_s), width: `calc(${(100 * (one.end_s - one.start_s)) / length}% - 2px)` }}
            >
              <span>{one.number}</span>
            </span>
          ))}
          {shown.map((event, index) => (
            <span
              key={`${event.time_s}${index}`}
              className={event.duration_s > 0 ? 'event event-long' : 'event'}
              style={{
                left: share(event.time_s),
                width: event.duration_s > 0 ? `${(100 * event.duration_s) / length}%` : undefined,
              }}
            />
          ))}
        </div>
        <input
          type="range"
          className="timeline-slider"
          aria-label={t('timeline.position')}
          aria-valuetext={
            t('timeline.at', { at: position(timeS - startS), of: position(length) }) +
            (here ? `, ${numbered(here.number)}` : '')
          }
          min={startS}
          max={endS}
          step={0.01}
          value={timeS}
          onChange={(event) => player.seek(Number(event.currentTarget.value))}
          onKeyDown={step}
        />
      </div>
      <div className="transport">
        <ActionIcon
          size={44}
          color="gray"
          aria-label={t(areStrides ? 'timeline.previousStride' : 'timeline.previous')}
          title={t(areStrides ? 'timeline.previousStride' : 'timeline.previous')}
          onClick={() => jump(-1)}
        >
          <IconPlayerSkipBackFilled size={22} aria-hidden />
        </ActionIcon>
        <ActionIcon
          size={52}
          radius="xl"
          variant="filled"
          aria-label={isPlaying ? t('timeline.pause') : t('timeline.play')}
          onClick={() => (isPlaying ? player.pause() : player.play())}
        >
          {isPlaying ? <IconPlayerPauseFilled size={26} aria-hidden /> : <IconPlayerPlayFilled size={26} aria-hidden />}
        </ActionIcon>
        <ActionIcon
          size={44}
          color="gray"
          aria-label={t(areStrides ? 'timeline.nextStride' : 'timeline.next')}
          title={t(areStrides ? 'timeline.nextStride' : 'timeline.next')}
          onClick={() => jump(1)}
        >
          <IconPlayerSkipForwardFilled size={22} aria-hidden />
        </ActionIcon>
        <span className="number timeline-time">
          <span className="strong">{position(timeS - startS)}</span> <span className="muted">/ {position(length)}</span>
        </span>
        <SegmentedControl
          size="sm"
          className="speeds"
          aria-label={t('timeline.speed')}
          value={String(speed)}
          onChange={(value) => player.setSpeed(Number(value))}
          data={SPEEDS.map((value) => ({ value, label: `${plainTick(Number(value), 2)}×` }))}
        />
      </div>
      {repetitions.length > 0 && (
        <div
          className="repetition-row"
          role="group"
          aria-label={t(areStrides ? 'timeline.strides' : 'timeline.repetitions')}
        >
          {repetitions.map((one) => (
            <Button
              key={one.number}
              size="compact-md"
              variant={here?.number === one.number ? 'filled' : 'default'}
              aria-label={`${numbered(one.number)}, ${position(one.start_s - startS)}${one.is_kept ? '' : `, ${t('repetition.leftOut')}`}`}
              aria-pressed={here?.number === one.number}
              onClick={() => {
                player.seek(one.start_s);
                onRepetition?.(one);
              }}
            >
              {one.number}
              {one.is_kept ? '' : '*'}
            </Button>
          ))}
          {repetitions.some((one) => !one.is_kept) && <span className="muted small">{t('timeline.starMeans')}</span>}
        </div>
      )}
      {shown.length > 0 && (
        <details className="as-table">
          <summary>{t('timeline.events', { count: shown.length })}</summary>
          <ul className="plain-list events small">
            {shown.map((event, index) => (
              <li key={`${event.time_s}${index}`}>
                <Button variant="subtle" size="compact-md" onClick={() => player.seek(event.time_s)}>
                  {position(event.time_s - startS)}
                </Button>{' '}
                {eventText(event)}
              </li>
            ))}
          </ul>
        </details>
      )}
    </div>
  );
}
