import { Select } from '@mantine/core';
import { useState } from 'react';
import { useParams, useSearchParams } from 'react-router';
import { useExercises, usePatient, usePrescriptions } from '../../api/queries';
import type { Patient } from '../../api/types';
import { QueryBoundary } from '../../components/Feedback';
import { RadioCards } from '../../components/forms/Choice';
import { Page } from '../../components/Page';
import { t } from '../../i18n';
import { KINDS, kindFor, kindOf } from '../../kinds';
import { BeginWorn } from '../../kinds/BeginForm';
import type { BeginProps, SessionKind } from '../../kinds/kind';
import { panelsOf } from '../../kinds/panels';
import { exerciseOf } from '../../lib/exercises';
import { fullName } from '../../lib/people';

function Form({ patient }: { patient: Patient }) {
  const [search] = useSearchParams();
  const purpose = search.get('purpose') === 'template' ? 'template' : 'exercise';
  const exercises = useExercises();
  const prescribed = usePrescriptions(patient.id).data ?? [];
  const [picked, setPicked] = useState<string | null>(search.get('exercise'));
  const [kind, setKind] = useState<SessionKind['pipeline'] | null>(null);
  const exerciseId = picked ?? prescribed[0]?.exercise_id ?? null;
  const exercise = exerciseOf(exercises.data, exerciseId);
  const movement = exercise?.movement;
  const offered = KINDS.flatMap(({ pipeline, begin }) =>
    begin && (begin.isTemplate || purpose !== 'template') ? [{ pipeline, begin }] : [],
  );
  const pipeline = kind ?? kindFor(movement).pipeline;
  const Begin = panelsOf({ pipeline }).Begin ?? BeginWorn;
  const prescription = purpose === 'exercise' ? prescribed.find((one) => one.exercise_id === exerciseId) : undefined;
  const names = new Map((exercises.data ?? []).map((one) => [one.id, one.name]));
  const prescribedIds = new Set(prescribed.map((one) => one.exercise_id));
  const groups = [
    {
      group: t('newSession.prescribed'),
      items: [...prescribedIds].map((id) => ({ value: id, label: names.get(id) ?? id })),
    },
    {
      group: t('newSession.others'),
      items: (exercises.data ?? [])
        .filter((one) => !prescribedIds.has(one.id))
        .map((one) => ({ value: one.id, label: one.name })),
    },
  ].filter((group) => group.items.length > 0);
  // The choice of a kind is no part of the form that it changes: a keyboard stays on it.
  return (
    <div className="card stack form-card">
      {!kindOf({ pipeline }).begin?.isApart && (
        <Select
          label={t('newSession.exercise')}
          searchable
          data={groups}
          value={exerciseId}
          onChange={setPicked}
          placeholder={t('prescription.chooseExercise')}
          nothingFoundMessage={t('newSession.noExercise')}
          maw={480}
        />
      )}
      <RadioCards<SessionKind['pipeline']>
        legend={t('newSession.kind')}
        value={pipeline}
        onChange={setKind}
        options={offered.map(({ pipeline: value, begin }) => ({ value, title: begin.title(), text: begin.text() }))}
      />
      <Begin
        key={pipeline}
        patient={patient}
        pipeline={pipeline as BeginProps['pipeline']}
        purpose={purpose}
        exercise={{ exercise_id: exerciseId, prescription_id: prescription?.id ?? null }}
        angle={exercise?.primary_angle}
      />
    </div>
  );
}

export function NewSessionPage() {
  const { patientId = '' } = useParams();
  const [search] = useSearchParams();
  const patient = usePatient(patientId);
  const name = patient.data ? fullName(patient.data) : t('patient.title');
  return (
    <Page
      narrow
      title={search.get('purpose') === 'template' ? t('newSession.titleTemplate') : t('newSession.title')}
      lead={patient.data ? t('newSession.lead', { name }) : undefined}
      crumbs={[
        { to: '/', text: t('nav.caseload') },
        { to: `/patients/${patientId}`, text: name },
      ]}
    >
      <QueryBoundary of={patient} lines={8}>
        {(data) => <Form patient={data} />}
      </QueryBoundary>
    </Page>
  );
}
