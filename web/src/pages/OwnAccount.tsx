import { Button, PasswordInput } from '@mantine/core';
import { useState, type FormEvent } from 'react';
import { Link } from 'react-router';
import { useChangePassword } from '../api/changes';
import { Notice, Problem } from '../components/Feedback';
import { Page } from '../components/Page';
import { LanguageChoice } from '../components/account/LanguageChoice';
import { useSignedIn } from '../components/account/useSignedIn';
import { t } from '../i18n';
import { SecondFactorCard } from './SecondFactorCard';

const LEAST = 10;

/** The own account: who is signed in, and a new password by who knows the present one. */
export function OwnAccountPage() {
  const me = useSignedIn();
  const change = useChangePassword();
  const [present, setPresent] = useState('');
  const [wanted, setWanted] = useState('');
  const submit = (event: FormEvent) => {
    event.preventDefault();
    change.mutate(
      { old_password: present, new_password: wanted },
      {
        onSuccess: () => {
          setPresent('');
          setWanted('');
        },
      },
    );
  };
  const toggle = { 'aria-label': t('signIn.showPassword'), tabIndex: 0, 'aria-hidden': false } as const;
  return (
    <Page narrow title={t('account.title')} lead={`${me.display_name} · ${me.email}`}>
      <div className="stack">
        {me.must && (
          <Notice>
            <p role="status">{me.must === 'password' ? t('account.mustPassword') : t('account.mustSecond')}</p>
          </Notice>
        )}
        <form className="card stack form-card" onSubmit={submit} aria-labelledby="password">
          <h2 id="password">{t('account.password')}</h2>
          {change.error && <Problem error={change.error} />}
          {change.isSuccess && (
            <Notice>
              <p role="status">{t('account.changed')}</p>
              {!me.must && (
                <Button component={Link} to="/" mt={12}>
                  {t('account.goOn')}
                </Button>
              )}
            </Notice>
          )}
          <PasswordInput
            label={t('account.present')}
            autoComplete="current-password"
            required
            withAsterisk={false}
            value={present}
            onChange={(event) => setPresent(event.currentTarget.value)}
            visibilityToggleButtonProps={toggle}
          />
          <PasswordInput
            label={t('clinic.newPassword')}
            description={t('clinic.passwordHelp', { least: LEAST })}
            autoComplete="new-password"
            required
            withAsterisk={false}
            minLength={LEAST}
            maxLength={200}
            value={wanted}
            onChange={(event) => setWanted(event.currentTarget.value)}
            visibilityToggleButtonProps={toggle}
          />
          <div>
            <Button type="submit" loading={change.isPending}>
              {t('account.change')}
            </Button>
          </div>
        </form>
        {!me.must && (
          <section className="card stack form-card" aria-label={t('language.label')}>
            <LanguageChoice account={me.locale} />
          </section>
        )}
        {me.must !== 'password' && <SecondFactorCard />}
      </div>
    </Page>
  );
}
