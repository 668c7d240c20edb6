import { useNavigate } from 'react-router';
import { useAddPatient } from '../api/queries';
import { Page } from '../components/Page';
import { PatientForm } from '../components/forms/PatientForm';
import { t } from '../i18n';

export function PatientNewPage() {
  const navigate = useNavigate();
  const add = useAddPatient();
  return (
    <Page title={t('patient.add')} narrow crumbs={[{ to: '/', text: t('nav.caseload') }]}>
      <div className="card">
        <PatientForm
          isSaving={add.isPending}
          error={add.error}
          onCancel={() => void navigate('/')}
          onSave={(input, saved) =>
            add.mutate(input, {
              onSuccess: (patient) => {
                saved();
                void navigate(`/patients/${patient.id}`);
              },
            })
          }
        />
      </div>
    </Page>
  );
}
