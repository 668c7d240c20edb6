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

/** Whether a line belongs under the filter and holds every word searched for. */
export function matches(row: CaseloadRow, filter: CaseloadFilter, search: string): boolean {
  if (filter === 'look' && row.reason === '') return false;
  if (filter === 'live' && row.live_state !== 'streaming') return false;
  return holdsWords(fullName(row), search);
}

/** Letters that no decomposition takes apart, as people without them on the keyboard type them. */
const PLAIN: Record<string, string> = {
  ß: 'ss',
  ł: 'l',
  ø: 'o',
  đ: 'd',
  ð: 'd',
  þ: 'th',
  æ: 'ae',
  œ: 'oe',
  ı: 'i',
  ħ: 'h',
  ŧ: 't',
  ŋ: 'n',
};
/** The same where two letters stand for one: ue for ü. */
const DOUBLE: Record<string, string> = { ä: 'ae', ö: 'oe', ü: 'ue', ø: 'oe', å: 'aa' };
/** From here on a word is also looked for across the parts of a name: `vanderberg`. */
const LONG_WORD = 5;

/** A name as it may be typed: no accents, apostrophes, hyphens or other signs, in small letters. */
function folded(text: string, isDouble = false): string {
  const small = text.normalize('NFC').toLowerCase();
  const known = [...small].map((letter) => (isDouble && DOUBLE[letter]) || PLAIN[letter] || letter).join('');
  return known
    .replace(/[\p{P}\p{Sk}\p{Lm}\p{Cf}]/gu, '')
    .normalize('NFKD')
    .replace(/\p{M}/gu, '');
}

/** Whether a name holds every word searched for; accents, apostrophes, hyphens and case aside. */
export function holdsWords(name: string, search: string): boolean {
  return [false, true].some((isDouble) => {
    const whole = folded(name, isDouble);
    const joined = whole.replace(/\s+/g, '');
    return folded(search, isDouble)
      .trim()
      .split(/\s+/)
      .every((word) => (word.length < LONG_WORD ? whole : joined).includes(word));
  });
}
