import type { AuditEntry } from '../api/types';

export interface AuditDeed {
  action: string;
  count: number;
}

/** What one person did on one day. */
export interface AuditGroup {
  /** Any moment of the day, for its name. */
  day: string;
  who: string;
  role: string;
  first: string;
  last: string;
  deeds: AuditDeed[];
}

const dayOf = (at: string) => new Date(at).toDateString();

/** Newest day and person first; each kind of deed is counted, none is left out. */
export function groupAudit(entries: readonly AuditEntry[]): AuditGroup[] {
  const newest = [...entries].sort((a, b) => Date.parse(b.at) - Date.parse(a.at));
  const groups: AuditGroup[] = [];
  for (const { at, who, role, action } of newest) {
    let group = groups.find((one) => one.who === who && one.role === role && dayOf(one.day) === dayOf(at));
    if (!group) {
      group = { day: at, who, role, first: at, last: at, deeds: [] };
      groups.push(group);
    }
    group.first = at;
    const deed = group.deeds.find((one) => one.action === action);
    if (deed) deed.count += 1;
    else group.deeds.push({ action, count: 1 });
  }
  return groups;
}
