import { Button, PasswordInput, TextInput } from '@mantine/core';
import { useState, type FormEvent } from 'react';
import { useBeginSecondFactor, useConfirmSecondFactor, useRemoveSecondFactor } from '../api/changes';
import { useSecondFactor } from '../api/queries';
import { QueryBoundary, Notice, Problem } from '../components/Feedback';
import { QrCode } from '../components/account/QrCode';
import { t } from '../i18n';
import { date } from '../lib/format';
import './SecondFactorCard.css';

/** Two-step sign-in: set up with an authenticator app, recovery codes shown once, turned off with the password. */
export function SecondFactorCard() {
  const state = useSecondFactor();
  const begin = useBeginSecondFactor();
  const confirm = useConfirmSecondFactor();
  const [code, setCode] = useState('');
  const finish = (event: FormEvent) => {
    event.preventDefault();
    confirm.mutate({ code }, { onSuccess: () => setCode('') });
  };
  return (
    <section className="card stack form-card" aria-labelledby="second-factor">
      <h2 id="second-factor">{t('second.title')}</h2>
      <QueryBoundary of={state} lines={2}>
        {(found) => {
          if (confirm.data) return <RecoveryCodes codes={confirm.data.codes} />;
          if (found.is_on) return <TurnOff since={found.since ?? ''} left={found.recovery_codes_left} />;
          if (!begin.data)
            return <ByPassword change={begin} text={t('second.what')} button={t('second.setUp')} isMain />;
          return (
            <form className="stack" onSubmit={finish}>
              <p>{t('second.scan')}</p>
              <QrCode text={begin.data.uri} label={t('second.qr')} />
              <p className="small muted">
                {t('second.byHand')} <code className="break">{begin.data.secret.replace(/(.{4})/g, '$1 ').trim()}</code>
              </p>
              {confirm.error && <Problem error={confirm.error} />}
              <TextInput
                label={t('second.code')}
                inputMode="numeric"
                autoComplete="one-time-code"
                required
                withAsterisk={false}
                maxLength={7}
                value={code}
                onChange={(event) => setCode(event.currentTarget.value)}
              />
              <div>
                <Button type="submit" loading={confirm.isPending}>
                  {t('second.turnOn')}
                </Button>
              </div>
            </form>
          );
        }}
      </QueryBoundary>
    </section>
  );
}

function RecoveryCodes({ codes }: { codes: readonly string[] }) {
  return (
    <>
      <Notice>
        <p role="status">{t('second.isOnNow')}</p>
      </Notice>
      <p>{t('second.keep')}</p>
      <ul className="recovery-codes">
        {codes.map((one) => (
          <li key={one}>
            <code>{one}</code>
          </li>
        ))}
      </ul>
    </>
  );
}

function TurnOff({ since, left }: { since: string; left: number }) {
  const remove = useRemoveSecondFactor();
  const text = `${t('second.isOn', { date: date(since) })} ${t('second.left', { count: left })}`;
  return <ByPassword change={remove} text={text} button={t('second.turnOff')} />;
}

/** What an open browser alone must not do asks for the password. */
function ByPassword({
  change,
  text,
  button,
  isMain = false,
}: {
  change: { mutate: (input: { password: string }) => void; error: Error | null; isPending: boolean };
  text: string;
  button: string;
  isMain?: boolean;
}) {
  const [password, setPassword] = useState('');
  const submit = (event: FormEvent) => {
    event.preventDefault();
    change.mutate({ password });
  };
  return (
    <form className="stack" onSubmit={submit}>
      <p>{text}</p>
      {change.error && <Problem error={change.error} />}
      <PasswordInput
        label={t('account.present')}
        autoComplete="current-password"
        required
        withAsterisk={false}
        value={password}
        onChange={(event) => setPassword(event.currentTarget.value)}
        visibilityToggleButtonProps={{ 'aria-label': t('signIn.showPassword'), tabIndex: 0, 'aria-hidden': false }}
      />
      <div>
        <Button type="submit" variant={isMain ? 'filled' : 'default'} loading={change.isPending}>
          {button}
        </Button>
      </div>
    </form>
  );
}
