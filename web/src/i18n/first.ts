// The first words that are spoken, asked for as soon as this piece is read; nothing is drawn before they have come.
import { speakLanguage, wanted } from './languages';

/** Where the wanted ones cannot be fetched, English is better than nothing. */
export const firstWords = speakLanguage(wanted()).catch(() => speakLanguage('en'));
