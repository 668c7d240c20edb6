// What an earlier exercise left on this device: sent as soon as there is a connection, and said until it is.
import { IconCircleCheckFilled } from '@tabler/icons-react';
import { useCallback, useEffect, useRef, useState, useSyncExternalStore } from 'react';
import { ofSession } from '../api/address';
import { api } from '../api/client';
import { useSignedIn } from '../components/account/useSignedIn';
import { Notice } from '../components/Feedback';
import { Confirm } from '../components/forms/Confirm';
import { t } from '../i18n';
import { BrowserGateway } from './gateway/browserGateway';
import type { RecorderState } from './gateway/recorder';
import { heldStoreKey } from './gateway/seal';
import { PacketStore, type StoredNetwork } from './gateway/store';
import { measuringFor } from './registry';
import { refusalWords, secondsText } from './SensorStatus';
import { registerShell } from './shell';
import './sensors.css';
import { inTurn, isTurnElsewhere } from './turn';

const LOOK_MS = 10_000;

interface Left {
  networks: StoredNetwork[];
  /** Sessions that were sealed with a key which the service no longer has. */
  unreadable: string[];
}

const NOTHING: Left = { networks: [], unreadable: [] };

/**
 * The sessions that have packets here and are not measured at this moment; null while another window measures, which
 * would be cut off if this one sent for its session.
 */
async function leftovers(accountId: string): Promise<Left | null> {
  if (typeof indexedDB === 'undefined') return NOTHING;
  if (await isTurnElsewhere()) return null;
  const store = await PacketStore.open(heldStoreKey());
  await store.removeOld();
  const found: Left = { networks: [], unreadable: [] };
  for (const sessionId of await store.sessions(accountId)) {
    if (measuringFor(sessionId)) continue;
    if ((await store.count(sessionId)) === 0) {
      await store.remove(sessionId);
      continue;
    }
    const network = await store.network(sessionId).catch(() => null);
    const isAnyReadable = (await store.read(sessionId, 0, 1)).length > 0;
    if (network && isAnyReadable) found.networks.push(network);
    else found.unreadable.push(sessionId);
  }
  store.close();
  return found;
}

async function forget(sessionId: string): Promise<void> {
  const store = await PacketStore.open('');
  await store.remove(sessionId);
  store.close();
}

function words({ waitingS, link }: RecorderState, isOver: boolean): string {
  const seconds = secondsText(waitingS);
  if (isOver) return t('sensors.unsentOver', { seconds });
  if (link.status === 'refused') return t('sensors.unsentRefused', { seconds });
  return t(link.status === 'open' ? 'sensors.unsentSending' : 'sensors.unsentWaiting', { seconds });
}

function Sending({
  network,
  onSent,
  onLook,
}: {
  network: StoredNetwork;
  onSent: () => void;
  /** Something else is left than before. */
  onLook: () => void;
}) {
  const [gateway, setGateway] = useState<BrowserGateway | null>(null);
  useEffect(() => {
    let made: BrowserGateway | undefined;
    // Two windows that send for one session would take it from each other.
    const end = inTurn(`sending.${network.sessionId}`, () => {
      made = new BrowserGateway(network, { isLate: true });
      setGateway(made);
    });
    return () => {
      made?.close();
      end();
    };
  }, [network]);
  const nothing = useCallback(() => () => undefined, []);
  const recorder = useSyncExternalStore(gateway?.subscribe ?? nothing, () => gateway?.getSnapshot().recorder ?? null);
  const isSent = recorder !== null && recorder.link.connections > 0 && recorder.waiting === 0;
  const isTakenOver = recorder?.link.code === 'superseded';
  useEffect(() => {
    if (!isSent) return;
    // Ends by itself where this cannot be sent.
    if (gateway?.hasReopened)
      void api.post('/api/sessions/{session_id}/close', ofSession(network.sessionId)).catch(() => undefined);
    onSent();
  }, [isSent, onSent, gateway, network]);
  useEffect(() => {
    // A window that measures sends what is left with its own.
    if (isTakenOver) void isTurnElsewhere().then((isElsewhere) => isElsewhere && onLook());
  }, [isTakenOver, onLook]);
  if (!recorder || recorder.waiting === 0) return null;
  const { status, code } = recorder.link;
  const isOver = status === 'ended' || (status === 'refused' && (code === 'conflict' || code === 'not_found'));
  return (
    <section className="card sensor-unsent" data-waiting={recorder.waiting}>
      <h2>{t('sensors.unsent')}</h2>
      <p role="status">{words(recorder, isOver)}</p>
      {status === 'refused' && !isOver && <p role="alert">{refusalWords(recorder.link)}</p>}
      {isOver && <Delete sessionId={network.sessionId} onDeleted={onLook} />}
    </section>
  );
}

function Unreadable({ sessionId, onLook }: { sessionId: string; onLook: () => void }) {
  return (
    <section className="card sensor-unsent">
      <h2>{t('sensors.unsent')}</h2>
      <p role="alert">{t('sensors.unsentUnreadable')}</p>
      <Delete sessionId={sessionId} onDeleted={onLook} />
    </section>
  );
}

function Delete({ sessionId, onDeleted }: { sessionId: string; onDeleted: () => void }) {
  return (
    <Confirm
      label={t('sensors.unsentDelete')}
      title={t('sensors.unsentDeleteTitle')}
      text={t('sensors.unsentDeleteText')}
      isGrave
      confirm={t('sensors.unsentDelete')}
      onConfirm={() => void forget(sessionId).then(onDeleted)}
    />
  );
}

/** For the patient's first page; shows nothing while nothing was left. */
export default function Unsent() {
  const me = useSignedIn();
  const [looks, setLooks] = useState(0);
  const [left, setLeft] = useState<Left>(NOTHING);
  const [isSent, setSent] = useState(false);
  const again = useRef<ReturnType<typeof setTimeout>>(undefined);
  const look = useCallback(() => {
    clearTimeout(again.current);
    leftovers(me.account_id).then(
      (found) => {
        setLeft(found ?? NOTHING);
        if (found === null) again.current = setTimeout(() => setLooks((looks) => looks + 1), LOOK_MS);
      },
      // A browser that stores nothing has nothing left.
      () => setLeft(NOTHING),
    );
  }, [me.account_id]);
  const sent = useCallback(() => {
    setSent(true);
    look();
  }, [look]);
  useEffect(() => {
    look();
    return () => clearTimeout(again.current);
  }, [look, looks]);
  useEffect(registerShell, []);
  return (
    <>
      {left.unreadable.map((one) => (
        <Unreadable key={one} sessionId={one} onLook={look} />
      ))}
      {left.networks.map((one) => (
        <Sending key={one.sessionId} network={one} onSent={sent} onLook={look} />
      ))}
      <div role="status" className={isSent && left.networks.length === 0 ? undefined : 'visually-hidden'}>
        {isSent && left.networks.length === 0 && (
          <Notice icon={<IconCircleCheckFilled size={22} aria-hidden />}>{t('sensors.unsentSent')}</Notice>
        )}
      </div>
    </>
  );
}
