// Small signs that never rely on colour: each has a shape and a word.
import {
  IconArrowDownRight,
  IconArrowsDiagonal,
  IconBroadcast,
  IconCalendarOff,
  IconHandStop,
  IconMoodSad,
  IconPlugConnectedX,
  IconRepeatOff,
  IconRouteOff,
  IconWifiOff,
} from '@tabler/icons-react';
import type { CaseloadRow, SessionState, Side } from '../api/types';
import { t } from '../i18n';
import './Marks.css';

/** The affected side: the filled half of the circle is the patient's own left or right, seen from behind. */
export function SideMark({ side }: { side: Side | null }) {
  if (!side) return null;
  return (
    <span className="side-mark">
      <svg width="15" height="15" viewBox="0 0 16 16" aria-hidden>
        <circle cx="8" cy="8" r="6.9" fill="none" stroke="currentColor" strokeWidth="1.6" />
        {side !== 'right' && <path d="M8 1.1a6.9 6.9 0 0 0 0 13.8z" fill="currentColor" />}
        {side !== 'left' && <path d="M8 1.1a6.9 6.9 0 0 1 0 13.8z" fill="currentColor" />}
      </svg>
      {t(`affected.${side}`)}
    </span>
  );
}

const REASONS = {
  pain: { Icon: IconMoodSad, tone: 'tag-alert' },
  stop: { Icon: IconHandStop, tone: 'tag-alert' },
  declining: { Icon: IconArrowDownRight, tone: 'tag-alert' },
  link_lost: { Icon: IconPlugConnectedX, tone: 'tag-alert' },
  compensation: { Icon: IconArrowsDiagonal, tone: '' },
  few_repetitions: { Icon: IconRepeatOff, tone: '' },
  bad_data: { Icon: IconWifiOff, tone: '' },
  not_practising: { Icon: IconCalendarOff, tone: '' },
  rarely_practised: { Icon: IconCalendarOff, tone: '' },
  no_template: { Icon: IconRouteOff, tone: '' },
} as const;

/** Why to look at this patient today. */
export function ReasonMark({ reason }: { reason: Exclude<CaseloadRow['reason'], ''> }) {
  const { Icon, tone } = REASONS[reason];
  return (
    <span className={`tag ${tone}`}>
      <Icon size={17} aria-hidden />
      {t(`reason.${reason}`)}
    </span>
  );
}

/** That a session is open now: no reason to worry by itself, so it stands beside the reason. */
export function LiveMark({ state }: { state: NonNullable<CaseloadRow['live_state']> }) {
  const isStreaming = state === 'streaming';
  const Icon = isStreaming ? IconBroadcast : IconPlugConnectedX;
  return (
    <span className={isStreaming ? 'tag tag-accent' : 'tag'}>
      <Icon size={17} aria-hidden />
      {t(isStreaming ? 'live.now' : 'reason.link_lost')}
    </span>
  );
}

/** State of a session in a word. */
export function StateMark({ state }: { state: SessionState }) {
  const tone =
    state === 'failed' || state === 'link_lost'
      ? 'tag-alert'
      : state === 'recording' || state === 'ready' || state === 'calibrating'
        ? 'tag-accent'
        : '';
  return <span className={`tag ${tone}`}>{t(`sessionState.${state}`)}</span>;
}
