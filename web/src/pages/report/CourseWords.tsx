// The therapist's words in the report of a course: read by all, written by who treats; on paper only the words.
import { Button, Group, Textarea } from '@mantine/core';
import { useState } from 'react';
import { useWriteCourseNote } from '../../api/queries';
import type { Course, Patient } from '../../api/types';
import { Problem } from '../../components/Feedback';
import { t } from '../../i18n';
import { date } from '../../lib/format';

const MOST = 4000;

export function CourseWords({ patient, course }: { patient: Patient; course: Course }) {
  const [draft, setDraft] = useState<string | null>(null);
  const write = useWriteCourseNote(patient.id);
  const note = course.note?.text ? course.note : null;
  return (
    <section aria-labelledby="course-words" className={note ? undefined : 'no-print'}>
      <h3 id="course-words">{t('course.words')}</h3>
      {draft === null ? (
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
            <Button className="no-print" variant="default" size="sm" onClick={() => setDraft(note?.text ?? '')}>
              {t(note ? 'course.rewrite' : 'course.write')}
            </Button>
          )}
        </>
      ) : (
        <div className="no-print stack">
          <Textarea
            label={t('course.wordsLabel')}
            description={note ? t('course.earlier') : undefined}
            autosize
            minRows={3}
            maxLength={MOST}
            value={draft}
            onChange={(event) => setDraft(event.currentTarget.value)}
          />
          {write.error && <Problem error={write.error} />}
          <Group>
            <Button
              loading={write.isPending}
              onClick={() =>
                write.mutate({ exercise_id: course.exercise_id, text: draft }, { onSuccess: () => setDraft(null) })
              }
            >
              {t('action.save')}
            </Button>
            <Button variant="default" onClick={() => setDraft(null)}>
              {t('action.cancel')}
            </Button>
          </Group>
        </div>
      )}
    </section>
  );
}
