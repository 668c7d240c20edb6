// The languages there are, which of them somebody reads, and how their words come: each in a piece of its own, the sentences of
// the service in a further one when the first of them is to be shown.
import { currentLanguage, speakWith, type Catalogue } from './index';
import { isSpoken, speak, type Sentences } from './sentence';

/** Each language by its own name, as its readers find it. */
export const LANGUAGES = { en: 'English', de: 'Deutsch' } as const;
export type Language = keyof typeof LANGUAGES;

const WORDS: Record<Language, () => Promise<{ words: Catalogue }>> = {
  en: () => import('./en'),
  de: () => import('./de'),
};
/** The service itself writes English. */
const SENTENCES: Partial<Record<string, () => Promise<unknown>>> = {
  de: async () => (await import('../../../messages/de.json')).default,
};
const STORED_AS = 'telemotion.language';

export const isLanguage = (name: string): name is Language => Object.hasOwn(LANGUAGES, name);

/** What was chosen in this browser; empty for nothing. */
export function chosenHere(): Language | '' {
  try {
    const chosen = localStorage.getItem(STORED_AS) ?? '';
    return isLanguage(chosen) ? chosen : '';
  } catch {
    return '';
  }
}

/** Remember a choice in this browser; empty forgets it. */
export function chooseHere(language: Language | ''): void {
  try {
    if (language) localStorage.setItem(STORED_AS, language);
    else localStorage.removeItem(STORED_AS);
  } catch {
    // A browser that stores nothing speaks its own language next time.
  }
}

/** The language to speak: of the account, else as chosen in this browser, else the browser's own, else English. */
export function wanted(account = '', own: readonly string[] = navigator.languages): Language {
  if (isLanguage(account)) return account;
  const chosen = chosenHere();
  return chosen || (own.map((one) => one.split('-')[0] ?? '').find(isLanguage) ?? 'en');
}

/** Load a language and speak it. */
export async function speakLanguage(language: Language): Promise<void> {
  if (isLoaded && language === currentLanguage()) return;
  const { words } = await WORDS[language]();
  speakWith(language, words);
  isLoaded = true;
}
let isLoaded = false;

/** When the service's sentences can be said in the language that is spoken. */
export async function sentencesReady(): Promise<void> {
  const language = currentLanguage();
  const load = SENTENCES[language];
  if (load && !isSpoken(language)) speak(language, (await load()) as Sentences);
}
