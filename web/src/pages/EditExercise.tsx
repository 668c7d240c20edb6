// What may change of an exercise: its name, its words, and how it is done. What is measured stays.
import { Button, Group } from '@mantine/core';
import { useState, type FormEvent } from 'react';
import { useChangeExercise } from '../api/changes';
import type { Exercise, Posture } from '../api/types';
import { Problem } from '../components/Feedback';
import { ExerciseWords, PostureChoice } from '../components/forms/ExerciseFields';
import { t } from '../i18n';
import { isWalk } from '../lib/exercises';

export function EditExercise({ exercise, onDone }: { exercise: Exercise; onDone: () => void }) {
  const change = useChangeExercise(exercise.id);
  const [name, setName] = useState(exercise.name);
  const [description, setDescription] = useState(exercise.description ?? '');
  const [posture, setPosture] = useState<Posture>(exercise.posture ?? 'standing');
  const submit = (event: FormEvent) => {
    event.preventDefault();
    change.mutate({ name: name.trim(), description, posture }, { onSuccess: onDone });
  };
  return (
    <form className="stack" onSubmit={submit}>
      {change.error && <Problem error={change.error} />}
      <ExerciseWords name={name} onName={setName} description={description} onDescription={setDescription} />
      {!isWalk(exercise.movement) && <PostureChoice value={posture} onChange={setPosture} />}
      <Group justify="flex-end">
        <Button variant="default" onClick={onDone}>
          {t('action.cancel')}
        </Button>
        <Button type="submit" loading={change.isPending}>
          {t('action.save')}
        </Button>
      </Group>
    </form>
  );
}
