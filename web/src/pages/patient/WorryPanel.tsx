// What of a patient's sessions nobody has marked as seen, and below what was: by whom and when.
import { usePatientWorries } from '../../api/queries';
import type { Patient } from '../../api/types';
import { SeenButton, seenText, WorryText } from '../../components/Worries';
import { t } from '../../i18n';

export function WorryPanel({ patient }: { patient: Patient }) {
  const worries = usePatientWorries(patient.id).data ?? [];
  const waiting = worries.filter((one) => !one.seen_at);
  const seen = worries.filter((one) => one.seen_at);
  if (worries.length === 0) return null;
  return (
    <section className="card worries" aria-labelledby="worries">
      <div className="card-head">
        <h2 id="worries">{waiting.length > 0 ? t('worry.title') : t('worry.allSeen')}</h2>
        {patient.may_treat && waiting.length > 1 && (
          <div className="end">
            <SeenButton
              patientId={patient.id}
              worries={waiting}
              label={t('worry.markAll', { count: waiting.length })}
            />
          </div>
        )}
      </div>
      {waiting.length > 0 && (
        <ul className="plain-list worry-list">
          {waiting.map((one) => (
            <li key={one.session_id + one.kind}>
              <WorryText worry={one}>
                {one.exercise_name && <span className="muted small">{one.exercise_name}</span>}
              </WorryText>
              {patient.may_treat && (
                <SeenButton
                  patientId={patient.id}
                  worries={[one]}
                  label={t('worry.mark')}
                  name={t('worry.markOf', { what: t(`reason.${one.kind}`), name: one.exercise_name ?? '' })}
                />
              )}
            </li>
          ))}
        </ul>
      )}
      {seen.length > 0 && (
        <details>
          <summary>{t('worry.earlier', { count: seen.length })}</summary>
          <ul className="plain-list worry-list">
            {seen.map((one) => (
              <li key={one.session_id + one.kind}>
                <WorryText worry={one}>
                  <span className="muted small">{seenText(one)}</span>
                </WorryText>
              </li>
            ))}
          </ul>
        </details>
      )}
    </section>
  );
}
