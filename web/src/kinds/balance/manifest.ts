// Balance tests: quiet standing and reaching, with sensors on pelvis and chest.
import { t } from '../../i18n';
import type { SessionKind } from '../kind';

export const kind: SessionKind = {
  pipeline: 'balance',
  rank: 4,
  free: () => t('stand.title'),
  near: 'modules',
  needsPose: true,
  isGuided: false,
  hasEstimators: true,
  isCompared: false,
  hasPlaces: true,
  asksFeetApart: false,
  begin: {
    title: () => t('stand.title'),
    text: () => t('stand.text'),
    isTemplate: false,
    worn: [
      { title: () => t('stand.both'), placements: ['pelvis', 'sternum'] },
      { title: () => t('stand.pelvis'), placements: ['pelvis'] },
      { title: () => t('stand.chest'), placements: ['sternum'] },
    ],
  },
};
