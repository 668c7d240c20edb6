// What happened in a session that a therapist must have seen: why, when, in her own words, and the mark itself.
import { Button } from '@mantine/core';
import { IconCheck } from '@tabler/icons-react';
import type { ReactNode } from 'react';
import { Link } from 'react-router';
import { useMarkSeen } from '../api/changes';
import type { Worry } from '../api/types';
import { t } from '../i18n';
import { dateTime } from '../lib/format';
import { ReasonMark } from './Marks';
import { Problem } from './Feedback';
import './Worries.css';

/** One worry; `children` stand below its words. */
export function WorryText({ worry, children }: { worry: Worry; children?: ReactNode }) {
  return (
    <div className="worry">
      <p className="worry-head">
        <ReasonMark reason={worry.kind} />
        <Link to={`/sessions/${worry.session_id}`} className="above small">
          {dateTime(worry.at)}
        </Link>
      </p>
      <span className="reason-text">{worry.text}</span>
      {worry.words && <q className="worry-words">{worry.words}</q>}
      {children}
    </div>
  );
}

/** Marks worries as seen: those that are shown, and nothing that comes meanwhile. */
export function SeenButton({
  patientId,
  worries,
  label,
  name,
}: {
  patientId: string;
  worries: readonly Worry[];
  label: string;
  /** Said aloud, where the label alone does not say of whom. */
  name?: string;
}) {
  const mark = useMarkSeen(patientId);
  return (
    <>
      <Button
        className="above"
        variant="default"
        size="sm"
        leftSection={<IconCheck size={17} aria-hidden />}
        aria-label={name}
        loading={mark.isPending}
        onClick={() => mark.mutate(worries)}
      >
        {label}
      </Button>
      {mark.error && <Problem error={mark.error} />}
    </>
  );
}

/** Who has seen it, and when. */
export function seenText(worry: Worry): string {
  if (!worry.seen_at) return '';
  return worry.seen_by
    ? t('worry.seenBy', { name: worry.seen_by, when: dateTime(worry.seen_at) })
    : t('worry.seenLongAgo');
}
