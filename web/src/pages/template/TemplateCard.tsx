// One template of an exercise: its curves with the band, its versions with who, when and why, and what can be done with it.
import { Button, Group, Modal, Select, TagsInput, Textarea, TextInput } from '@mantine/core';
import { useDisclosure } from '@mantine/hooks';
import { IconArchive, IconFlipVertical, IconPencil, IconRestore, IconTags } from '@tabler/icons-react';
import { useState, type FormEvent } from 'react';
import { Link, useNavigate } from 'react-router';
import { useChangeTemplate, useCopyVersion } from '../../api/changes';
import { useTemplateVersion } from '../../api/queries';
import type { Template, TemplateVersion, TemplateVersionDetail } from '../../api/types';
import { PhaseChart, PhaseLegend } from '../../charts/PhaseChart';
import { QueryBoundary, Notice, Problem } from '../../components/Feedback';
import { t } from '../../i18n';
import { pickCurves } from '../../lib/assessment/comparison';
import { date, number } from '../../lib/format';
import { limbOf } from '../../lib/placements';
import '../../styles/design.css';
import './template.css';

const MOST_TAGS = 20;

export function TemplateCard({
  template,
  wanted,
  primary,
}: {
  template: Template;
  wanted: string | null;
  primary: string | null;
}) {
  const [picked, setPicked] = useState<string | null>(null);
  const versionId =
    picked ?? template.versions.find((one) => one.id === wanted)?.id ?? template.versions[0]?.id ?? null;
  const version = useTemplateVersion(versionId);
  return (
    <section className="card" aria-label={template.name} id={`template-${template.id}`}>
      <div className="card-head">
        <h2>{template.name}</h2>
        <span className="tag">{template.patient_id ? t('template.onePatient') : t('template.wholeClinic')}</span>
        {template.retired_at && <span className="tag">{t('library.retired')}</span>}
        {template.tags.map((tag) => (
          <span key={tag} className="tag">
            {tag}
          </span>
        ))}
        {template.versions.length > 1 && (
          <Select
            className="end"
            size="sm"
            w={230}
            aria-label={t('template.versionLabel')}
            data={template.versions.map((one) => ({
              value: one.id,
              label: t('template.versionOf', { number: one.number, date: date(one.created_at) }),
            }))}
            value={versionId}
            onChange={setPicked}
          />
        )}
      </div>
      <QueryBoundary of={version} lines={4} height={40}>
        {(found) => (
          <>
            <Deeds template={template} version={found} />
            <p className="muted small">
              {t('template.made', {
                number: found.number,
                date: date(found.created_at),
                count: found.repetition_count,
                seconds: number(found.content.duration_s, 1),
              })}
            </p>
            {(found.troubles ?? []).map((one) => (
              <Notice key={one}>{one}</Notice>
            ))}
            <PhaseLegend withOutside={false} patient={false} />
            <div className="template-curves">
              {pickCurves(found.content.curves, false, primary || found.primary_channel, (channel) =>
                Number(isDrawn(found, channel)),
              ).map((curve) => (
                <div key={curve.channel} className="template-curve">
                  <h3>{curve.label}</h3>
                  <PhaseChart
                    curve={curve}
                    phases={found.content.phases}
                    left={new Set(found.content.repetitions.flatMap((one, index) => (one.is_kept ? [] : [index])))}
                    height={200}
                  />
                </div>
              ))}
            </div>
          </>
        )}
      </QueryBoundary>
      <History versions={template.versions} />
    </section>
  );
}

/** Whether the therapist drew a band of its own on a curve: those are shown first, after the main one. */
function isDrawn(version: TemplateVersionDetail, channel: string): boolean {
  return (version.design.tolerances ?? []).some((one) => one.channel === channel);
}

function History({ versions }: { versions: readonly TemplateVersion[] }) {
  return (
    <details className="history">
      <summary>{t('library.history', { count: versions.length })}</summary>
      <ol className="plain-list lines" reversed>
        {versions.map((one) => (
          <li key={one.id}>
            <span className="strong">
              {t('template.versionOf', { number: one.number, date: date(one.created_at) })}
            </span>{' '}
            · {one.made_by}
            <div className="small">{one.reason || t('library.recorded', { count: one.repetition_count })}</div>
          </li>
        ))}
      </ol>
    </details>
  );
}

