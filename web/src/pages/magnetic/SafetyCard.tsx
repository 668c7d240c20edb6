// Nobody with a pacemaker near a magnetic source: asked before each session, by the therapist.
import { Button, Checkbox } from '@mantine/core';
import { IconHeartOff, IconShieldCheck } from '@tabler/icons-react';
import { useState } from 'react';
import { useConfirmNoImplants, useMagneticSafety } from '../../api/queries';
import type { SessionDetail } from '../../api/types';
import { Answer, Notice, Problem } from '../../components/Feedback';
import { t } from '../../i18n';
import { bodyLength, dateTime, number } from '../../lib/format';

export function SafetyCard({ session }: { session: SessionDetail }) {
  const safety = useMagneticSafety(session.id, true);
  const confirm = useConfirmNoImplants(session.id);
  const [patient, setPatient] = useState(false);
  const [nearby, setNearby] = useState(false);
  return (
    <Answer of={safety} lines={3}>
      {(told) =>
        told.confirmed ? (
          <Notice icon={<IconShieldCheck size={22} aria-hidden />}>
            {told.confirmed_by
              ? t('magnetic.confirmed', { name: told.confirmed_by, at: dateTime(told.confirmed_at ?? '') })
              : t('magnetic.confirmedNoName', { at: dateTime(told.confirmed_at ?? '') })}
          </Notice>
        ) : (
          <section className="card" aria-labelledby="safety">
            <div className="banner banner-alert">
              <IconHeartOff size={28} style={{ flexShrink: 0 }} aria-hidden />
              <div>
                <h2 id="safety">{t('magnetic.safety')}</h2>
                <p className="strong">{t('magnetic.warning')}</p>
                {told.keep_away_m !== null && <p>{t('magnetic.keepAway', { distance: bodyLength(told.keep_away_m), limit: number(1000 * told.limit_t, 1) })}</p>}
              </div>
            </div>
            {session.may_treat ? (
              <div className="stack">
                <Checkbox label={t('magnetic.patient')} checked={patient} onChange={(event) => setPatient(event.currentTarget.checked)} />
                <Checkbox label={t('magnetic.nearby')} checked={nearby} onChange={(event) => setNearby(event.currentTarget.checked)} />
                {confirm.error && <Problem error={confirm.error} />}
                <div>
                  <Button disabled={!patient || !nearby} loading={confirm.isPending} onClick={() => confirm.mutate(undefined)}>
                    {t('magnetic.confirm')}
                  </Button>
                </div>
                <p className="muted small">{t('magnetic.locked')}</p>
              </div>
            ) : (
              <p>{t('magnetic.onlyTherapist')}</p>
            )}
          </section>
        )
      }
    </Answer>
  );
}
