import { Group, Radio } from '@mantine/core';
import { useConsent } from '../../api/changes';
import { useConsents } from '../../api/queries';
import type { ConsentIn } from '../../api/types';
import { t } from '../../i18n';
import { date } from '../../lib/format';
import { QueryBoundary, Problem } from '../Feedback';
import { useSignedIn } from './useSignedIn';

const PURPOSES: readonly ConsentIn['purpose'][] = ['treatment', 'home_streaming', 'research'];

/** What the patient agrees to: asked and answered one by one, by the patient or by who writes the answer down. */
export function Consents({ patientId, mayChange = true }: { patientId: string; mayChange?: boolean }) {
  const isOwn = useSignedIn().role === 'patient';
  const consents = useConsents(patientId);
  const change = useConsent(patientId);
  const words = (purpose: ConsentIn['purpose']) =>
    isOwn
      ? { label: t(`consent.${purpose}`), text: t(`consent.${purpose}.text`) }
      : { label: t(`consent.staff.${purpose}`), text: t(`consent.staff.${purpose}.text`) };
  return (
    <section className="card stack" aria-labelledby="consents">
      <h2 id="consents">{t(isOwn ? 'mine.consents' : 'consent.title')}</h2>
      {!isOwn && <p className="muted small">{t('consent.lead')}</p>}
      {change.error && <Problem error={change.error} />}
      <QueryBoundary of={consents} lines={3}>
        {(list) => (
          <>
            {PURPOSES.map((purpose) => {
              const given = list.find((one) => one.purpose === purpose);
              const { label, text } = words(purpose);
              return (
                <Radio.Group
                  key={purpose}
                  label={label}
                  description={`${text} ${given ? t('consent.since', { date: date(given.changed_at) }) : t('consent.notAsked')}`}
                  value={given ? String(given.granted) : ''}
                  onChange={(value) => change.mutate({ purpose, granted: value === 'true' })}
                >
                  <Group gap="xl" mt={8}>
                    <Radio size="md" value="true" label={t('consent.yes')} disabled={change.isPending || !mayChange} />
                    <Radio size="md" value="false" label={t('consent.no')} disabled={change.isPending || !mayChange} />
                  </Group>
                </Radio.Group>
              );
            })}
          </>
        )}
      </QueryBoundary>
    </section>
  );
}
