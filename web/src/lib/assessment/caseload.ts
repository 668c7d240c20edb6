import type { CaseloadRow } from '../../api/types';
import { fullName } from '../people';

export type CaseloadFilter = 'all' | 'look' | 'live';

/** Where the one next action of a line leads. */
export function actionPath(row: Pick<CaseloadRow, 'action' | 'action_session_id' | 'patient_id'>): string {
  const patient = `/patients/${row.patient_id}`;
  switch (row.action) {
    case 'watch':
    case 'open_live':
      return `/sessions/${row.action_session_id}/live`;
    case 'replay':
      return `/sessions/${row.action_session_id}`;
    case 'record_template':
      return `/templates/record?patient=${row.patient_id}`;
    default:
      return patient;
  }
}

/** Whether a line belongs under the filter and holds every word searched for, accents and case aside. */
export function matches(row: CaseloadRow, filter: CaseloadFilter, search: string): boolean {
  if (filter === 'look' && row.reason === '') return false;
  if (filter === 'live' && row.live_state !== 'streaming') return false;
  return holdsWords(fullName(row), search);
}

/** Whether a name holds every word searched for, accents and case aside. */
export function holdsWords(name: string, search: string): boolean {
  const plain = (text: string) => text.normalize('NFD').replace(/\p{M}/gu, '').toLowerCase();
  return plain(search)
    .split(/\s+/)
    .every((word) => plain(name).includes(word));
}
