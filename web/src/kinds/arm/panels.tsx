// Arms and trunk: calibrated, joint angles against a template.
import { t } from '../../i18n';
import { JointCurves } from '../JointCurves';
import type { KindPanels, LiveProps } from '../kind';
import { BeginArm } from './BeginArm';
import { SessionActions } from './SessionActions';
import { useFollowed } from './useFollowed';

function Curves(props: LiveProps) {
  const templateAt = useFollowed(props);
  if (!props.columns) return null;
  return <JointCurves {...props} id="angles" title={t('traces.title')} isTitleHidden templateAt={templateAt} />;
}

export const panels: KindPanels = {
  Begin: BeginArm,
  live: { Curves },
  replay: { angles: () => t('traces.title'), Actions: SessionActions },
};
