// Single sensors of an upload: their orientation, and nothing of a body.
import { t } from '../../i18n';
import type { SessionKind } from '../kind';

export const kind: SessionKind = {
  pipeline: 'orientation',
  rank: 5,
  free: () => t('upload.pipeline.orientation'),
  near: 'modules',
  needsPose: false,
  isGuided: false,
  hasEstimators: true,
  isCompared: false,
  upload: { title: () => t('upload.pipeline.orientation'), text: () => t('upload.pipeline.orientation.text') },
  hasPlaces: false,
  asksFeetApart: false,
};
