import { Button, PasswordInput, TextInput } from '@mantine/core';
import { useEffect, useState, type FormEvent } from 'react';
import { Navigate, useSearchParams } from 'react-router';
import { ApiError } from '../api/client';
import { useMe, useSignIn } from '../api/queries';
import { Notice, Problem } from '../components/Feedback';
import { Wordmark } from '../components/Shell';
import { LanguageChoice } from '../components/account/LanguageChoice';
import { t } from '../i18n';

/** Only a path of this client may follow the sign-in. */
function safeNext(next: string | null): string {
  return next && next.startsWith('/') && !next.startsWith('//') && !next.startsWith('/\\') ? next : '/';
}

/** The service asks for the code: no failure. */
const isAsked = (error: Error) => error instanceof ApiError && error.code === 'code_required';

export function SignInPage() {
  const me = useMe();
  const signIn = useSignIn();
  const [search] = useSearchParams();
  const [email, setEmail] = useState('');
  const [password, setPassword] = useState('');
  const [code, setCode] = useState('');
  const [asksCode, setAsksCode] = useState(false);
  useEffect(() => {
    document.title = `${t('signIn.title')} · ${t('product.name')}`;
    // Also on a device whose patient never comes back.
    import('../sensors/unsentHere').then(({ forgetOld }) => forgetOld()).catch(() => undefined);
  }, []);
  if (me.data) return <Navigate to={safeNext(search.get('next'))} replace />;

  const submit = (event: FormEvent) => {
    event.preventDefault();
    const onError = (error: Error) => {
      if (error instanceof ApiError && error.code === 'code_required') setAsksCode(true);
    };
    signIn.mutate({ email, password, code: asksCode && code ? code : null }, { onError });
  };
  return (
    <main className="sign-in">
      <div className="sign-in-picture">
        <Wordmark />
        <svg viewBox="0 0 600 300" aria-hidden>
          <path
            d="M20 250C140 250 180 90 300 78s170 130 280 132"
            fill="none"
            stroke="#a9d2d6"
            strokeOpacity=".24"
            strokeWidth="66"
            strokeLinecap="round"
          />
          <path
            d="M20 250C140 250 180 90 300 78s170 130 280 132"
            fill="none"
            stroke="#a9d2d6"
            strokeWidth="3"
            strokeDasharray="2 11"
            strokeLinecap="round"
          />
          <path
            d="M20 254C120 258 190 112 292 92s176 96 288 108"
            fill="none"
            stroke="#fff"
            strokeWidth="5"
            strokeLinecap="round"
          />
          <circle cx="292" cy="92" r="10" fill="#0c4a55" stroke="#fff" strokeWidth="5" />
        </svg>
        <p>{t('signIn.promise')}</p>
      </div>
      <div className="sign-in-form">
        <form onSubmit={submit}>
          <h1>{t('signIn.title')}</h1>
          {search.get('ended') === 'idle' && !signIn.error && (
            <Notice>
              <p role="status">{t('signIn.endedIdle')}</p>
            </Notice>
          )}
          {signIn.error && !isAsked(signIn.error) && <Problem error={signIn.error} />}
          <TextInput
            label={t('signIn.email')}
            type="email"
            autoComplete="username"
            required
            withAsterisk={false}
            size="lg"
            value={email}
            onChange={(event) => setEmail(event.currentTarget.value)}
          />
          <PasswordInput
            label={t('signIn.password')}
            autoComplete="current-password"
            required
            withAsterisk={false}
            size="lg"
            value={password}
            onChange={(event) => setPassword(event.currentTarget.value)}
            visibilityToggleButtonProps={{ 'aria-label': t('signIn.showPassword'), tabIndex: 0, 'aria-hidden': false }}
          />
          {asksCode && (
            <TextInput
              label={t('second.code')}
              description={t('second.codeHelp')}
              autoComplete="one-time-code"
              required
              withAsterisk={false}
              size="lg"
              maxLength={40}
              value={code}
              onChange={(event) => setCode(event.currentTarget.value)}
            />
          )}
          <Button type="submit" size="lg" loading={signIn.isPending}>
            {t('action.signIn')}
          </Button>
          <p className="muted small">{t('signIn.help')}</p>
          <LanguageChoice account={null} />
        </form>
      </div>
    </main>
  );
}
