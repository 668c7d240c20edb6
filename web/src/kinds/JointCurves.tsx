import { useMemo, useState } from 'react';
import { PhaseLegend } from '../charts/PhaseChart';
import { Traces, type TemplateAt } from '../charts/Traces';
import { ChannelPicker } from '../components/forms/ChannelPicker';
import { t } from '../i18n';
import { preferredAngles } from '../lib/channels';
import { useSnapshot } from '../player/hooks';
import type { LiveProps } from './kind';
import './JointCurves.css';

export interface JointCurvesProps extends LiveProps {
  id: string;
  title: string;
  isTitleHidden?: boolean;
  /** Drawn before the angles that were chosen. */
  always?: readonly string[];
  /** What the patient follows, drawn behind the curves. */
  templateAt?: TemplateAt;
}

/** The joint angles of a live session, those of its exercise first; others are chosen from a list. */
export function JointCurves({
  session,
  player,
  columns,
  exercise,
  id,
  title,
  isTitleHidden,
  always = NONE,
  templateAt,
}: JointCurvesProps) {
  const [chosen, setChosen] = useState<string[] | null>(null);
  const angles = columns?.layout.angles ?? session.layout.angles;
  const channels = useMemo(
    () =>
      (chosen ?? preferredAngles(angles, exercise?.primary_angle, exercise?.side ?? null)).filter((name) =>
        angles.includes(name),
      ),
    [chosen, angles, exercise],
  );
  // The band stands where the patient is along the template: at the goal, or in a pause, she is nowhere along it.
  const { guidance } = useSnapshot(player);
  const isFollowed = guidance !== null && FOLLOWED.includes(guidance.status);
  const shown = useMemo(() => [...always, ...channels], [always, channels]);
  return (
    <section className="card" aria-labelledby={id}>
      {isTitleHidden ? (
        <h2 id={id} className="visually-hidden">
          {title}
        </h2>
      ) : (
        <div className="card-head">
          <h2 id={id}>{title}</h2>
        </div>
      )}
      {templateAt && shown.length > 0 && (
        <div className="curves-legend">
          {isFollowed ? (
            <PhaseLegend withOutside={false} patient />
          ) : (
            <p className="muted small">{t('traces.notFollowed')}</p>
          )}
        </div>
      )}
      {shown.length > 0 ? (
        <Traces
          player={player}
          channels={shown}
          templateAt={templateAt}
          tools={<ChannelPicker available={angles} value={channels} onChange={setChosen} />}
        />
      ) : (
        <p className="muted">{t('traces.none')}</p>
      )}
    </section>
  );
}

const NONE: readonly string[] = [];
const FOLLOWED: readonly string[] = ['waiting', 'ready', 'moving'];
