import type { AuditEntry } from '../api/types';
import { t, tOr } from '../i18n';
import { dateTime } from '../lib/format';
import { groupAudit } from '../lib/audit';

/** Who did what with a patient's data, newest first; the same deed in a row is one line with its count. */
export function AuditList({ entries }: { entries: readonly AuditEntry[] }) {
  if (entries.length === 0) return <p className="muted">{t('audit.none')}</p>;
  return (
    <ul className="plain-list lines audit">
      {groupAudit(entries).map((group) => (
        <li key={`${group.at}${group.action}${group.who}`}>
          <span>
            <span className="strong">{group.who}</span> <span className="muted">({tOr(`role.${group.role}`, group.role)})</span>{' '}
            {tOr(`audit.${group.action}`, group.action.replaceAll('.', ' ').replaceAll('_', ' '))}
            {group.count > 1 && <span className="muted"> {t('audit.times', { count: group.count })}</span>}
          </span>
          <span className="muted small nowrap">{dateTime(group.at)}</span>
        </li>
      ))}
    </ul>
  );
}
