import { NativeSelect } from '@mantine/core';
import { useState } from 'react';
import { byHand } from '../../api/client';
import { t } from '../../i18n';
import { chooseHere, chosenHere, isLanguage, LANGUAGES, type Language } from '../../i18n/languages';
import { Problem } from '../Feedback';

interface LanguageChoiceProps {
  /** The choice of the signed-in account; null where nobody is signed in: the choice is this browser's then. */
  account: string | null;
}

const data = () => [
  { value: '', label: t('language.browser') },
  ...Object.entries(LANGUAGES).map(([value, label]) => ({ value, label })),
];

/** In which language the pages are read. The page is loaded again: nothing of it may stay in the other language. */
export function LanguageChoice({ account }: LanguageChoiceProps) {
  const [problem, setProblem] = useState<Error | null>(null);
  const [choice, setChoice] = useState<string>(account ?? chosenHere());
  const choose = async (language: Language | '') => {
    setChoice(language);
    try {
      if (account !== null) await byHand.patch('/api/me', { body: { locale: language } });
      chooseHere(language);
      window.location.reload();
    } catch (error) {
      setChoice(account ?? '');
      setProblem(error as Error);
    }
  };
  return (
    <>
      {problem && <Problem error={problem} />}
      <NativeSelect
        label={t('language.label')}
        description={account === null ? undefined : t('language.help')}
        size="md"
        maw={320}
        data={data()}
        value={choice}
        onChange={(event) => {
          const value = event.currentTarget.value;
          void choose(isLanguage(value) ? value : '');
        }}
      />
    </>
  );
}
