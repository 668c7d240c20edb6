// The therapist's words in the report of a course: read by all, written by who treats; on paper only the words that are saved.
import { Button, Group, Textarea } from '@mantine/core';
import { useState } from 'react';
import { useWriteCourseNote } from '../../api/changes';
import type { Course, Patient } from '../../api/types';
import { Problem } from '../../components/Feedback';
import { useUnsaved } from '../../components/forms/useUnsaved';
import { t } from '../../i18n';
import { date } from '../../lib/format';
import './CourseWords.css';

const MOST = 4000;

export function CourseWords({ patient, course }: { patient: Patient; course: Course }) {
  const note = course.note?.text ? course.note : null;
  // Begun anew after each save or cancel.
  const [round, setRound] = useState(0);
  return (
    <section aria-labelledby="course-words" className={note ? undefined : 'no-print'}>
      <h3 id="course-words">{t('course.words')}</h3>
      {patient.may_treat ? (
        <Words
          key={`${course.exercise_id} ${round}`}
          patient={patient}
          course={course}
          onDone={() => setRound((now) => now + 1)}
        />
      ) : (
        <Saved note={note} />
      )}
    </section>
  );
}

function Saved({ note }: { note: Course['note'] }) {
  if (!note?.text) return <p>{t('course.noWords')}</p>;
  return (
    <>
      <p className="paper-words">{note.text}</p>
      <p className="paper-note">
        {t('course.wordsBy', { name: note.written_by, date: date(note.created_at, new Date(0)) })}
      </p>
    </>
  );
}

/** The saved words, which a print shows while they are rewritten too, and the field that rewrites them. */
function Words({ patient, course, onDone }: { patient: Patient; course: Course; onDone: () => void }) {
  const before = course.note?.text ?? '';
  const [text, setText] = useState<string | null>(null);
  const isOpen = text !== null;
  const { guard, release } = useUnsaved({
    object: `course-note:${patient.id}:${course.exercise_id}`,
    value: text ?? before,
    isChanged: isOpen && text !== before,
    onRestore: setText,
  });
  const write = useWriteCourseNote(patient.id, release);
  return (
    <>
      <div className={isOpen ? 'print-only' : undefined}>
        <Saved note={course.note} />
      </div>
      <div className="no-print stack">
        {guard}
        {isOpen ? (
          <>
            <Textarea
              label={t('course.wordsLabel')}
              description={before ? t('course.earlier') : undefined}
              autosize
              minRows={3}
              maxLength={MOST}
              value={text}
              onChange={(event) => setText(event.currentTarget.value)}
            />
            {write.error && <Problem error={write.error} />}
            <Group>
              <Button
                loading={write.isPending}
                onClick={() => write.mutate({ exercise_id: course.exercise_id, text }, { onSuccess: onDone })}
              >
                {t('action.save')}
              </Button>
              <Button
                variant="default"
                onClick={() => {
                  release();
                  onDone();
                }}
              >
                {t('action.cancel')}
              </Button>
            </Group>
          </>
        ) : (
          <div>
            <Button variant="default" size="sm" onClick={() => setText(before)}>
              {t(before ? 'course.rewrite' : 'course.write')}
            </Button>
          </div>
        )}
      </div>
    </>
  );
}
