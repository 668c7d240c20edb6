// One guided calibration while it runs: the picture, what to do now, how far it is, what to mend.
import { Button, Group, Progress } from '@mantine/core';
import { IconCheck } from '@tabler/icons-react';
import type { CalibrationMessage, Placement, SensorProgress } from '../../api/types';
import { t } from '../../i18n';
import { placementLabel } from '../../lib/channels';
import { number } from '../../lib/format';
import { wornLimbs } from '../../lib/placements';
import { CoverageSphere } from '../../pictures/CoverageSphere';
import { StepPicture } from '../../pictures/StepPicture';
import './calibration.css';
import './RunningCalibration.css';

function Steps({ guide }: { guide: CalibrationMessage }) {
  return (
    <ol className="guide-steps">
      {guide.steps.map((step, index) => {
        const isFound = guide.sensors?.length
          ? guide.sensors.every((sensor) => sensor.found?.includes(step.key))
          : false;
        const isDone = index < guide.step || isFound;
        return (
          <li
            key={step.key}
            className={
              isDone ? 'guide-step guide-step-done' : index === guide.step ? 'guide-step guide-step-now' : 'guide-step'
            }
            aria-current={index === guide.step ? 'step' : undefined}
          >
            {isDone && <IconCheck size={17} stroke={2.6} aria-hidden />}
            {step.title}
            {isDone && <span className="visually-hidden"> ({t('steps.done')})</span>}
          </li>
        );
      })}
    </ol>
  );
}

function Sensor({ sensor, isCompass }: { sensor: SensorProgress; isCompass: boolean }) {
  return (
    <li>
      <div className="line-head">
        <span className="strong">{placementLabel(sensor.placement)}</span>
        <span className="muted number">
          {isCompass && typeof sensor.coverage === 'number'
            ? t('compass.coverage', { percent: number(100 * sensor.coverage) })
            : `${number(100 * sensor.progress)} %`}
          {typeof sensor.residual_percent === 'number' &&
            ` · ${t('compass.residual', { percent: number(sensor.residual_percent, 1) })}`}
        </span>
      </div>
      <Progress
        value={100 * sensor.progress}
        transitionDuration={0}
        color={sensor.is_done ? 'accent' : undefined}
        aria-label={t('guide.sensorProgress', { place: placementLabel(sensor.placement) })}
      />
      {sensor.hint && <p className="small">{sensor.hint}</p>}
    </li>
  );
}

export interface RunningProps {
  guide: CalibrationMessage;
  /** Where the session's sensors are worn. */
  placements: readonly Placement[];
  title: string;
  /** Instead of the step's own. */
  instruction?: string;
  mayAct: boolean;
  isBusy: boolean;
  onNext: () => void;
  onCancel: () => void;
}

export function RunningCalibration({
  guide,
  placements,
  title,
  instruction,
  mayAct,
  isBusy,
  onNext,
  onCancel,
}: RunningProps) {
  const isEvaluating = guide.phase === 'evaluating' || guide.step >= guide.steps.length;
  const step = guide.steps[Math.min(guide.step, guide.steps.length - 1)];
  if (!step) return null;
  const isCompass = guide.kind === 'magnetometer';
  const isByPerson = step.ends === 'next' || isCompass;
  const sensors = guide.sensors ?? [];
  // The sensor that has the most to do yet is the one to look at.
  const least = isCompass ? [...sensors].sort((a, b) => a.progress - b.progress)[0] : undefined;
  return (
    <section className="card guide" aria-labelledby="guide-step">
      <div className="guide-picture">
        {isCompass && least?.visited?.length ? (
          <CoverageSphere
            directions={guide.directions ?? []}
            visited={least.visited}
            coverage={least.coverage ?? null}
          />
        ) : (
          <StepPicture picture={step.picture} worn={wornLimbs(placements)} />
        )}
      </div>
      <div className="guide-words">
        <p className="muted">
          {guide.steps.length > 1
            ? t('guide.stepOf', { title, step: Math.min(guide.step + 1, guide.steps.length), of: guide.steps.length })
            : title}
        </p>
        <h2 id="guide-step">{isEvaluating ? t('guide.evaluating') : step.title}</h2>
        {!isEvaluating && <p className="guide-instruction">{instruction ?? step.instruction}</p>}
        <Progress
          value={100 * (isEvaluating ? 1 : guide.step_progress)}
          size="xl"
          transitionDuration={0}
          aria-label={t('guide.progress')}
        />
        <p className="strong" role="status">
          {!isEvaluating && guide.hint && guide.hint !== step.instruction ? guide.hint : ''}
        </p>
        {guide.steps.length > 1 && <Steps guide={guide} />}
        {sensors.length > 0 && (
          <ul className="plain-list lines guide-sensors">
            {sensors.map((sensor) => (
              <Sensor key={sensor.placement} sensor={sensor} isCompass={isCompass} />
            ))}
          </ul>
        )}
        {mayAct && !isEvaluating && (
          <Group>
            {isByPerson && (
              <Button
                size="lg"
                onClick={onNext}
                loading={isBusy}
                disabled={step.ends === 'next' && guide.step_progress < 1}
              >
                {isCompass
                  ? t('guide.enough')
                  : guide.step + 1 < guide.steps.length
                    ? t('guide.next')
                    : t('guide.finish')}
              </Button>
            )}
            <Button size="lg" variant="default" onClick={onCancel}>
              {t('action.cancel')}
            </Button>
          </Group>
        )}
      </div>
    </section>
  );
}
