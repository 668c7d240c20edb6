// How many repetitions, large enough to be read from beside the patient.
import type { GuidanceMessage } from '../../../api/types';
import { t } from '../../../i18n';
import './Repetitions.css';

/** Nothing where nothing is counted; of what is not heard any more no number stands for now. */
export function Repetitions({ guidance, isKnown }: { guidance: GuidanceMessage | null; isKnown: boolean }) {
  if (!guidance || guidance.status === 'off') return null;
  const { valid = 0, partial = 0, wrong = 0 } = guidance.counts;
  const { goal = 0, before = 0 } = guidance;
  const done = before + valid;
  return (
    <div className="live-count">
      <span className="live-number number" data-testid="repetitions">
        {isKnown ? valid : '–'}
      </span>
      <span>
        <span className="strong">{t('live.repetitions', { count: valid })}</span>
        {isKnown && (
          <span className="muted small live-count-more">
            {[
              goal ? t(done > goal ? 'live.repetitionsBeyond' : 'live.repetitionsGoal', { goal, count: done }) : '',
              partial ? t('doing.partial', { count: partial }) : '',
              wrong ? t('doing.wrong', { count: wrong }) : '',
            ]
              .filter(Boolean)
              .join(' · ')}
          </span>
        )}
      </span>
    </div>
  );
}
