// The therapist's words in the report of a course: read by all, written by who treats; on paper only the words.
import { Button, Group, Textarea } from '@mantine/core';
import { useState } from 'react';
import { useWriteCourseNote } from '../../api/queries';
import type { Course, Patient } from '../../api/types';
import { useSignedIn } from '../../components/account/useSignedIn';
import { Problem } from '../../components/Feedback';
import { useUnsaved } from '../../components/forms/useUnsaved';
import { t } from '../../i18n';
import { readDraft } from '../../lib/editing/drafts';
import { date } from '../../lib/format';

const MOST = 4000;

export function CourseWords({ patient, course }: { patient: Patient; course: Course }) {
  const { account_id: account } = useSignedIn();
  // Words that were not saved are offered at once.
  const [isOpen, setOpen] = useState(() => patient.may_treat && readDraft(account, objectOf(patient, course)) !== null);
  const note = course.note?.text ? course.note : null;
  return (
    <section aria-labelledby="course-words" className={note ? undefined : 'no-print'}>
      <h3 id="course-words">{t('course.words')}</h3>
      {!isOpen ? (
        <>
          {note ? (
            <>
              <p className="paper-words">{note.text}</p>
              <p className="paper-note">
                {t('course.wordsBy', { name: note.written_by, date: date(note.created_at, new Date(0)) })}
              </p>
            </>
          ) : (
            <p>{t('course.noWords')}</p>
          )}
          {patient.may_treat && (
            <Button className="no-print" variant="default" size="sm" onClick={() => setOpen(true)}>
              {t(note ? 'course.rewrite' : 'course.write')}
            </Button>
          )}
        </>
      ) : (
        <Writing patient={patient} course={course} before={note?.text ?? ''} onDone={() => setOpen(false)} />
      )}
    </section>
  );
}

const objectOf = (patient: Patient, course: Course) => `course-note:${patient.id}:${course.exercise_id}`;

function Writing({
  patient,
  course,
  before,
  onDone,
}: {
  patient: Patient;
  course: Course;
  before: string;
  onDone: () => void;
}) {
  const [text, setText] = useState(before);
  const write = useWriteCourseNote(patient.id);
  const { guard, release } = useUnsaved({
    object: objectOf(patient, course),
    value: text,
    isChanged: text !== before,
    onRestore: setText,
  });
  const done = () => {
    release();
    onDone();
  };
  return (
    <div className="no-print stack">
      {guard}
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
          onClick={() => write.mutate({ exercise_id: course.exercise_id, text }, { onSuccess: done })}
        >
          {t('action.save')}
        </Button>
        <Button variant="default" onClick={done}>
          {t('action.cancel')}
        </Button>
      </Group>
    </div>
  );
}
