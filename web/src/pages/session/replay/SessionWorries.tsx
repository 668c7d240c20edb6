// What a therapist must have seen of this session, above everything else on its page.
import { usePatientWorries } from '../../../api/queries';
import type { SessionDetail, Worry } from '../../../api/types';
import { ReasonMark } from '../../../components/Marks';
import { SeenButton, seenText } from '../../../components/Worries';
import { t } from '../../../i18n';

/** The gravest first. */
const ORDER: readonly Worry['kind'][] = ['pain', 'stop', 'link_lost', 'compensation'];

export function useSessionWorries(session: SessionDetail): Worry[] {
  const all = usePatientWorries(session.patient_id).data ?? [];
  return all
    .filter((one) => one.session_id === session.id)
    .sort((one, other) => ORDER.indexOf(one.kind) - ORDER.indexOf(other.kind));
}

export function SessionWorries({ session }: { session: SessionDetail }) {
  const worries = useSessionWorries(session);
  if (worries.length === 0) return null;
  return (
    <section className="card worries" aria-label={t('worry.allSeen')}>
      <ul className="plain-list worry-list">
        {worries.map((one) => (
          <li key={one.kind}>
            <div className="worry">
              <ReasonMark reason={one.kind} />
              <span className="reason-text">{one.text}</span>
              {one.seen_at && <span className="muted small">{seenText(one)}</span>}
            </div>
            {session.may_treat && !one.seen_at && (
              <SeenButton
                patientId={session.patient_id}
                worries={[one]}
                label={t('worry.mark')}
                name={t('worry.markOf', { what: t(`reason.${one.kind}`), name: session.exercise_name ?? '' })}
              />
            )}
          </li>
        ))}
      </ul>
    </section>
  );
}
