// Nobody with a pacemaker near a magnetic source: asked before each session, by the therapist.
import { Button } from '@mantine/core';
import { IconShieldCheck } from '@tabler/icons-react';
import { useState } from 'react';
import { useConfirmNoImplants, useWithdrawSafety } from '../../api/changes';
import { useMagneticSafety } from '../../api/queries';
import type { MagneticSafety, SessionDetail } from '../../api/types';
import { Confirm } from '../../components/forms/Confirm';
import { QueryBoundary, Notice, Problem } from '../../components/Feedback';
import { t } from '../../i18n';
import { dateTime, spreadAlone } from '../../lib/format';
import { isSafe, UNASKED } from './magneticSetup';
import { ImplantQuestions } from './ImplantQuestions';

const ENDED: readonly string[] = ['closing', 'analysed', 'failed'];

/** Why an earlier word does not hold any more. */
function whyAgain(safety: MagneticSafety): string | null {
  if (safety.withdrawn_at) {
    const at = dateTime(safety.withdrawn_at);
    return safety.withdrawn_by
      ? t('safety.withdrawn', { name: safety.withdrawn_by, at })
      : t('safety.withdrawnNoName', { at });
  }
  return safety.confirmed_at ? t('safety.expired', { at: dateTime(safety.confirmed_at) }) : null;
}

function sourceText(safety: MagneticSafety): string {
  if (typeof safety.gain_sigma !== 'number') return '';
  const gain = spreadAlone(100 * safety.gain_sigma, 1);
  return safety.source_serial
    ? t('safety.source', { name: safety.source_name, serial: safety.source_serial, gain })
    : t('safety.sourceDescribed', { gain });
}

export function SafetyCard({ session }: { session: SessionDetail }) {
  const asked = useMagneticSafety(session.id, true);
  const confirm = useConfirmNoImplants(session.id);
  const withdraw = useWithdrawSafety(session.id);
  const [said, setSaid] = useState(UNASKED);
  return (
    <QueryBoundary of={asked} lines={3}>
      {(safety) =>
        safety.confirmed ? (
          <Notice icon={<IconShieldCheck size={22} aria-hidden />}>
            {safety.confirmed_by
              ? t('magnetic.confirmed', { name: safety.confirmed_by, at: dateTime(safety.confirmed_at ?? '') })
              : t('magnetic.confirmedNoName', { at: dateTime(safety.confirmed_at ?? '') })}{' '}
            {safety.expires_at && t('safety.until', { at: dateTime(safety.expires_at) })} {sourceText(safety)}
            {session.may_treat && !ENDED.includes(session.state) && (
              <Confirm
                label={t('safety.withdraw')}
                title={t('safety.withdrawTitle')}
                text={t('safety.withdrawText')}
                isGrave
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
            {whyAgain(safety) && (
              <p className="strong" role="status">
                {whyAgain(safety)}
              </p>
            )}
            {session.may_treat ? (
              <>
                <ImplantQuestions
                  value={said}
                  onChange={setSaid}
                  keepAwayM={safety.keep_away_m}
                  limitT={safety.limit_t}
                />
                {confirm.error && <Problem error={confirm.error} />}
                <div>
                  <Button
                    disabled={!isSafe(said)}
                    loading={confirm.isPending}
                    onClick={() => confirm.mutate(undefined)}
                  >
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
    </QueryBoundary>
  );
}
