// Somebody else saved the same thing meanwhile: who, when and what, and which of two values holds where both changed one.
import { Button } from '@mantine/core';
import { IconUsers } from '@tabler/icons-react';
import { useState } from 'react';
import { t } from '../../i18n';
import { day } from '../../lib/format';
import type { Merge, Side } from '../../lib/editing/merge';
import type { Fields } from '../../lib/editing/merge';
import { RadioCards } from './Choice';

export interface MergeWords {
  /** What a field is called. */
  label: (field: string) => string;
  /** A value of a field in words; `whose` says of which state it is. */
  value: (field: string, value: unknown, whose: Side | 'before') => string;
}

export function MergeCard({
  merge,
  words,
  name,
  at,
  saved,
  notes = [],
  onTake,
}: {
  merge: Merge;
  words: MergeWords;
  /** Who saved meanwhile. */
  name: string;
  /** When. */
  at: string;
  /** What was saved, as a sentence with the time. */
  saved: (when: string) => string;
  notes?: readonly string[];
  onTake: (merged: Fields) => void;
}) {
  const [choices, setChoices] = useState<Record<string, Side | undefined>>({});
  const isOpen = merge.forks.some(({ field }) => !choices[field]);
  return (
    <section className="notice merge" aria-label={t('meanwhile.title')} role="alert">
      <IconUsers size={22} aria-hidden />
      <div className="stack">
        <div>
          <p className="strong">{saved(day(at))}</p>
          {notes.map((one) => (
            <p key={one}>{one}</p>
          ))}
          <p>{t('meanwhile.nothingLost')}</p>
        </div>
        {merge.theirs.length > 0 && (
          <div>
            <h3>{t('meanwhile.theirs', { name })}</h3>
            <ul>
              {merge.theirs.map((one) => (
                <li key={one.field}>
                  {t('meanwhile.line', {
                    field: words.label(one.field),
                    before: words.value(one.field, one.before, 'before'),
                    after: words.value(one.field, one.theirs, 'theirs'),
                  })}
                </li>
              ))}
            </ul>
          </div>
        )}
        {merge.theirs.length + merge.forks.length === 0 && <p>{t('meanwhile.noDifference')}</p>}
        {merge.forks.length > 0 && <h3>{t('meanwhile.both')}</h3>}
        {merge.forks.map((one) => (
          <RadioCards<Side>
            key={one.field}
            legend={words.label(one.field)}
            help={t('meanwhile.before', { value: words.value(one.field, one.before, 'before') })}
            value={choices[one.field] ?? ''}
            onChange={(side) => setChoices((now) => ({ ...now, [one.field]: side }))}
            options={[
              { value: 'mine', title: words.value(one.field, one.mine, 'mine'), text: t('meanwhile.mine') },
              {
                value: 'theirs',
                title: words.value(one.field, one.theirs, 'theirs'),
                text: t('meanwhile.by', { name }),
              },
            ]}
          />
        ))}
        <div>
          <Button disabled={isOpen} onClick={() => onTake(merge.merged(choices))}>
            {t('meanwhile.take')}
          </Button>
          {isOpen && <p className="muted small">{t('meanwhile.choose')}</p>}
        </div>
      </div>
    </section>
  );
}
