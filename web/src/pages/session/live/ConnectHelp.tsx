import { Button } from '@mantine/core';
import { IconAntenna } from '@tabler/icons-react';
import { useMutation } from '@tanstack/react-query';
import { Link } from 'react-router';
import { ofSession } from '../../../api/address';
import { byHand, socketUrl } from '../../../api/client';
import type { SessionDetail } from '../../../api/types';
import { CopyBox } from '../../../components/CopyBox';
import { Problem } from '../../../components/Feedback';
import { useSignedIn } from '../../../components/account/useSignedIn';
import { t } from '../../../i18n';
import { kindOf } from '../../../kinds';
import { placementList } from '../../../lib/channels';
import './ConnectHelp.css';

/** What to do until packets come: put the sensors on, start the gateway, or try the simulated one. */
export function ConnectHelp({ session }: { session: SessionDetail }) {
  const me = useSignedIn();
  const ticket = useMutation({
    mutationFn: () =>
      byHand.post('/api/sessions/{session_id}/ticket', { ...ofSession(session.id), body: { purpose: 'ingest' } }),
  });
  const account = `--server ${window.location.origin} --email ${me.email} --patient ${session.patient_id}`;
  const simulate = [
    'telemotion simulate',
    kindOf(session).simulated?.(session),
    account,
    session.exercise_id && `--exercise ${session.exercise_id}`,
  ]
    .filter(Boolean)
    .join(' ');
  return (
    <section className="card" aria-labelledby="connect">
      <div className="card-head">
        <IconAntenna size={26} aria-hidden />
        <h2 id="connect">{t('connect.title')}</h2>
      </div>
      <ol className="connect-steps">
        <li>{t('connect.wear', { places: placementList(session.placements) })}</li>
        <li>{t('connect.gateway')}</li>
        <li>{t('connect.then')}</li>
      </ol>
      <details className="as-table">
        <summary>{t('connect.how')}</summary>
        <div className="stack">
          <p>{t('connect.address')}</p>
          <CopyBox label={t('connect.addressLabel')} text={`${socketUrl('/ws/ingest')}\nsession ${session.id}`} />
          <p>
            {t('connect.token')} <Link to={`/patients/${session.patient_id}`}>{t('connect.makeToken')}</Link>
          </p>
          <p>{t('connect.ticket')}</p>
          {ticket.data && <CopyBox label={t('connect.ticketLabel')} text={ticket.data.ticket} />}
          {ticket.error && <Problem error={ticket.error} />}
          <div>
            <Button variant="default" onClick={() => ticket.mutate()} loading={ticket.isPending}>
              {t('connect.makeTicket')}
            </Button>
          </div>
          <p>{t('connect.simulate')}</p>
          <CopyBox label={t('connect.command')} text={simulate} />
        </div>
      </details>
    </section>
  );
}
