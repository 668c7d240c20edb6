// Fields of an exercise that is added or changed.
import { Textarea, TextInput } from '@mantine/core';
import type { Posture } from '../../api/types';
import { t } from '../../i18n';
import { POSTURES } from '../../lib/exercises';
import { RadioCards } from './Choice';

export function ExerciseWords({
  name,
  onName,
  description,
  onDescription,
}: {
  name: string;
  onName: (name: string) => void;
  description: string;
  onDescription: (description: string) => void;
}) {
  return (
    <>
      <TextInput
        label={t('exercise.name')}
        required
        withAsterisk={false}
        maxLength={200}
        value={name}
        onChange={(event) => onName(event.currentTarget.value)}
        data-autofocus
      />
      <Textarea
        label={t('exercise.description')}
        description={t('exercise.descriptionHelp')}
        autosize
        minRows={2}
        maxLength={2000}
        value={description}
        onChange={(event) => onDescription(event.currentTarget.value)}
      />
    </>
  );
}

/** Whether it is done standing or sitting: the figure does the same. */
export function PostureChoice({ value, onChange }: { value: Posture; onChange: (posture: Posture) => void }) {
  return (
    <RadioCards
      legend={t('exercise.posture')}
      help={t('exercise.postureHelp')}
      value={value}
      onChange={onChange}
      columns={2}
      options={POSTURES.map((one) => ({ value: one, title: t(`exercise.posture.${one}`) }))}
    />
  );
}
