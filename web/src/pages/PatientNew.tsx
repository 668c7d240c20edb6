import { useNavigate } from 'react-router';
import { Page } from '../components/Page';
import { PatientForm } from '../components/forms/PatientForm';
import { t } from '../i18n';

export function PatientNewPage() {
  const navigate = useNavigate();
  return (
    <Page title={t('patient.add')} narrow crumbs={[{ to: '/', text: t('nav.caseload') }]}>
      <div className="card">
        <PatientForm
          onCancel={() => void navigate('/')}
          onSaved={(patient) => void navigate(`/patients/${patient.id}`)}
        />
      </div>
    </Page>
  );
}
