import type { CaseloadRow } from '../../api/types';

export type CaseloadFilter = 'all' | 'look' | 'live';

/** Whether a line belongs under the filter and holds every word searched for, accents and case aside. */
export function matches(row: CaseloadRow, filter: CaseloadFilter, search: string): boolean {
  if (filter === 'look' && row.reason === '') return false;
  if (filter === 'live' && row.live_state !== 'streaming') return false;
  return holdsWords(`${row.given_name} ${row.family_name}`, search);
}

/** Whether a name holds every word searched for, accents and case aside. */
export function holdsWords(name: string, search: string): boolean {
  const plain = (text: string) => text.normalize('NFD').replace(/\p{M}/gu, '').toLowerCase();
  return plain(search)
    .split(/\s+/)
    .every((word) => plain(name).includes(word));
}
