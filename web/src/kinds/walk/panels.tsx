// Walks: feet, led through by a protocol, with forces where the shoes measure them.
import { useMemo } from 'react';
import { Traces } from '../../charts/Traces';
import { Notice } from '../../components/Feedback';
import { t } from '../../i18n';
import type { KindPanels, LiveProps, ReplayProps } from '../kind';
import { MakeTemplate } from '../MakeTemplate';
import { BeginWalk } from './BeginWalk';
import { FootCurves } from './views/FootCurves';
import { GuidedWalk } from './views/GuidedWalk';
import { walkKind } from './guidedWalk';
import { LiveWalk } from './views/LiveWalk';
import { WalkSheets } from './views/WalkSheets';
import { WalkMap, WalkPanel } from './views/WalkPanel';
import { WalkLink } from './views/WalkLink';

const Guide = ({ columns, exercise, ...props }: LiveProps) => (
  <GuidedWalk {...props} kind={exercise === null ? null : walkKind(exercise?.movement)} delayS={columns?.delayS ?? 0} />
);

function Curves({ session, player, columns }: LiveProps) {
  const feet = useMemo(
    () => session.layout.scalars.filter((name) => name.endsWith('_speed_mps') || name.endsWith('_force_z_n')),
    [session.layout.scalars],
  );
  return (
    <>
      <Notice>{t('live.walkHelp')}</Notice>
      {columns && (
        <section className="card" aria-labelledby="feet">
          <h2 id="feet">{t('live.walk')}</h2>
          <Traces player={player} channels={feet} />
        </section>
      )}
    </>
  );
}

const Side = ({ session, player, columns }: LiveProps) =>
  columns && <LiveWalk player={player} scalars={session.layout.scalars} delayS={columns.delayS} />;

const Panel = ({ session }: ReplayProps) => <WalkPanel sessionId={session.id} patientId={session.patient_id} />;

export const panels: KindPanels = {
  Begin: BeginWalk,
  live: { Guide, Curves, Side },
  Report: WalkSheets,
  replay: {
    UnderPicture: ({ session }) => <WalkMap sessionId={session.id} />,
    tab: { value: 'walk', title: () => t('walk.result'), Panel },
    angles: () => t('walk.curves'),
    Curves: FootCurves,
    Actions: ({ session }) => (
      <>
        <MakeTemplate session={session} />
        <WalkLink sessionId={session.id} />
      </>
    ),
  },
};
