// A session under the wrong patient or exercise is put right: who did it, which exercise it was, and why.
import { Button, Modal, Select, Textarea } from '@mantine/core';
import { useDisclosure } from '@mantine/hooks';
import { useState } from 'react';
import { useMoveSession } from '../../../api/changes';
import { useExercises, usePatients } from '../../../api/queries';
import type { SessionDetail } from '../../../api/types';
import { Problem } from '../../../components/Feedback';
import { t } from '../../../i18n';
import { fullName } from '../../../lib/people';

function Form({ session, onDone }: { session: SessionDetail; onDone: () => void }) {
  const patients = usePatients();
  const exercises = useExercises();
  const move = useMoveSession(session.id);
  const [patientId, setPatientId] = useState<string>(session.patient_id);
  const [exerciseId, setExerciseId] = useState<string | null>(session.exercise_id);
  const [reason, setReason] = useState('');
  const isOther = patientId !== session.patient_id;
  const isChanged = isOther || (exerciseId !== null && exerciseId !== session.exercise_id);
  return (
    <div className="stack">
      <p>{t('move.text')}</p>
      {patients.error && <Problem error={patients.error} />}
      {move.error && <Problem error={move.error} />}
      <Select
        label={t('move.patient')}
        searchable
        allowDeselect={false}
        data={(patients.data ?? [])
          .filter((one) => one.may_treat || one.id === session.patient_id)
          .map((one) => ({ value: one.id, label: fullName(one) }))}
        value={patientId}
        onChange={(value) => setPatientId(value ?? session.patient_id)}
      />
      <Select
        label={t('move.exercise')}
        searchable
        allowDeselect={false}
        data={(exercises.data ?? []).map((one) => ({ value: one.id, label: one.name }))}
        value={exerciseId}
        onChange={setExerciseId}
      />
      <Textarea
        label={t('move.reason')}
        description={t('move.reasonHelp')}
        maxLength={300}
        value={reason}
        onChange={(event) => setReason(event.currentTarget.value)}
      />
      <div className="details-foot">
        <Button variant="default" onClick={onDone}>
          {t('action.cancel')}
        </Button>
        <Button
          disabled={!isChanged || reason.trim() === ''}
          loading={move.isPending}
          onClick={() =>
            move.mutate(
              {
                patient_id: isOther ? patientId : null,
                exercise_id: exerciseId === session.exercise_id ? null : exerciseId,
                reason: reason.trim(),
              },
              { onSuccess: onDone },
            )
          }
        >
          {t('move.confirm')}
        </Button>
      </div>
    </div>
  );
}

export function MoveSession({ session }: { session: SessionDetail }) {
  const [isOpen, dialog] = useDisclosure(false);
  return (
    <>
      <Button variant="subtle" color="gray" size="compact-md" onClick={dialog.open}>
        {t('move.open')}
      </Button>
      <Modal
        opened={isOpen}
        onClose={dialog.close}
        title={t('move.title')}
        closeButtonProps={{ 'aria-label': t('action.close') }}
      >
        {isOpen && <Form session={session} onDone={dialog.close} />}
      </Modal>
    </>
  );
}
