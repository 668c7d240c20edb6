// A worn magnetic source and the sensors around it.
import { t } from '../../i18n';
import { wornPlacements } from '../../lib/placements';
import { simulatedMovement } from './magneticSetup';
import type { SessionKind } from '../kind';

export const kind: SessionKind = {
  pipeline: 'relative_pose',
  rank: 3,
  free: () => t('magnetic.kind'),
  near: 'modules',
  needsPose: false,
  isGuided: false,
  hasEstimators: false,
  isCompared: false,
  begin: { title: () => t('magnetic.kind'), text: () => t('magnetic.kindText'), isTemplate: false, isApart: true },
  hasPlaces: true,
  asksFeetApart: false,
  simulated: (session) => `--relative ${simulatedMovement(wornPlacements(session))} --no-implants`,
};
