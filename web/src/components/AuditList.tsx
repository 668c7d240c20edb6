import type { AuditEntry } from '../api/types';
import { t, tOr } from '../i18n';
import { groupAudit, type AuditDeed } from '../lib/audit';
import { clockTime, date } from '../lib/format';

function deedText({ action, count }: AuditDeed): string {
  const words = tOr(`audit.${action}`, action.replaceAll('.', ' ').replaceAll('_', ' '));
  return count > 1 ? `${words} ${t('audit.times', { count })}` : words;
}

/** Who did what with a patient's data: a line a person and day, with when, and every deed counted. */
export function AuditList({ entries }: { entries: readonly AuditEntry[] }) {
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
              {date(day)}, {clockTime(first) === clockTime(last) ? clockTime(last) : `${clockTime(first)}–${clockTime(last)}`}
            </span>
          </div>
          <ul className="audit-deeds">
            {deeds.map((deed) => (
              <li key={deed.action}>{deedText(deed)}</li>
            ))}
          </ul>
        </li>
      ))}
    </ul>
  );
}
