// Walks: feet, led through by a protocol, with forces where the shoes measure them.
import { t } from '../../i18n';
import { isWalk } from '../../lib/exercises';
import { FEET } from '../../lib/placements';
import type { SessionKind } from '../kind';

export const kind: SessionKind = {
  pipeline: 'gait',
  rank: 2,
  free: () => t('session.freeWalk'),
  near: 'feet',
  needsPose: false,
  isGuided: true,
  hasEstimators: true,
  isCompared: true,
  begin: {
    title: () => t('newSession.feet'),
    text: () => t('newSession.feetText'),
    isTemplate: true,
    suits: isWalk,
    usual: () => FEET,
  },
  upload: { title: () => t('upload.pipeline.gait'), text: () => t('upload.pipeline.gait.text') },
  hasPlaces: true,
  asksFeetApart: true,
};
