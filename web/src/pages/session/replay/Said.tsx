// What the patient said after the exercise, in numbers with their ends and in words; nothing where nothing was said.
import { Fragment } from 'react';
import { useAnswers } from '../../../api/queries';
import type { SessionDetail } from '../../../api/types';
import { t } from '../../../i18n';
import { dateTime } from '../../../lib/format';

export function Said({ session }: { session: SessionDetail }) {
  const { data: said } = useAnswers(session.id, Boolean(session.exercise_id));
  if (!said?.answered_at) return null;
  const marks = [
    [t('said.pain'), said.pain],
    [t('said.effort'), said.effort],
    [said.question, said.third],
  ] as const;
  return (
    <section className="card" aria-labelledby="said-title">
      <h2 id="said-title">{t('said.title')}</h2>
      <dl className="facts">
        {marks.map(
          ([name, mark]) =>
            typeof mark === 'number' && (
              <Fragment key={name}>
                <dt>{name}</dt>
                <dd>{t('said.mark', { mark })}</dd>
              </Fragment>
            ),
        )}
        {said.note && (
          <>
            <dt>{t('said.note')}</dt>
            <dd>{said.note}</dd>
          </>
        )}
      </dl>
      <p className="muted small">{t('said.when', { when: dateTime(said.answered_at) })}</p>
    </section>
  );
}
