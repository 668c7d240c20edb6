import { IconCheck } from '@tabler/icons-react';
import type { SessionState } from '../../../api/types';
import { t } from '../../../i18n';
import './StateSteps.css';

const STEPS = ['connect', 'calibrate', 'ready', 'record', 'analyse'] as const;

const STEP_OF: Record<Exclude<SessionState, 'link_lost' | 'failed'>, number> = {
  created: 0,
  calibrating: 1,
  ready: 2,
  recording: 3,
  closing: 4,
  analysed: 5,
};

/** The step a state belongs to; a lost link stays at the step that was reached. */
export function stepOf(
  state: SessionState,
  before: number,
  reached: { isCalibrated: boolean; isRecording: boolean },
): number {
  if (state !== 'link_lost' && state !== 'failed') return STEP_OF[state];
  return Math.max(before, reached.isRecording ? 3 : reached.isCalibrated ? 2 : 1);
}

/** Where the session stands, as steps with words. */
export function StateSteps({ step }: { step: number }) {
  return (
    <ol className="steps" aria-label={t('steps.title')}>
      {STEPS.map((name, index) => {
        const kind = index < step ? 'done' : index === step ? 'now' : 'later';
        return (
          <li key={name} className={`step step-${kind}`} aria-current={kind === 'now' ? 'step' : undefined}>
            <span className="step-mark" aria-hidden>
              {kind === 'done' ? <IconCheck size={15} stroke={3} /> : index + 1}
            </span>
            {t(`steps.${name}`)}
            {kind === 'done' && <span className="visually-hidden"> ({t('steps.done')})</span>}
          </li>
        );
      })}
    </ol>
  );
}
