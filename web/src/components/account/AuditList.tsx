import type { AuditEntry } from '../../api/types';
import { t, tOr } from '../../i18n';
import { groupAudit, type AuditDeed } from '../../lib/audit';
import { clockTime, date } from '../../lib/format';
import { useSignedIn } from './useSignedIn';
import './AuditList.css';

/** The deeds in words; what has the same words is one deed, for instance reading a comparison and the list of them. */
function deedTexts(deeds: readonly AuditDeed[], isOwn: boolean): string[] {
  const counts = new Map<string, number>();
  for (const { action: exact, count } of deeds) {
    // Which way of calibrating it was is for the record, not for the reader.
    const action = exact.replace(/calibration_\w+$/, 'calibrate');
    const staff = tOr(`audit.${action}`, action.replaceAll('.', ' ').replaceAll('_', ' '));
    const words = isOwn ? tOr(`mine.audit.${action}`, staff) : staff;
    counts.set(words, (counts.get(words) ?? 0) + count);
  }
  return [...counts].map(([words, count]) => (count > 1 ? `${words} ${t('audit.times', { count })}` : words));
}

/** Who did what with a patient's data: a line a person and day, with when, and every deed counted. */
export function AuditList({ entries }: { entries: readonly AuditEntry[] }) {
  const isOwn = useSignedIn().role === 'patient';
  if (entries.length === 0) return <p className="muted">{t('audit.none')}</p>;
  return (
    <ul className="plain-list lines">
      {groupAudit(entries).map(({ day, who, role, first, last, deeds }) => (
        <li key={`${day}${who}`}>
          <div className="audit-head">
            <span>
              <span className="strong">{who}</span> <span className="muted">({tOr(`role.${role}`, role)})</span>
            </span>
            <span className="muted number">
              {date(day)},{' '}
              {clockTime(first) === clockTime(last) ? clockTime(last) : `${clockTime(first)}–${clockTime(last)}`}
            </span>
          </div>
          <ul className="audit-deeds">
            {deedTexts(deeds, isOwn).map((deed) => (
              <li key={deed}>{deed}</li>
            ))}
          </ul>
        </li>
      ))}
    </ul>
  );
}
