import { Button, Group, Modal, Select } from '@mantine/core';
import { useDisclosure } from '@mantine/hooks';
import { IconPlus, IconStretching } from '@tabler/icons-react';
import { useState, type FormEvent } from 'react';
import { Link } from 'react-router';
import { useAddExercise } from '../api/changes';
import { useExercises } from '../api/queries';
import type { Exercise, ExerciseIn, Posture } from '../api/types';
import { RadioCards } from '../components/forms/Choice';
import { ExerciseWords, PostureChoice } from '../components/forms/ExerciseFields';
import { QueryBoundary, Empty, Problem } from '../components/Feedback';
import { Page } from '../components/Page';
import { t } from '../i18n';
import { channelLabel } from '../lib/channels';
import { limbOf } from '../lib/placements';
import { TemplateLibrary } from './template/TemplateLibrary';
import { isWalk, primaryAngles, usualAngle, usualPosture } from '../lib/exercises';
import './Exercises.css';

const MOVEMENTS = [
  'reaching',
  'drinking',
  'abduction',
  'flexion',
  'pronation',
  'walk',
  'timed_up_and_go',
  'six_minute_walk',
  'other',
] as const;

function NewExercise({ onDone }: { onDone: () => void }) {
  const add = useAddExercise();
  const [name, setName] = useState('');
  const [description, setDescription] = useState('');
  const [movement, setMovement] = useState<ExerciseIn['movement']>('reaching');
  const [side, setSide] = useState<'left' | 'right'>('right');
  const [angle, setAngle] = useState<string | null>(null);
  const [posture, setPosture] = useState<Posture | null>(null);
  const shownPosture = posture ?? usualPosture(movement);
  const primary = angle && angle.includes(`_${side}_`) ? angle : usualAngle(movement, side);
  const submit = (event: FormEvent) => {
    event.preventDefault();
    add.mutate(
      {
        name: name.trim(),
        description,
        movement,
        side,
        primary_angle: isWalk(movement) ? '' : primary,
        posture: shownPosture,
      },
      { onSuccess: onDone },
    );
  };
  return (
    <form className="stack" onSubmit={submit}>
      {add.error && <Problem error={add.error} />}
      <ExerciseWords name={name} onName={setName} description={description} onDescription={setDescription} />
      <Select
        label={t('exercise.movement')}
        data={MOVEMENTS.map((value) => ({ value, label: t(`movement.${value}`) }))}
        value={movement}
        onChange={(value) => setMovement(value as ExerciseIn['movement'])}
      />
      {!isWalk(movement) && (
        <>
          <RadioCards
            legend={t('exercise.side')}
            value={side}
            onChange={setSide}
            columns={2}
            options={(['left', 'right'] as const).map((value) => ({
              value,
              title: t(`exercise.${limbOf(primary)}.${value}`),
            }))}
          />
          <PostureChoice value={shownPosture} onChange={setPosture} />
          <Select
            label={t('exercise.angle')}
            description={t('exercise.angleHelp')}
            data={primaryAngles(side).map((value) => ({ value, label: channelLabel(value).text }))}
            value={primary}
            onChange={setAngle}
          />
        </>
      )}
      <Group justify="flex-end">
        <Button variant="default" onClick={onDone}>
          {t('action.cancel')}
        </Button>
        <Button type="submit" loading={add.isPending}>
          {t('action.save')}
        </Button>
      </Group>
    </form>
  );
}

function Card({ exercise }: { exercise: Exercise }) {
  const movement = t(`movement.${exercise.movement}`);
  const kind = [
    movement !== exercise.name && movement,
    ...(isWalk(exercise.movement)
      ? []
      : [
          t(`exercise.${limbOf(exercise.primary_angle)}.${exercise.side ?? 'right'}`),
          t(`exercise.posture.${exercise.posture ?? 'standing'}`),
        ]),
  ].filter(Boolean);
  return (
    <li className="card exercise-card">
      <h2>
        <Link to={`/exercises/${exercise.id}`}>{exercise.name}</Link>
      </h2>
      {kind.length > 0 && <p className="muted small">{kind.join(' · ')}</p>}
      {exercise.description && <p>{exercise.description}</p>}
      <p className="small muted">
        {isWalk(exercise.movement)
          ? t('exercise.judgedByWalk')
          : t('exercise.judgedBy', { angle: channelLabel(exercise.primary_angle ?? '').text })}
      </p>
    </li>
  );
}

export function ExercisesPage() {
  const exercises = useExercises();
  const [isOpen, dialog] = useDisclosure(false);
  return (
    <Page
      title={t('nav.exercises')}
      lead={t('exercise.lead')}
      actions={
        <>
          <Button variant="default" leftSection={<IconPlus size={18} aria-hidden />} onClick={dialog.open}>
            {t('exercise.add')}
          </Button>
          <Button component={Link} to="/templates/record">
            {t('template.record')}
          </Button>
        </>
      }
    >
      <QueryBoundary of={exercises} lines={5} height={60}>
        {(list) =>
          list.length === 0 ? (
            <div className="card">
              <Empty
                icon={<IconStretching size={44} aria-hidden />}
                title={t('exercise.emptyTitle')}
                action={<Button onClick={dialog.open}>{t('exercise.add')}</Button>}
              >
                {t('exercise.emptyText')}
              </Empty>
            </div>
          ) : (
            <ul className="plain-list card-grid">
              {list.map((one) => (
                <Card key={one.id} exercise={one} />
              ))}
            </ul>
          )
        }
      </QueryBoundary>
      <TemplateLibrary exercises={exercises.data ?? []} />
      <Modal
        opened={isOpen}
        onClose={dialog.close}
        title={t('exercise.add')}
        closeButtonProps={{ 'aria-label': t('action.close') }}
      >
        {isOpen && <NewExercise onDone={dialog.close} />}
      </Modal>
    </Page>
  );
}
