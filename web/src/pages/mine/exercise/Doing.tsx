// The exercise while it is done: what to do now in one line, how many, and three buttons that are always there.
import { Button } from '@mantine/core';
import {
  IconHeartBroken,
  IconPlayerPauseFilled,
  IconPlayerPlayFilled,
  IconPlayerStopFilled,
} from '@tabler/icons-react';
import { useState } from 'react';
import type { GuidanceMessage, Posture } from '../../../api/types';
import { t } from '../../../i18n';
import { useKeys } from '../../../lib/browser/keys';
import { forPosture } from '../../../lib/posture';
import type { Hold } from './useHold';
import { canSpeak, keepVoice, useVoice, wantsVoice } from './voice';
import './Doing.css';

/** The one thing to say; nothing is said of what is not known. */
function lineOf(guidance: GuidanceMessage | null, posture: Posture | undefined): string {
  if (guidance?.cue) return guidance.cue;
  if (guidance?.status === 'waiting') return forPosture('waiting', posture);
  if (guidance?.status === 'ready') return t('doing.ready');
  if (guidance?.status === 'moving') return t('doing.moving');
  return t('doing.free');
}

export function Count({ guidance }: { guidance: GuidanceMessage }) {
  const { valid = 0, partial = 0, wrong = 0 } = guidance.counts;
  const today = doneOf(guidance);
  const goal = guidance.goal ?? 0;
  // Large is what is done in this round; what earlier rounds of the day have brought stands small beside it.
  const line =
    goal > 0 ? (guidance.before ? (today > goal ? 'todayBeyond' : 'todayOf') : valid > goal ? 'beyond' : 'of') : null;
  return (
    <div className="doing-count" role="status" aria-label={t('doing.count')}>
      <p className="doing-number">
        <span key={valid}>{valid}</span>
        {line && <span className="doing-goal">{t(`doing.${line}`, { goal, count: today })}</span>}
      </p>
      {(partial > 0 || wrong > 0) && (
        <p className="doing-others">
          {partial > 0 && <span>{t('doing.partial', { count: partial })}</span>}
          {wrong > 0 && <span>{t('doing.wrong', { count: wrong })}</span>}
        </p>
      )}
    </div>
  );
}

/** What was done of the goal: also in an earlier session of the day. */
function doneOf(guidance: GuidanceMessage | null): number {
  return (guidance?.before ?? 0) + (guidance?.counts.valid ?? 0);
}

/** What is still to be done today; 0 where nothing is prescribed. */
function leftOf(guidance: GuidanceMessage | null): number {
  return Math.max(0, (guidance?.goal ?? 0) - doneOf(guidance));
}

interface NowProps {
  guidance: GuidanceMessage | null;
  hold: Hold;
  /** How the exercise is done; undefined while that is not known. */
  posture: Posture | undefined;
  /** What would be missing if she went on now. */
  missing?: 'silent' | 'lost' | null;
  onFinish: () => void;
  isEnding: boolean;
}

function HeldCard({ guidance, hold, missing, onFinish, isEnding }: NowProps) {
  const held = hold.held ?? 'person';
  const isOver = held === 'done' || held === 'enough' || held === 'time' || held === 'finish';
  const goOn = (
    <Button
      key="go"
      size="xl"
      fullWidth
      variant={isOver || held === 'pain' ? 'default' : 'filled'}
      leftSection={<IconPlayerPlayFilled size={26} aria-hidden />}
      loading={hold.isBusy}
      onClick={hold.goOn}
    >
      {held === 'done' || held === 'time' ? t('doing.more') : t('doing.goOn')}
    </Button>
  );
  const finish = (
    <Button
      key="finish"
      size="xl"
      fullWidth
      variant={isOver || held === 'pain' ? 'filled' : 'default'}
      leftSection={<IconPlayerStopFilled size={26} aria-hidden />}
      loading={isEnding}
      onClick={onFinish}
    >
      {t('doing.finish')}
    </Button>
  );
  return (
    <section className={`card home-moment doing-held doing-held-${held}`}>
      <div role="status">
        <h2>{t(`doing.held.${held}`)}</h2>
        <p>{held === 'set' ? t('doing.held.set.text', { count: leftOf(guidance) }) : t(`doing.held.${held}.text`)}</p>
        {/* Its place is there before it is known: what comes in late must not move the buttons under a thumb. */}
        {held === 'pain' && (
          <p className={hold.isPainKnown ? undefined : 'doing-not-yet'} aria-hidden={!hold.isPainKnown}>
            {t('doing.held.pain.known')}
          </p>
        )}
      </div>
      <div className="doing-choice">{isOver || held === 'pain' ? [finish, goOn] : [goOn, finish]}</div>
      {hold.isUnreached ? (
        <p className="problem" role="alert">
          {t('doing.notReached')}
        </p>
      ) : (
        missing && <p className="muted">{t(`doing.held.without.${missing}`)}</p>
      )}
    </section>
  );
}

function Buttons({ hold }: { hold: Hold }) {
  const isHeld = hold.held !== null;
  return (
    <div className="doing-bar" role="group" aria-label={t('doing.buttons')}>
      <button type="button" className="doing-button" disabled={isHeld} onClick={() => hold.hold('person')}>
        <IconPlayerPauseFilled size={30} aria-hidden />
        {t('doing.pause')}
      </button>
      <button
        type="button"
        className="doing-button doing-pain"
        disabled={hold.held === 'pain'}
        onClick={() => hold.hold('pain')}
      >
        <IconHeartBroken size={30} aria-hidden />
        {t('doing.pain')}
      </button>
      <button
        type="button"
        className="doing-button"
        disabled={hold.held === 'finish'}
        onClick={() => hold.hold('finish')}
      >
        <IconPlayerStopFilled size={30} aria-hidden />
        {t('doing.stop')}
      </button>
    </div>
  );
}

/** What to do now, or why nothing is counted, and what can be done about it. */
export function NowLine(props: NowProps) {
  const { guidance, hold, posture } = props;
  if (hold.held !== null) return <HeldCard {...props} />;
  return (
    <p
      className={guidance?.cue ? 'doing-line doing-cue' : 'doing-line'}
      role="status"
      aria-live="assertive"
      data-testid="line"
    >
      {lineOf(guidance, posture)}
    </p>
  );
}

/** Three buttons that are always there, and the count by voice. */
export function Controls({ guidance, hold }: { guidance: GuidanceMessage | null; hold: Hold }) {
  const [isAloud, setAloud] = useState(wantsVoice);
  const valid = guidance?.counts.valid ?? 0;
  const isOn = isAloud && hold.held === null;
  useVoice(isOn, valid, t('doing.say', { count: valid }));
  useVoice(isOn, guidance?.cue_number ?? 0, guidance?.cue ?? '');
  useKeys({ escape: () => hold.held === null && hold.hold('person') });
  return (
    <>
      {guidance?.status === 'failed' && <p className="muted">{t('doing.alone')}</p>}
      {isGuided(guidance) && canSpeak() && (
        <label className="doing-aloud">
          <input
            type="checkbox"
            role="switch"
            checked={isAloud}
            onChange={(event) => {
              setAloud(event.currentTarget.checked);
              keepVoice(event.currentTarget.checked);
            }}
          />
          {t('doing.aloud')}
        </label>
      )}
      <Buttons hold={hold} />
    </>
  );
}

/** Whether repetitions are counted here. */
export function isGuided(guidance: GuidanceMessage | null): guidance is GuidanceMessage {
  return guidance !== null && guidance.status !== 'off';
}
