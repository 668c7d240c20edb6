import { Button } from '@mantine/core';
import { useEffect, type FormEvent } from 'react';
import { Navigate, useSearchParams } from 'react-router';
import { useMe, useSignIn } from '../api/queries';
import { Notice, Problem } from '../components/Feedback';
import { Wordmark } from '../components/Shell';
import { LanguageChoice } from '../components/account/LanguageChoice';
import { isCodeAsked, useSignInFields } from '../components/account/SignInFields';
import { t } from '../i18n';
import './SignIn.css';

/** Only a path of this client may follow the sign-in. */
function safeNext(next: string | null): string {
  return next && next.startsWith('/') && !next.startsWith('//') && !next.startsWith('/\\') ? next : '/';
}

export function SignInPage() {
  const me = useMe();
  const signIn = useSignIn();
  const [search] = useSearchParams();
  const { request, fields, onError } = useSignInFields();
  useEffect(() => {
    document.title = `${t('signIn.title')} · ${t('product.name')}`;
    // Also on a device whose patient never comes back.
    import('../sensors/unsentHere').then(({ forgetOld }) => forgetOld()).catch(() => undefined);
  }, []);
  if (me.data) return <Navigate to={safeNext(search.get('next'))} replace />;

  const submit = (event: FormEvent) => {
    event.preventDefault();
    signIn.mutate(request, { onError });
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
          {signIn.error && !isCodeAsked(signIn.error) && <Problem error={signIn.error} />}
          {fields}
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
