// Nobody with a pacemaker near a magnetic source: asked before each session, by the therapist.
import { Button } from '@mantine/core';
import { IconShieldCheck } from '@tabler/icons-react';
import { useState } from 'react';
import { useConfirmNoImplants, useMagneticSafety, useWithdrawSafety } from '../../api/queries';
import type { MagneticSafety, SessionDetail } from '../../api/types';
import { Confirm } from '../../components/Confirm';
import { Answer, Notice, Problem } from '../../components/Feedback';
import { t } from '../../i18n';
import { dateTime, number } from '../../lib/format';
import { isSafe, UNASKED } from '../../lib/magneticSetup';
import { ImplantQuestions } from './ImplantQuestions';

const ENDED: readonly string[] = ['closing', 'analysed', 'failed'];

/** Why an earlier word does not hold any more. */
function whyAgain(told: MagneticSafety): string | null {
  if (told.withdrawn_at) {
    const at = dateTime(told.withdrawn_at);
    return told.withdrawn_by ? t('safety.withdrawn', { name: told.withdrawn_by, at }) : t('safety.withdrawnNoName', { at });
  }
  return told.confirmed_at ? t('safety.expired', { at: dateTime(told.confirmed_at) }) : null;
}

function sourceText(told: MagneticSafety): string {
  if (typeof told.gain_sigma !== 'number') return '';
  const gain = number(100 * told.gain_sigma, 1);
  return told.source_serial ? t('safety.source', { name: told.source_name, serial: told.source_serial, gain }) : t('safety.sourceDescribed', { gain });
}

export function SafetyCard({ session }: { session: SessionDetail }) {
  const safety = useMagneticSafety(session.id, true);
  const confirm = useConfirmNoImplants(session.id);
  const withdraw = useWithdrawSafety(session.id);
  const [said, setSaid] = useState(UNASKED);
  return (
    <Answer of={safety} lines={3}>
      {(told) =>
        told.confirmed ? (
          <Notice icon={<IconShieldCheck size={22} aria-hidden />}>
            {told.confirmed_by
              ? t('magnetic.confirmed', { name: told.confirmed_by, at: dateTime(told.confirmed_at ?? '') })
              : t('magnetic.confirmedNoName', { at: dateTime(told.confirmed_at ?? '') })}{' '}
            {told.expires_at && t('safety.until', { at: dateTime(told.expires_at) })} {sourceText(told)}
            {session.may_treat && !ENDED.includes(session.state) && (
              <Confirm
                label={t('safety.withdraw')}
                title={t('safety.withdrawTitle')}
                text={t('safety.withdrawText')}
                confirm={t('safety.withdrawDo')}
                onConfirm={() => {
                  setSaid(UNASKED);
                  withdraw.mutate(undefined);
                }}
              />
            )}
            {withdraw.error && <Problem error={withdraw.error} />}
          </Notice>
        ) : (
          <section className="card stack" aria-labelledby="safety">
            <h2 id="safety">{t('magnetic.safety')}</h2>
            {whyAgain(told) && (
              <p className="strong" role="status">
                {whyAgain(told)}
              </p>
            )}
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
