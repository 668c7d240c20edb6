// Sentences of the service by their code alone, for pages that name one before the service has said it. Large: left out of what
// the patient's pages load.
import english from '../../../messages/en.json';
import { said, words, type Sentences } from './sentence';

/** What is said by a code without parameters; the code itself where nothing is known of it. */
export function wordsOf(code: string): string {
  return words(said({ code }, english as Sentences) ?? code, { code });
}
