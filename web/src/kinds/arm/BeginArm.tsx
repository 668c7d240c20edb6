// A new session of arms and trunk: which sensors are worn, and how their orientation is estimated.
import { useState } from 'react';
import { useEstimators } from '../../api/queries';
import type { Estimator, Placement } from '../../api/types';
import { QueryBoundary } from '../../components/Feedback';
import { Advanced } from '../../components/forms/Advanced';
import { RadioCards } from '../../components/forms/Choice';
import { PlacementChoice } from '../../components/forms/PlacementChoice';
import { useUnsaved } from '../../components/forms/useUnsaved';
import { t } from '../../i18n';
import { placementList } from '../../lib/channels';
import { day } from '../../lib/format';
import { placementProblem, suggestedPlacements } from '../../lib/placements';
import { BeginForm, YesNo } from '../BeginForm';
import type { BeginProps } from '../kind';

/** Those a therapist chooses between; the others are for comparison. */
const SHOWN_FIRST = 2;

export function BeginArm(props: BeginProps) {
  const { patient, exercise, purpose, angle } = props;
  const [chosen, setPlacements] = useState<Placement[] | null>(null);
  const placements = chosen ?? suggestedPlacements(patient.affected_side, angle);
  const [orientation, setOrientation] = useState<string | null>(null);
  const [constrain, setConstrain] = useState(false);
  const [useMounting, setUseMounting] = useState(false);
  const unsaved = useUnsaved({
    object: `session:${patient.id}:${purpose}`,
    value: { chosen, orientation, constrain, useMounting },
    isChanged: chosen !== null || orientation !== null || constrain || useMounting,
    onRestore: (stored) => {
      setPlacements(stored.chosen);
      setOrientation(stored.orientation);
      setConstrain(stored.constrain);
      setUseMounting(stored.useMounting);
    },
  });
  const problem = placementProblem(placements);
  const declared = {
    ...exercise,
    purpose,
    placements,
    ...(orientation ? { orientation } : {}),
    constrain_joint_headings: constrain,
    use_mounting: useMounting,
  };
  const mounted = patient.mounting;
  return (
    <BeginForm {...props} unsaved={unsaved} declared={problem ? null : declared}>
      <PlacementChoice value={placements} onChange={setPlacements} />
      {problem && (
        <p className="alert-text" role="alert">
          {t(problem)}
        </p>
      )}
      {patient.has_mounting && (
        <YesNo
          label={t('newSession.mounting')}
          description={
            t('newSession.mountingHelp') +
            (mounted
              ? ` ${t('newSession.mountingOf', { day: day(mounted.updated_at), places: placementList(mounted.placements) })}`
              : '')
          }
          value={useMounting}
          onChange={setUseMounting}
        />
      )}
      <Advanced>
        <EstimatorChoice value={orientation} onChange={setOrientation} />
        <YesNo
          label={t('newSession.constrain')}
          description={t('newSession.constrainHelp')}
          value={constrain}
          onChange={setConstrain}
        />
      </Advanced>
    </BeginForm>
  );
}

interface EstimatorProps {
  value: string | null;
  onChange: (name: string) => void;
}

function EstimatorChoice({ value, onChange }: EstimatorProps) {
  const estimators = useEstimators();
  const card = (one: Estimator) => ({ value: one.name, title: one.title, text: one.description });
  return (
    <QueryBoundary of={estimators} lines={2}>
      {(list) => {
        const live = list.filter((one) => !one.is_offline);
        const chosen = { value: value ?? live[0]?.name ?? '', onChange };
        return (
          <div>
            <RadioCards
              {...chosen}
              legend={t('newSession.estimator')}
              help={t('newSession.estimatorHelp')}
              options={live.slice(0, SHOWN_FIRST).map(card)}
            />
            {live.length > SHOWN_FIRST && (
              <details className="as-table">
                <summary>{t('newSession.otherEstimators')}</summary>
                <RadioCards
                  {...chosen}
                  legend={t('newSession.otherEstimators')}
                  options={live.slice(SHOWN_FIRST).map(card)}
                />
              </details>
            )}
          </div>
        );
      }}
    </QueryBoundary>
  );
}
