// Nobody with a pacemaker near a magnetic source: asked before each session, by the therapist.
import { Button } from '@mantine/core';
import { IconShieldCheck } from '@tabler/icons-react';
import { useState } from 'react';
import { useConfirmNoImplants, useMagneticSafety } from '../../api/queries';
import type { SessionDetail } from '../../api/types';
import { Answer, Notice, Problem } from '../../components/Feedback';
import { t } from '../../i18n';
import { dateTime } from '../../lib/format';
import { isSafe, UNASKED } from '../../lib/magneticSetup';
import { ImplantQuestions } from './ImplantQuestions';

export function SafetyCard({ session }: { session: SessionDetail }) {
  const safety = useMagneticSafety(session.id, true);
  const confirm = useConfirmNoImplants(session.id);
  const [said, setSaid] = useState(UNASKED);
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
          <section className="card stack" aria-labelledby="safety">
            <h2 id="safety">{t('magnetic.safety')}</h2>
            {session.may_treat ? (
              <>
                <ImplantQuestions value={said} onChange={setSaid} keepAwayM={told.keep_away_m} limitT={told.limit_t} />
                {confirm.error && <Problem error={confirm.error} />}
                <div>
                  <Button disabled={!isSafe(said)} loading={confirm.isPending} onClick={() => confirm.mutate(undefined)}>
                    {t('magnetic.confirm')}
                  </Button>
                </div>
                <p className="muted small">{t('magnetic.locked')}</p>
              </>
            ) : (
              <>
                <p className="strong">{t('magnetic.warning')}</p>
                <p>{t('magnetic.which')}</p>
                <p>{t('magnetic.onlyTherapist')}</p>
              </>
            )}
          </section>
        )
      }
    </Answer>
  );
}
