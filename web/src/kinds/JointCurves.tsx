import { useMemo, useState } from 'react';
import { Traces } from '../charts/Traces';
import { ChannelPicker } from '../components/forms/ChannelPicker';
import { t } from '../i18n';
import { preferredAngles } from '../lib/channels';
import type { LiveProps } from './kind';

export interface JointCurvesProps extends LiveProps {
  id: string;
  title: string;
  isTitleHidden?: boolean;
  /** Drawn before the angles that were chosen. */
  always?: readonly string[];
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
      {shown.length > 0 ? (
        <Traces
          player={player}
          channels={shown}
          tools={<ChannelPicker available={angles} value={channels} onChange={setChosen} />}
        />
      ) : (
        <p className="muted">{t('traces.none')}</p>
      )}
    </section>
  );
}

const NONE: readonly string[] = [];
