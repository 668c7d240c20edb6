// E-mail, password and, when the service asks for it, the code of the second step.
import { PasswordInput, TextInput } from '@mantine/core';
import { useState } from 'react';
import { ApiError } from '../../api/client';
import type { SignInRequest } from '../../api/types';
import { t } from '../../i18n';

/** The service asks for the code: no failure. */
export const isCodeAsked = (error: unknown) => error instanceof ApiError && error.code === 'code_required';

/** What is typed, and whether the code was asked for. */
export function useSignInFields(startEmail = '') {
  const [email, setEmail] = useState(startEmail);
  const [password, setPassword] = useState('');
  const [code, setCode] = useState('');
  const [asksCode, setAsksCode] = useState(false);
  const request: SignInRequest = { email, password, code: asksCode && code ? code : null };
  const fields = (
    <>
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
        data-autofocus
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
    </>
  );
  const onError = (error: Error) => {
    if (isCodeAsked(error)) setAsksCode(true);
  };
  return { request, fields, onError };
}
