// What a person can do while a session runs: record, stop, mark, end. Stopping is possible at every moment.
import { Button, Group, TextInput } from '@mantine/core';
import { IconFlag, IconPlayerRecordFilled, IconPlayerStopFilled } from '@tabler/icons-react';
import { useMutation, useQueryClient } from '@tanstack/react-query';
import { useState, type FormEvent } from 'react';
import { byHand } from '../../../api/client';
import { key, ofSession } from '../../../api/address';
import type { SessionState } from '../../../api/types';
import { Confirm } from '../../../components/forms/Confirm';
import { Problem } from '../../../components/Feedback';
import { t } from '../../../i18n';
import './LiveButtons.css';

type Deed = 'record' | 'stop' | 'close';

export interface LiveButtonsProps {
  sessionId: string;
  state: SessionState;
  /** A recording runs, whether or not the link is up at this moment. */
  isRecording: boolean;
  /** Recording is started and stopped elsewhere on the page: with a guided test. */
  isGuided?: boolean;
}

export function LiveButtons({ sessionId, state, isRecording, isGuided = false }: LiveButtonsProps) {
  const client = useQueryClient();
  const deed = useMutation({
    mutationFn: (what: Deed) => byHand.post(`/api/sessions/{session_id}/${what}`, ofSession(sessionId)),
    onSuccess: () => client.invalidateQueries({ queryKey: key('sessions', sessionId) }),
  });
  const [note, setNote] = useState('');
  const mark = useMutation({
    mutationFn: (text: string) =>
      byHand.post('/api/sessions/{session_id}/mark', { ...ofSession(sessionId), body: { text } }),
    onSuccess: () => setNote(''),
  });
  const submitMark = (event: FormEvent) => {
    event.preventDefault();
    mark.mutate(note.trim() || t('live.markDefault'));
  };
  const canMark = state === 'ready' || state === 'recording' || state === 'link_lost';
  return (
    <section className="live-buttons card" aria-label={t('live.controls')}>
      <Group gap="sm">
        {isGuided ? null : isRecording ? (
          <Button
            size="lg"
            className="stop-button"
            leftSection={<IconPlayerStopFilled size={20} aria-hidden />}
            loading={deed.isPending && deed.variables === 'stop'}
            onClick={() => deed.mutate('stop')}
          >
            {t('live.stop')}
          </Button>
        ) : (
          <Button
            size="lg"
            leftSection={<IconPlayerRecordFilled size={20} aria-hidden />}
            disabled={state !== 'ready'}
            loading={deed.isPending && deed.variables === 'record'}
            onClick={() => deed.mutate('record')}
          >
            {t('live.record')}
          </Button>
        )}
        <form onSubmit={submitMark} className="mark-form">
          <TextInput
            aria-label={t('live.note')}
            placeholder={t('live.note')}
            maxLength={200}
            value={note}
            onChange={(event) => setNote(event.currentTarget.value)}
            disabled={!canMark}
          />
          <Button
            type="submit"
            variant="default"
            leftSection={<IconFlag size={18} aria-hidden />}
            disabled={!canMark}
            loading={mark.isPending}
          >
            {t('live.mark')}
          </Button>
        </form>
        <span className="push">
          <Confirm
            label={t('live.close')}
            title={t('live.closeTitle')}
            text={t('live.closeText')}
            confirm={t('live.close')}
            isGrave
            onConfirm={() => deed.mutate('close')}
          />
        </span>
      </Group>
      {deed.error && <Problem error={deed.error} />}
      {mark.error && <Problem error={mark.error} />}
    </section>
  );
}
