// After an exercise: two questions with two taps, a third of the therapist's, words if wanted, and one true sentence.
import { Button, Textarea } from '@mantine/core';
import { IconCheck } from '@tabler/icons-react';
import { useMutation, useQueryClient } from '@tanstack/react-query';
import { useState } from 'react';
import { byHand } from '../../../api/client';
import { key, ofSession } from '../../../api/address';
import { useAnswers, useProgress } from '../../../api/queries';
import type { AnswersIn, GuidanceMessage, SessionDetail } from '../../../api/types';
import { t } from '../../../i18n';
import { isSure } from '../../../lib/assessment/trend';
import { mainMeasure, plainProgress } from '../../../lib/plain';
import { PlainProblem } from '../PlainProblem';
import { hasHurt } from './hurt';
import './After.css';

const MARKS = Array.from({ length: 11 }, (_, mark) => mark);
type Question = 'pain' | 'effort' | 'third';

/** Eleven large marks with words at both ends. */
function Scale({
  name,
  question,
  value,
  from = 0,
  onChange,
}: {
  name: Question;
  question: string;
  value: number | null;
  /** The least mark: who stopped because it hurt is not asked whether it did. */
  from?: 0 | 1;
  onChange: (mark: number) => void;
}) {
  return (
    <fieldset className="after-scale">
      <legend>{question}</legend>
      <div className="after-marks">
        {MARKS.slice(from).map((mark) => (
          <label key={mark} className={value === mark ? 'after-mark after-chosen' : 'after-mark'}>
            <input type="radio" name={name} value={mark} checked={value === mark} onChange={() => onChange(mark)} />
            {mark}
          </label>
        ))}
      </div>
      <p className="after-ends">
        <span>
          {from}: {from === 1 ? t('after.hurt.least') : t(`after.${name}.least`)}
        </span>
        <span>10: {t(`after.${name}.most`)}</span>
      </p>
    </fieldset>
  );
}

/** What was counted, as the time line holds it: a page that is loaded again hears no guidance of a closed session. */
function validOf(session: SessionDetail): number {
  return session.events.filter((one) => {
    const text = one.sentences?.text;
    return one.kind === 'repetition' && text && !Array.isArray(text) && text.code === 'guided.valid';
  }).length;
}

/** One sentence that is true: a change only where it is larger than its uncertainty, else what was done. */
function TrueWord({ session, guidance }: { session: SessionDetail; guidance: GuidanceMessage | null }) {
  const progress = useProgress(session.patient_id, session.exercise_id ?? null);
  const main = mainMeasure(progress.data?.measures ?? []);
  const newest = main?.points.at(-1);
  const valid = guidance?.counts.valid ?? validOf(session);
  const did = valid > 0 ? t('after.did', { count: valid }) : t('after.didNone');
  const said = main && newest?.session_id === session.id && isSure(main) ? plainProgress(main) : null;
  return <p className="mine-say">{said ?? did}</p>;
}

export default function After({ session, guidance }: { session: SessionDetail; guidance: GuidanceMessage | null }) {
  const client = useQueryClient();
  const stored = useAnswers(session.id);
  const [said, setSaid] = useState<AnswersIn>({});
  const send = useMutation({
    mutationFn: () => byHand.put('/api/sessions/{session_id}/answers', { ...ofSession(session.id), body: said }),
    onSuccess: (answers) => client.setQueryData(key('sessions', session.id, 'answers'), answers),
  });
  const isHurt = hasHurt(session, guidance);
  const set = (name: Question) => (mark: number) => setSaid({ ...said, [name]: mark });
  if (stored.data?.answered_at)
    return (
      <section className="card after-sent" role="status">
        {!isHurt && <TrueWord session={session} guidance={guidance} />}
        <p className="after-thanks">
          <IconCheck size={24} aria-hidden /> {t('after.sent')}
        </p>
      </section>
    );
  return (
    <section className="card stack" aria-labelledby="after-title">
      {!isHurt && <TrueWord session={session} guidance={guidance} />}
      <h2 id="after-title">{t('after.title')}</h2>
      <Scale
        name="pain"
        question={t(isHurt ? 'after.hurt' : 'after.pain')}
        from={isHurt ? 1 : 0}
        value={said.pain ?? null}
        onChange={set('pain')}
      />
      <Scale name="effort" question={t('after.effort')} value={said.effort ?? null} onChange={set('effort')} />
      {stored.data?.question && (
        <Scale name="third" question={stored.data.question} value={said.third ?? null} onChange={set('third')} />
      )}
      <Textarea
        size="lg"
        autosize
        minRows={2}
        maxLength={2000}
        label={t('after.note')}
        value={said.note ?? ''}
        onChange={(event) => setSaid({ ...said, note: event.currentTarget.value })}
      />
      <Button
        size="xl"
        fullWidth
        disabled={Object.keys(said).length === 0}
        loading={send.isPending}
        onClick={() => send.mutate()}
      >
        {t('after.send')}
      </Button>
      {send.error && <PlainProblem error={send.error} />}
    </section>
  );
}