function Deeds({ template, version }: { template: Template; version: TemplateVersionDetail }) {
  const change = useChangeTemplate(template.id);
  const [entry, entryDialog] = useDisclosure(false);
  const [copy, copyDialog] = useDisclosure(false);
  const isRetired = template.retired_at !== null;
  return (
    <>
      <Group gap={8} mb={8}>
        <Button
          component={Link}
          to={`/templates/versions/${version.id}`}
          leftSection={<IconPencil size={18} aria-hidden />}
        >
          {t('design.open')}
        </Button>
        <Button variant="default" leftSection={<IconFlipVertical size={18} aria-hidden />} onClick={copyDialog.open}>
          {t('library.mirror')}
        </Button>
        <Button variant="default" leftSection={<IconTags size={18} aria-hidden />} onClick={entryDialog.open}>
          {t('library.entry')}
        </Button>
        <Button
          variant="default"
          leftSection={isRetired ? <IconRestore size={18} aria-hidden /> : <IconArchive size={18} aria-hidden />}
          loading={change.isPending}
          onClick={() => change.mutate({ is_retired: !isRetired })}
        >
          {t(isRetired ? 'library.restore' : 'library.retire')}
        </Button>
      </Group>
      {isRetired && <p className="small muted">{t('library.retiredText')}</p>}
      {change.error && <Problem error={change.error} />}
      <Modal
        opened={entry}
        onClose={entryDialog.close}
        title={t('library.entry')}
        closeButtonProps={{ 'aria-label': t('action.close') }}
      >
        {entry && <EntryForm template={template} onDone={entryDialog.close} />}
      </Modal>
      <Modal
        opened={copy}
        onClose={copyDialog.close}
        title={t('library.mirror')}
        closeButtonProps={{ 'aria-label': t('action.close') }}
      >
        {copy && <MirrorForm template={template} version={version} onCancel={copyDialog.close} />}
      </Modal>
    </>
  );
}

function EntryForm({ template, onDone }: { template: Template; onDone: () => void }) {
  const change = useChangeTemplate(template.id);
  const [name, setName] = useState(template.name);
  const [tags, setTags] = useState<string[]>(template.tags);
  const submit = (event: FormEvent) => {
    event.preventDefault();
    change.mutate({ name: name.trim(), tags }, { onSuccess: onDone });
  };
  return (
    <form className="stack" onSubmit={submit}>
      {change.error && <Problem error={change.error} />}
      <TextInput
        label={t('template.name')}
        required
        withAsterisk={false}
        maxLength={200}
        value={name}
        onChange={(event) => setName(event.currentTarget.value)}
        data-autofocus
      />
      <TagsInput
        label={t('library.tags')}
        description={t('library.tagsHelp')}
        maxTags={MOST_TAGS}
        value={tags}
        onChange={setTags}
      />
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

function MirrorForm({
  template,
  version,
  onCancel,
}: {
  template: Template;
  version: TemplateVersionDetail;
  onCancel: () => void;
}) {
  const navigate = useNavigate();
  const copy = useCopyVersion(version.id);
  const other = version.side === 'left' ? 'right' : 'left';
  const [name, setName] = useState(t('library.mirroredName', { name: template.name, side: t(`side.${other}`) }));
  const [reason, setReason] = useState('');
  const submit = (event: FormEvent) => {
    event.preventDefault();
    copy.mutate(
      { patient_id: template.patient_id, name: name.trim(), reason: reason.trim() },
      {
        onSuccess: (made) =>
          void navigate(
            `/exercises/${made.exercise_id}?version=${made.id}${made.patient_id ? `&patient=${made.patient_id}` : ''}`,
          ),
      },
    );
  };
  return (
    <form className="stack" onSubmit={submit}>
      <p className="muted">
        {t('library.mirrorText', { side: t(`exercise.${limbOf(version.primary_channel)}.${other}`) })}
      </p>
      {copy.error && <Problem error={copy.error} />}
      <TextInput
        label={t('template.name')}
        required
        withAsterisk={false}
        maxLength={200}
        value={name}
        onChange={(event) => setName(event.currentTarget.value)}
      />
      <Textarea
        label={t('design.reason')}
        autosize
        minRows={2}
        maxLength={500}
        value={reason}
        onChange={(event) => setReason(event.currentTarget.value)}
        data-autofocus
      />
      <Group justify="flex-end">
        <Button variant="default" onClick={onCancel}>
          {t('action.cancel')}
        </Button>
        <Button type="submit" disabled={!reason.trim() || !name.trim()} loading={copy.isPending}>
          {t('library.mirror')}
        </Button>
      </Group>
    </form>
  );
}
