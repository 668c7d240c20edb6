// The file of an upload: where it is dropped, and what it was recognised as.
import { Button, FileButton } from '@mantine/core';
import { IconCircleCheck, IconFileUpload } from '@tabler/icons-react';
import { useState, type DragEvent } from 'react';
import type { Format } from '../../api/types';
import { RadioCards } from '../../components/forms/Choice';
import { t } from '../../i18n';
import { bytes } from '../../lib/format';
import './FilePart.css';

/** Where the file is dropped or chosen. */
export function FileDrop({
  file,
  formats,
  onFile,
}: {
  file: File | null;
  formats: readonly Format[];
  onFile: (file: File) => void;
}) {
  const [isOver, setOver] = useState(false);
  const drop = (event: DragEvent) => {
    event.preventDefault();
    setOver(false);
    const dropped = event.dataTransfer.files[0];
    if (dropped) onFile(dropped);
  };
  return (
    <div
      className={isOver ? 'drop drop-over' : 'drop'}
      role="group"
      aria-label={t('upload.file')}
      onDragOver={(event) => {
        event.preventDefault();
        setOver(true);
      }}
      onDragLeave={() => setOver(false)}
      onDrop={drop}
    >
      <IconFileUpload size={40} aria-hidden />
      {file ? (
        <p>
          <span className="strong">{file.name}</span> <span className="muted number">({bytes(file.size)})</span>
        </p>
      ) : (
        <p>{t('upload.drop')}</p>
      )}
      <FileButton
        onChange={(picked) => picked && onFile(picked)}
        accept={[...new Set(formats.flatMap((one) => one.endings)), 'application/octet-stream', 'text/csv'].join(',')}
      >
        {(props) => (
          <Button variant={file ? 'default' : 'filled'} {...props}>
            {file ? t('upload.other') : t('upload.choose')}
          </Button>
        )}
      </FileButton>
    </div>
  );
}

/** What the file holds: one line where it is recognised (null: by the service, once it is sent), else all choices. */
export function FormatChoice({
  value,
  formats,
  isRecognised,
  onChange,
}: {
  value: Format | null;
  formats: readonly Format[];
  isRecognised: boolean;
  onChange: (name: string) => void;
}) {
  const [isOpen, setOpen] = useState(false);
  if (isRecognised && !isOpen) {
    return (
      <div className="recognised">
        <IconCircleCheck size={22} aria-hidden />
        <p>
          {value ? (
            <>
              <span className="muted">{t('upload.recognised')}</span> <span className="strong">{value.title}</span>
            </>
          ) : (
            t('upload.recognisedLater')
          )}
        </p>
        <Button variant="subtle" size="compact-md" onClick={() => setOpen(true)}>
          {t(value ? 'upload.otherFormat' : 'upload.chooseFormat')}
        </Button>
      </div>
    );
  }
  return (
    <RadioCards
      legend={t('upload.format')}
      value={value?.name ?? ''}
      onChange={onChange}
      options={formats.map((one) => ({ value: one.name, title: one.title, text: one.description }))}
    />
  );
}
