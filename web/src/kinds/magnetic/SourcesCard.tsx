// The magnetic sources of the clinic: measured, taken from a file, no longer offered.
import { FileButton, Button, Group } from '@mantine/core';
import { IconFileImport } from '@tabler/icons-react';
import { useState } from 'react';
import { useKeepSource, useRetireSource } from '../../api/changes';
import { useMagneticSources } from '../../api/queries';
import type { MagneticSource, MagneticSourceIn } from '../../api/types';
import { Confirm } from '../../components/forms/Confirm';
import { QueryBoundary, Problem } from '../../components/Feedback';
import { t } from '../../i18n';
import { day, spreadAlone } from '../../lib/format';

function Line({ source }: { source: MagneticSource }) {
  const retire = useRetireSource();
  return (
    <li>
      <Group justify="space-between" wrap="wrap" gap="xs">
        <div>
          <span className="strong">{source.name}</span>
          <div className="muted small">
            {t('sources.line', {
              serial: source.serial,
              gain: spreadAlone(100 * source.gain_sigma, 1),
              method: t(`sources.method.${source.method}`),
              day: day(source.calibrated_at),
            })}
          </div>
        </div>
        <Confirm
          label={t('sources.retire')}
          accessibleLabel={`${t('sources.retire')}: ${source.name}`}
          title={t('sources.retireTitle')}
          text={t('sources.retireText', { name: source.name })}
          confirm={t('sources.retire')}
          onConfirm={() => retire.mutate(source.id)}
        />
      </Group>
      {retire.error && <Problem error={retire.error} />}
    </li>
  );
}

const textOf = (file: File) =>
  new Promise<string>((resolve, reject) => {
    const reader = new FileReader();
    reader.onload = () => resolve(String(reader.result));
    reader.onerror = () => reject(reader.error ?? new Error());
    reader.readAsText(file);
  });

export function SourcesCard() {
  const sources = useMagneticSources(true);
  const keep = useKeepSource();
  const [isWrong, setWrong] = useState(false);
  const take = async (file: File | null) => {
    if (!file) return;
    setWrong(false);
    try {
      const found: unknown = JSON.parse(await textOf(file));
      if (typeof found !== 'object' || found === null || !('coils' in found)) throw new Error();
      keep.mutate(found as MagneticSourceIn);
    } catch {
      setWrong(true);
    }
  };
  return (
    <section className="card stack" aria-labelledby="magnetic-sources">
      <div className="card-head">
        <h2 id="magnetic-sources">{t('sources.title')}</h2>
        <FileButton onChange={(file) => void take(file)} accept="application/json,.json">
          {(props) => (
            <Button
              {...props}
              className="end"
              variant="default"
              size="sm"
              leftSection={<IconFileImport size={17} aria-hidden />}
              loading={keep.isPending}
            >
              {t('sources.import')}
            </Button>
          )}
        </FileButton>
      </div>
      <p className="muted small">
        {t('sources.lead')} {t('sources.importHelp')}
      </p>
      {isWrong && (
        <p className="alert-text" role="alert">
          {t('sources.notJson')}
        </p>
      )}
      {keep.error && <Problem error={keep.error} />}
      <QueryBoundary of={sources} lines={2}>
        {(list) =>
          list.length === 0 ? (
            <p>{t('sources.none')}</p>
          ) : (
            <ul className="plain-list lines">
              {list.map((one) => (
                <Line key={one.id} source={one} />
              ))}
            </ul>
          )
        }
      </QueryBoundary>
    </section>
  );
}
