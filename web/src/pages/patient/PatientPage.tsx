// One patient: who (left), how it goes (middle), what is to be done and was done (right).
import { Button, Modal } from '@mantine/core';
import { useDisclosure } from '@mantine/hooks';
import { IconPencil, IconPlayerRecord, IconUpload } from '@tabler/icons-react';
import { Link, useParams } from 'react-router';
import { usePatient } from '../../api/queries';
import type { Patient } from '../../api/types';
import { Consents } from '../../components/account/Consents';
import { QueryBoundary } from '../../components/Feedback';
import { SideMark } from '../../components/Marks';
import { Page } from '../../components/Page';
import { PatientForm } from '../../components/forms/PatientForm';
import { t } from '../../i18n';
import { placementLabel } from '../../lib/channels';
import { age, bodyLength, date, day } from '../../lib/format';
import { fullName } from '../../lib/people';
import { scoreText } from '../session/live/Calibration';
import { AccessPanel } from './AccessPanel';
import { DataPanel } from './DataPanel';
import { DevicePanel } from './DevicePanel';
import { PrescriptionPanel } from './PrescriptionPanel';
import { ProgressPanel } from './ProgressPanel';
import { SessionPanel } from './SessionPanel';
import { WorryPanel } from './WorryPanel';
import './PatientPage.css';

function Facts({ patient, onEdit }: { patient: Patient; onEdit: () => void }) {
  const body = patient.body_dimensions ?? {};
  const lengths = (['stature_m', 'upper_arm_m', 'forearm_m', 'hand_m', 'shoulder_width_m', 'trunk_m'] as const).filter(
    (name) => body[name] !== null && body[name] !== undefined,
  );
  return (
    <section className="card" aria-labelledby="facts">
      <div className="card-head">
        <h2 id="facts">{t('patient.about')}</h2>
        {patient.may_treat && (
          <Button
            className="end"
            variant="subtle"
            size="sm"
            leftSection={<IconPencil size={17} aria-hidden />}
            onClick={onEdit}
          >
            {t('action.edit')}
          </Button>
        )}
      </div>
      <dl className="facts">
        {patient.birth_date && (
          <>
            <dt>{t('patient.born')}</dt>
            <dd>
              {t('patient.bornAge', { date: date(patient.birth_date, new Date(0)), age: age(patient.birth_date) })}
            </dd>
          </>
        )}
        <dt>{t('patient.sensors')}</dt>
        <dd>
          {patient.mounting ? (
            <>
              {t('patient.mountingKnown')}
              <span className="muted small reason-line">
                {scoreText(patient.mounting.score)}, {day(patient.mounting.updated_at)}
              </span>
              <span className="muted small reason-line">
                {patient.mounting.placements.map(placementLabel).join(', ')}
              </span>
            </>
          ) : (
            t('patient.mountingUnknown')
          )}
        </dd>
        {lengths.map((name) => (
          <div key={name} className="facts-pair">
            <dt>{t(`length.${name}`)}</dt>
            <dd className="number">{bodyLength(body[name])}</dd>
          </div>
        ))}
      </dl>
      {lengths.length === 0 && <p className="muted small">{t('patient.noDimensions')}</p>}
      {patient.notes && <p className="notes">{patient.notes}</p>}
    </section>
  );
}

function Loaded({ patient }: { patient: Patient }) {
  const [isEditing, editing] = useDisclosure(false);
  return (
    <>
      <WorryPanel patient={patient} />
      <div className="patient-grid">
        <div className="stack">
          <Facts patient={patient} onEdit={editing.open} />
          <Consents patientId={patient.id} mayChange={patient.may_manage && patient.archived_at === null} />
          <DevicePanel patient={patient} />
          <AccessPanel patient={patient} />
          <DataPanel patient={patient} />
        </div>
        <ProgressPanel patientId={patient.id} mayTreat={patient.may_treat} />
        <div className="stack">
          <PrescriptionPanel patient={patient} />
          <SessionPanel patient={patient} />
        </div>
      </div>
      <Modal
        opened={isEditing}
        onClose={editing.close}
        title={t('patient.editTitle')}
        closeButtonProps={{ 'aria-label': t('action.close') }}
      >
        <PatientForm patient={patient} onCancel={editing.close} onSaved={editing.close} />
      </Modal>
    </>
  );
}

export function PatientPage() {
  const { patientId = '' } = useParams();
  const patient = usePatient(patientId);
  const title = patient.data ? fullName(patient.data) : t('patient.title');
  return (
    <Page
      title={title}
      lead={patient.data ? <SideMark side={patient.data.affected_side ?? null} /> : undefined}
      crumbs={[{ to: '/', text: t('nav.caseload') }]}
      actions={
        patient.data?.may_treat && (
          <>
            <Button
              component={Link}
              to={`/upload?patient=${patientId}`}
              variant="default"
              leftSection={<IconUpload size={18} aria-hidden />}
            >
              {t('upload.title')}
            </Button>
            <Button
              component={Link}
              to={`/patients/${patientId}/sessions/new`}
              leftSection={<IconPlayerRecord size={18} aria-hidden />}
            >
              {t('session.start')}
            </Button>
          </>
        )
      }
    >
      <QueryBoundary of={patient} lines={8} height={40}>
        {(data) => <Loaded key={data.id} patient={data} />}
      </QueryBoundary>
    </Page>
  );
}
