// Arms and trunk: calibrated, joint angles against a template.
import { t } from '../../i18n';
import { suggestedPlacements } from '../../lib/placements';
import type { SessionKind } from '../kind';

export const kind: SessionKind = {
  pipeline: 'arm',
  rank: 1,
  free: () => t('session.free'),
  near: 'arm',
  needsPose: true,
  isGuided: false,
  hasEstimators: true,
  isCompared: true,
  begin: {
    title: () => t('newSession.arms'),
    text: () => t('newSession.armsText'),
    isTemplate: true,
    usual: suggestedPlacements,
  },
  upload: { title: () => t('upload.pipeline.arm'), text: () => t('upload.pipeline.arm.text') },
  hasPlaces: true,
  asksFeetApart: false,
};
