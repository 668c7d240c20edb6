// Words that speak of how an exercise is done: `lib/posture.ts` takes the one that fits.
import type { Translated } from '../..';
import type { posture as english } from '../../en/own/posture';

export const posture: Translated<typeof english> = {
  'posture.waiting.any': 'Nehmen Sie wieder die Ausgangshaltung ein und ruhen Sie einen Moment',
  'posture.waiting.seated': 'Setzen Sie sich wie am Anfang hin und ruhen Sie einen Moment',
  'posture.waiting.standing': 'Stellen Sie sich wie am Anfang hin und ruhen Sie einen Moment',
  'posture.ready.any': 'Drücken Sie auf Los und machen Sie dann Ihre Übung.',
  'posture.ready.seated': 'Setzen Sie sich jetzt auf einen Stuhl. Drücken Sie auf Los und machen Sie dann Ihre Übung.',
  'posture.ready.standing': 'Bleiben Sie stehen. Drücken Sie auf Los und machen Sie dann Ihre Übung.',
  'posture.upright.any': 'Halten Sie den Rumpf aufrecht.',
  'posture.upright.seated': 'Bleiben Sie mit dem Rücken an der Lehne.',
  'posture.upright.standing': 'Stehen Sie aufrecht und neigen Sie sich nicht.',
};
