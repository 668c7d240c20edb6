import { useId, type ReactNode } from 'react';
import type { ComparisonDetail, Patient, Progress, SessionDetail } from '../../api/types';
import { useSignedIn } from '../../components/account/useSignedIn';
import { t } from '../../i18n';
import { date } from '../../lib/format';
import './report.css';

/** What every sheet of a report is made from. */
export interface ReportProps {
  session: SessionDetail;
  patient: Patient;
  comparison: ComparisonDetail | null;
  progress: Progress | null;
}

/** One sheet of paper with its head and foot; printed, it starts a page. */
export function Sheet({
  title,
  number,
  session,
  patient,
  version,
  children,
}: {
  title: string;
  number: number;
  children: ReactNode;
  /** Absent of a course, which is many sessions. */
  session?: ReportProps['session'];
  /** Of the software that made the report. */
  version?: string | undefined;
} & Pick<ReportProps, 'patient'>) {
  const id = useId();
  const me = useSignedIn();
  return (
    <section className="paper" aria-labelledby={id}>
      <header className="paper-head">
        <h2 id={id}>{title}</h2>
        <p>
          {patient.given_name} {patient.family_name}
          {patient.birth_date && <> · {t('report.born', { date: date(patient.birth_date, new Date(0)) })}</>}
        </p>
      </header>
      {children}
      <footer className="paper-foot">
        <span>{me.clinic_name}</span>
        <span>{t('report.made', { date: date(new Date(), new Date(0)), name: me.display_name })}</span>
        <span>
          {session && <>{t('report.session', { id: session.id.slice(0, 8) })} · </>}
          {version && <>{t('report.software', { version })} · </>}
          {/* On paper a sheet may follow that the screen has not. */}
          <span className="paper-number" data-words={t('report.page', { number: '#' })}>
            {t('report.page', { number })}
          </span>
        </span>
      </footer>
    </section>
  );
}
