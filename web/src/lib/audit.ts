import type { AuditEntry } from '../api/types';

export interface AuditGroup {
  at: string;
  who: string;
  role: string;
  action: string;
  count: number;
}

/** Newest first; what one person did again within an hour is counted in one line, nothing is left out. */
export function groupAudit(entries: readonly AuditEntry[]): AuditGroup[] {
  const newest = [...entries].sort((a, b) => Date.parse(b.at) - Date.parse(a.at));
  const groups: AuditGroup[] = [];
  for (const { at, who, role, action } of newest) {
    const same = groups.find(
      (group) => group.who === who && group.role === role && group.action === action && Date.parse(group.at) - Date.parse(at) < 3_600_000,
    );
    if (same) same.count += 1;
    else groups.push({ at, who, role, action, count: 1 });
  }
  return groups;
}
