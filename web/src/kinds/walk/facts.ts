// Walks: feet, led through by a protocol, with forces where the shoes measure them.
import { t } from '../../i18n';
import type { SessionKind } from '../kind';

export const kind: SessionKind = {
  pipeline: 'gait',
  free: () => t('session.freeWalk'),
  near: 'feet',
  needsPose: false,
  isGuided: true,
  hasEstimators: true,
  isCompared: false,
};
