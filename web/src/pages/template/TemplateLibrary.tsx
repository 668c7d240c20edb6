// The clinic's templates: found by words and tags, the retired ones on request.
import { Button, Switch, TextInput } from '@mantine/core';
import { useDebouncedValue } from '@mantine/hooks';
import { IconSearch } from '@tabler/icons-react';
import { useState } from 'react';
import { Link } from 'react-router';
import { useTemplateSearch } from '../../api/queries';
import type { Exercise, Template } from '../../api/types';
import { QueryBoundary, ShowMore } from '../../components/Feedback';
import { t } from '../../i18n';
import { date } from '../../lib/format';
import { limbOf } from '../../lib/placements';
import '../../styles/design.css';
import './TemplateLibrary.css';

export function TemplateLibrary({ exercises }: { exercises: readonly Exercise[] }) {
  const [typed, setTyped] = useState('');
  const [words] = useDebouncedValue(typed.trim(), 250);
  const [withRetired, setWithRetired] = useState(false);
  const found = useTemplateSearch(words, withRetired);
  return (
    <section className="card library" aria-labelledby="library">
      <div className="card-head">
        <h2 id="library">{t('library.title')}</h2>
        <Switch
          className="end"
          label={t('library.withRetired')}
          checked={withRetired}
          onChange={(event) => setWithRetired(event.currentTarget.checked)}
        />
      </div>
      <TextInput
        type="search"
        maw={480}
        label={t('library.search')}
        placeholder={t('library.example')}
        leftSection={<IconSearch size={18} aria-hidden />}
        value={typed}
        onChange={(event) => setTyped(event.currentTarget.value)}
      />
      <QueryBoundary of={found} lines={4}>
        {(list) => (
          <>
            <p className="visually-hidden" role="status">
              {t('library.found', { count: list.length })}
            </p>
            {list.length === 0 ? (
              <p className="muted">{words ? t('library.nothing', { words }) : t('library.empty')}</p>
            ) : (
              <ul className="plain-list lines">
                {list.map((one) => (
                  <Entry
                    key={one.id}
                    template={one}
                    exercise={exercises.find((exercise) => exercise.id === one.exercise_id)}
                    onTag={setTyped}
                  />
                ))}
              </ul>
            )}
            <ShowMore of={found} />
          </>
        )}
      </QueryBoundary>
    </section>
  );
}

function Entry({
  template,
  exercise,
  onTag,
}: {
  template: Template;
  exercise: Exercise | undefined;
  onTag: (tag: string) => void;
}) {
  const newest = template.versions[0];
  return (
    <li className="library-entry">
      <div>
        <Link
          className="strong"
          to={`/exercises/${template.exercise_id}${template.retired_at ? '?retired=1' : ''}#template-${template.id}`}
        >
          {template.name}
        </Link>
        {template.retired_at && <span className="tag">{t('library.retired')}</span>}
        <div className="muted small">
          {[
            exercise?.name,
            exercise && t(`exercise.${limbOf(exercise.primary_angle)}.${exercise.side ?? 'right'}`),
            newest && t('library.newest', { number: newest.number, date: date(newest.created_at), by: newest.made_by }),
          ]
            .filter(Boolean)
            .join(' · ')}
        </div>
      </div>
      {template.tags.length > 0 && (
        <div className="library-tags">
          {template.tags.map((tag) => (
            <Button
              key={tag}
              size="compact-md"
              variant="default"
              aria-label={t('library.findTag', { tag })}
              onClick={() => onTag(tag)}
            >
              {tag}
            </Button>
          ))}
        </div>
      )}
    </li>
  );
}
