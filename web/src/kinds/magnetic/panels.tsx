// A worn magnetic source and the sensors around it.
import { useMemo } from 'react';
import type { SessionDetail } from '../../api/types';
import { t } from '../../i18n';
import { JointCurves } from '../JointCurves';
import type { KindPanels, LiveProps, ReplayProps } from '../kind';
import { WalkLink } from '../walk/views/WalkLink';
import { BeginSource } from './BeginSource';
import { LiveSource, SourceStart } from './LiveSource';
import { SafetyCard } from './SafetyCard';
import { SourceLegend } from './SourceLegend';
import { SourcePanel } from './SourcePanel';

const useDistances = ({ layout }: SessionDetail) =>
  useMemo(() => layout.scalars.filter((name) => name.endsWith('_distance_m')), [layout.scalars]);

function Curves(props: LiveProps) {
  const distances = useDistances(props.session);
  return (
    <>
      <SourceLegend />
      {props.columns && <JointCurves {...props} id="distances" title={t('magnetic.motion')} always={distances} />}
    </>
  );
}

const Side = ({ session, player }: LiveProps) => (
  <LiveSource player={player} sensors={session.layout.segments.slice(1)} source={session.layout.segments[0] ?? ''} />
);

function Panel({ session, ...props }: ReplayProps) {
  return <SourcePanel sessionId={session.id} {...props} distances={useDistances(session)} />;
}

/** A source on one shoe and a sensor on the other: analysed as a walk as well. */
const Actions = ({ session }: { session: SessionDetail }) =>
  (['foot_left', 'foot_right'] as const).every((one) => session.placements.includes(one)) ? (
    <WalkLink sessionId={session.id} />
  ) : null;

export const panels: KindPanels = {
  Begin: BeginSource,
  live: {
    First: ({ session }) => <SafetyCard session={session} />,
    Start: ({ session, player }) => <SourceStart player={player} sensors={session.layout.segments.slice(1)} />,
    Curves,
    Side,
  },
  replay: {
    UnderPicture: () => <SourceLegend />,
    tab: { value: 'source', title: () => t('magnetic.title'), Panel },
    angles: () => t('magnetic.angles'),
    Actions,
  },
};
