// Arms and trunk: calibrated, joint angles against a template.
import { t } from '../../i18n';
import { JointCurves } from '../JointCurves';
import type { KindParts, LiveProps } from '../kind';
import { SessionActions } from './SessionActions';

const Curves = (props: LiveProps) =>
  // Before it is known how sensors sit or which way they face, numbers would be wrong, not merely uncertain.
  props.state === 'calibrating' || !props.columns ? null : (
    <JointCurves {...props} id="angles" title={t('traces.title')} isTitleHidden />
  );

export const parts: KindParts = {
  live: { Curves },
  replay: { angles: () => t('traces.title'), Actions: SessionActions },
};
