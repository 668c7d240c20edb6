// Which language is spoken, and that its words come when it is.
import { afterEach, beforeEach, expect, it } from 'vitest';
import { currentLanguage, speakWith, t } from '../../src/i18n';
import { words as english } from '../../src/i18n/en';
import { chooseHere, chosenHere, sentencesReady, speakLanguage, wanted } from '../../src/i18n/languages';
import { inOurWords, words } from '../../src/i18n/sentence';

beforeEach(() => localStorage.clear());
afterEach(() => speakWith('en', english));

it('follows the account, then the choice in this browser, then the browser, then English', () => {
  expect(wanted('', ['fr-FR', 'de-AT', 'en'])).toBe('de');
  expect(wanted('', ['fr-FR'])).toBe('en');
  chooseHere('en');
  expect(wanted('', ['de'])).toBe('en');
  expect(wanted('de', ['en'])).toBe('de');
  expect(wanted('xx', ['de'])).toBe('en');
  chooseHere('');
  expect(chosenHere()).toBe('');
  expect(wanted('', ['de'])).toBe('de');
});

it('passes over a stored choice that is no language', () => {
  localStorage.setItem('telemotion.language', 'toString');
  expect(wanted('', ['de'])).toBe('de');
});

it('says words and sentences in the language that was loaded', async () => {
  await speakLanguage('de');
  expect(currentLanguage()).toBe('de');
  expect(t('action.save')).toBe('Speichern');
  await sentencesReady();
  expect(words('Slower.', { code: 'guidance.slower', params: {} })).toBe('Langsamer.');
  await speakLanguage('en');
  expect(t('action.save')).toBe('Save');
  expect(words('Slower.', { code: 'guidance.slower', params: {} })).toBe('Slower.');
});

it('labels measures and curves anew, which the service labels in English', async () => {
  const answer = () => ({
    curve: { channel: 'humerus_forearm_right_zxy_flexion', label: 'Elbow flexion' },
    measures: [
      { measure: 'range:thorax_humerus_left_yxy_elevation', label: 'Shoulder elevation, range of motion' },
      { measure: 'walk:stride_length:left', label: 'Stride length, steady strides, left' },
      { measure: 'walk:uneven:step_time', label: 'Step time, left compared with right' },
      { measure: 'of_a_newer_service', label: 'Something new' },
    ],
  });
  expect(inOurWords(answer())).toEqual(answer());
  await speakLanguage('de');
  await sentencesReady();
  const said = inOurWords(answer());
  expect(said.curve.label).toBe('Ellbogenflexion');
  expect(said.measures.map((one) => one.label)).toEqual([
    'Schulterelevation, Bewegungsumfang',
    'Doppelschrittlänge, gleichmäßige Doppelschritte, links',
    'Schrittdauer, links gegenüber rechts',
    'Something new',
  ]);
});
