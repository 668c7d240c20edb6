// What may change of an exercise: its name, its words, and how it is done. What is measured stays.
import { Button, Group, Textarea, TextInput } from '@mantine/core';
import { useState, type FormEvent } from 'react';
import { useChangeExercise } from '../api/queries';
import type { Exercise, Posture } from '../api/types';
import { Problem } from '../components/Feedback';
import { t } from '../i18n';
import { isWalk } from '../lib/exercises';
import { PostureChoice } from './Exercises';

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
      <TextInput
        label={t('exercise.name')}
        required
        withAsterisk={false}
        maxLength={200}
        value={name}
        onChange={(event) => setName(event.currentTarget.value)}
        data-autofocus
      />
      <Textarea
        label={t('exercise.description')}
        description={t('exercise.descriptionHelp')}
        autosize
        minRows={2}
        maxLength={2000}
        value={description}
        onChange={(event) => setDescription(event.currentTarget.value)}
      />
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
