// Arms and trunk: calibrated, joint angles against a template.
import { t } from '../../i18n';
import type { SessionKind } from '../kind';

export const kind: SessionKind = {
  pipeline: 'arm',
  free: () => t('session.free'),
  near: 'arm',
  needsPose: true,
  isGuided: false,
  hasEstimators: true,
  isCompared: true,
};
