import { useAudit, useGrants } from '../../api/queries';
import { AuditList } from '../../components/account/AuditList';
import { Consents } from '../../components/account/Consents';
import { QueryBoundary, ShowMore } from '../../components/Feedback';
import { Page } from '../../components/Page';
import { useSignedIn } from '../../components/account/useSignedIn';
import { t } from '../../i18n';
import { ExportButton } from '../../components/account/ExportButton';
import { NoRecord } from './Today';

function MyData({ patientId }: { patientId: string }) {
  const audit = useAudit(patientId);
  const grants = useGrants(patientId);
  return (
    <Page narrow title={t('nav.myData')} lead={t('mine.dataLead')}>
      <div className="stack">
        <section className="card" aria-labelledby="who-may">
          <h2 id="who-may">{t('mine.whoMay')}</h2>
          <QueryBoundary of={grants} lines={2}>
            {(list) =>
              list.length === 0 ? (
                <p className="muted">{t('mine.nobody')}</p>
              ) : (
                <ul className="plain-list lines">
                  {list.map((one) => (
                    <li key={one.id}>
                      <span className="strong">{one.display_name}</span>{' '}
                      <span className="muted">{one.level === 'treat' ? t('mine.treats') : t('mine.reads')}</span>
                    </li>
                  ))}
                </ul>
              )
            }
          </QueryBoundary>
        </section>
        <Consents patientId={patientId} />
        <section className="card stack" aria-labelledby="take-along">
          <h2 id="take-along">{t('mine.takeAlong')}</h2>
          <p>{t('mine.takeAlongText')}</p>
          <div>
            <ExportButton patientId={patientId} size="lg" />
          </div>
        </section>
        <section className="card" aria-labelledby="looked">
          <h2 id="looked">{t('mine.looked')}</h2>
          <QueryBoundary of={audit} lines={5}>
            {(entries) => <AuditList entries={entries} />}
          </QueryBoundary>
          <ShowMore of={audit} />
        </section>
      </div>
    </Page>
  );
}

export function MyDataPage() {
  const me = useSignedIn();
  return me.patient_id ? <MyData patientId={me.patient_id} /> : <NoRecord />;
}
