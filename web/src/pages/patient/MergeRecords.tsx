// Two records of one person: everything of the other moves into this one, and the other stays in the archive, empty.
import { Button, Modal, Select, Textarea } from '@mantine/core';
import { useDisclosure } from '@mantine/hooks';
import { useState } from 'react';
import { useMergePatients } from '../../api/changes';
import { usePatients } from '../../api/queries';
import type { Patient } from '../../api/types';
import { Problem } from '../../components/Feedback';
import { t } from '../../i18n';
import { date } from '../../lib/format';
import { fullName } from '../../lib/people';

function Form({ patient, onDone }: { patient: Patient; onDone: () => void }) {
  const patients = usePatients();
  const merge = useMergePatients(patient.id);
  const [otherId, setOtherId] = useState<string | null>(null);
  const [reason, setReason] = useState('');
  const others = (patients.data ?? []).filter((one) => one.id !== patient.id && one.may_manage && !one.merged_into_id);
  return (
    <div className="stack">
      <p>{t('merge.text', { name: fullName(patient) })}</p>
      <p className="muted small">{t('merge.consents')}</p>
      {patients.error && <Problem error={patients.error} />}
      {merge.error && <Problem error={merge.error} />}
      <Select
        label={t('merge.other')}
        searchable
        data={others.map((one) => ({
          value: one.id,
          label: one.birth_date ? `${fullName(one)}, ${date(one.birth_date, new Date(0))}` : fullName(one),
        }))}
        value={otherId}
        onChange={setOtherId}
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
          disabled={otherId === null || reason.trim() === ''}
          loading={merge.isPending}
          onClick={() => merge.mutate({ other_id: otherId ?? '', reason: reason.trim() }, { onSuccess: onDone })}
        >
          {t('merge.confirm')}
        </Button>
      </div>
    </div>
  );
}

export function MergeRecords({ patient }: { patient: Patient }) {
  const [isOpen, dialog] = useDisclosure(false);
  return (
    <>
      <Button variant="subtle" color="gray" size="compact-md" onClick={dialog.open}>
        {t('merge.open')}
      </Button>
      <Modal
        opened={isOpen}
        onClose={dialog.close}
        title={t('merge.title')}
        closeButtonProps={{ 'aria-label': t('action.close') }}
      >
        {isOpen && <Form patient={patient} onDone={dialog.close} />}
      </Modal>
    </>
  );
}
