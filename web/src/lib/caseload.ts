import type { CaseloadRow } from '../api/types';

export type CaseloadFilter = 'all' | 'look' | 'live';

const ORDER: CaseloadRow['reason'][] = ['live', 'declining', 'bad_data', 'not_practising', 'no_template', ''];

/** Who needs a look first; within one reason by family name. */
export function byReason(rows: readonly CaseloadRow[]): CaseloadRow[] {
  return [...rows].sort(
    (a, b) => ORDER.indexOf(a.reason) - ORDER.indexOf(b.reason) || a.family_name.localeCompare(b.family_name),
  );
}

/** Whether a line belongs under the filter and holds every word searched for, accents and case aside. */
export function matches(row: CaseloadRow, filter: CaseloadFilter, search: string): boolean {
  if (filter === 'look' && (row.reason === '' || row.reason === 'live')) return false;
  if (filter === 'live' && !row.live_session_id) return false;
  return holdsWords(`${row.given_name} ${row.family_name}`, search);
}

/** Whether a name holds every word searched for, accents and case aside. */
export function holdsWords(name: string, search: string): boolean {
  const plain = (text: string) => text.normalize('NFD').replace(/\p{M}/gu, '').toLowerCase();
  return plain(search).split(/\s+/).every((word) => plain(name).includes(word));
}
