import { Switch } from '@mantine/core';
import { useAudit, useConsent, useConsents, useGrants } from '../../api/queries';
import type { ConsentIn } from '../../api/types';
import { AuditList } from '../../components/AuditList';
import { Answer, Problem } from '../../components/Feedback';
import { Page } from '../../components/Page';
import { useSignedIn } from '../../components/useSignedIn';
import { t } from '../../i18n';
import { date } from '../../lib/format';
import { ExportButton } from '../patient/DataPanel';
import { NoRecord } from './Today';

const PURPOSES: readonly ConsentIn['purpose'][] = ['treatment', 'home_streaming', 'research'];

function Consents({ patientId }: { patientId: string }) {
  const consents = useConsents(patientId);
  const change = useConsent(patientId);
  return (
    <section className="card stack" aria-labelledby="consents">
      <h2 id="consents">{t('mine.consents')}</h2>
      {change.error && <Problem error={change.error} />}
      <Answer of={consents} lines={3}>
        {(list) => (
          <>
            {PURPOSES.map((purpose) => {
              const given = list.find((one) => one.purpose === purpose);
              return (
                <Switch
                  key={purpose}
                  size="lg"
                  label={t(`consent.${purpose}`)}
                  description={t(`consent.${purpose}.text`) + (given ? ` ${t('consent.since', { date: date(given.changed_at) })}` : '')}
                  checked={given?.granted ?? false}
                  disabled={change.isPending}
                  onChange={(event) => change.mutate({ purpose, granted: event.currentTarget.checked })}
                />
              );
            })}
          </>
        )}
      </Answer>
    </section>
  );
}

function MyData({ patientId }: { patientId: string }) {
  const audit = useAudit(patientId);
  const grants = useGrants(patientId);
  return (
    <Page narrow title={t('nav.myData')} lead={t('mine.dataLead')}>
      <div className="stack">
        <section className="card" aria-labelledby="who-may">
          <h2 id="who-may">{t('mine.whoMay')}</h2>
          <Answer of={grants} lines={2}>
            {(list) =>
              list.length === 0 ? (
                <p className="muted">{t('mine.nobody')}</p>
              ) : (
                <ul className="plain-list lines">
                  {list.map((one) => (
                    <li key={one.id}>
                      <span className="strong">{one.display_name}</span> <span className="muted">{one.level === 'treat' ? t('mine.treats') : t('mine.reads')}</span>
                    </li>
                  ))}
                </ul>
              )
            }
          </Answer>
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
          <Answer of={audit} lines={5}>
            {(entries) => <AuditList entries={entries} />}
          </Answer>
        </section>
      </div>
    </Page>
  );
}

export function MyDataPage() {
  const me = useSignedIn();
  return me.patient_id ? <MyData patientId={me.patient_id} /> : <NoRecord />;
}
