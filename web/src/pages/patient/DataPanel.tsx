// Everything held about a patient: taken along as one file, put away, or erased for good. Each leaves a line in the trail.
import { Button, Modal, TextInput } from '@mantine/core';
import { useDisclosure } from '@mantine/hooks';
import { IconArchive, IconArchiveOff, IconTrash } from '@tabler/icons-react';
import { useState } from 'react';
import { Link, useNavigate } from 'react-router';
import { useEditPatient, useErasePatient } from '../../api/changes';
import type { Patient } from '../../api/types';
import { MergeRecords } from './MergeRecords';
import { ExportButton } from '../../components/account/ExportButton';
import { Confirm } from '../../components/forms/Confirm';
import { Notice, Problem } from '../../components/Feedback';
import { useSignedIn } from '../../components/account/useSignedIn';
import { t } from '../../i18n';
import { date } from '../../lib/format';
import { fullName } from '../../lib/people';
import './DataPanel.css';

function Erase({ patient, onDone }: { patient: Patient; onDone: () => void }) {
  const navigate = useNavigate();
  const erase = useErasePatient();
  const [typed, setTyped] = useState('');
  // Some people have one name only.
  const name = patient.family_name || patient.given_name;
  return (
    <div className="stack">
      {erase.error && <Problem error={erase.error} />}
      <p>{t('data.eraseText')}</p>
      <TextInput
        label={t('data.eraseType', { name })}
        value={typed}
        onChange={(event) => setTyped(event.currentTarget.value)}
        autoComplete="off"
        data-autofocus
      />
      <div className="details-foot">
        <Button variant="default" onClick={onDone}>
          {t('action.cancel')}
        </Button>
        <Button
          color="red.8"
          disabled={typed.trim() !== name}
          loading={erase.isPending}
          leftSection={<IconTrash size={18} aria-hidden />}
          onClick={() => erase.mutate(patient.id, { onSuccess: () => void navigate('/', { replace: true }) })}
        >
          {t('data.erase')}
        </Button>
      </div>
    </div>
  );
}

export function DataPanel({ patient }: { patient: Patient }) {
  const me = useSignedIn();
  const edit = useEditPatient(patient.id);
  const [isErasing, erasing] = useDisclosure(false);
  const isArchived = patient.archived_at !== null;
  return (
    <section className="card stack" aria-labelledby="data">
      <h2 id="data">{t('data.title')}</h2>
      {isArchived && (
        <Notice icon={<IconArchive size={22} aria-hidden />}>
          <p>
            {t('data.archivedOn', { date: date(patient.archived_at ?? '') })}
            {patient.merged_into_id && (
              <>
                {' '}
                <Link to={`/patients/${patient.merged_into_id}`}>{t('merge.merged')}</Link>
              </>
            )}
          </p>
        </Notice>
      )}
      <div className="data-buttons">
        <ExportButton patientId={patient.id} size="sm" />
        {patient.may_treat && <MergeRecords patient={patient} />}
        {patient.may_manage &&
          (isArchived ? (
            <Button
              size="sm"
              variant="default"
              leftSection={<IconArchiveOff size={18} aria-hidden />}
              loading={edit.isPending}
              onClick={() => edit.mutate({ is_archived: false })}
            >
              {t('data.unarchive')}
            </Button>
          ) : (
            <Confirm
              label={t('data.archive')}
              title={t('data.archiveTitle')}
              text={t('data.archiveText')}
              confirm={t('data.archive')}
              onConfirm={() => edit.mutate({ is_archived: true })}
            />
          ))}
        {me.role === 'administrator' && isArchived && (
          <Button
            size="sm"
            variant="subtle"
            color="red.8"
            leftSection={<IconTrash size={18} aria-hidden />}
            onClick={erasing.open}
          >
            {t('data.erase')}
          </Button>
        )}
      </div>
      {me.role === 'administrator' && !isArchived && <p className="muted small">{t('data.eraseFirst')}</p>}
      {edit.error && <Problem error={edit.error} />}
      <Modal
        opened={isErasing}
        onClose={erasing.close}
        title={t('data.eraseTitle', { name: fullName(patient) })}
        closeButtonProps={{ 'aria-label': t('action.close') }}
      >
        {isErasing && <Erase patient={patient} onDone={erasing.close} />}
      </Modal>
    </section>
  );
}
