// The buttons that turn the 3D view.
import { ActionIcon, SegmentedControl } from '@mantine/core';
import { IconRotate, IconRotateClockwise, IconZoomIn, IconZoomOut } from '@tabler/icons-react';
import { useState } from 'react';
import type { CameraCommand } from '../api/types';
import { t } from '../i18n';
import type { ViewLink } from '../player/view';
import './CameraBar.css';

/** The part of the body that the camera comes near to. */
export type Near = 'arm' | 'leg' | 'feet' | 'marker' | 'modules';
export type Preset = NonNullable<CameraCommand['preset']>;

const PRESETS = ['start', 'front', 'side', 'top', 'arm'] as const;
const TURN_DEG = 20;
const ZOOM = 1.25;

/** Everything that dragging does, as buttons. */
export default function CameraBar({ link, near }: { link: ViewLink | null; near: Near }) {
  const [preset, setPreset] = useState<Preset | ''>('');
  const move = (command: Parameters<ViewLink['camera']>[0]) => {
    setPreset('');
    link?.camera(command);
  };
  const buttons = [
    { label: t('camera.left'), Icon: IconRotate, command: { turn_deg: -TURN_DEG } },
    { label: t('camera.right'), Icon: IconRotateClockwise, command: { turn_deg: TURN_DEG } },
    { label: t('camera.nearer'), Icon: IconZoomIn, command: { zoom: ZOOM } },
    { label: t('camera.further'), Icon: IconZoomOut, command: { zoom: 1 / ZOOM } },
  ];
  return (
    <div className="camera-bar" role="group" aria-label={t('camera.title')}>
      <SegmentedControl
        size="sm"
        aria-label={t('camera.from')}
        value={preset}
        onChange={(value) => {
          setPreset(value as Preset);
          link?.camera({ preset: value as Preset });
        }}
        data={PRESETS.map((value) => ({ value, label: t(`camera.${value === 'arm' ? near : value}`) }))}
      />
      <span className="camera-buttons">
        {buttons.map(({ label, Icon, command }) => (
          <ActionIcon key={label} size={36} color="gray" aria-label={label} title={label} onClick={() => move(command)}>
            <Icon size={20} aria-hidden />
          </ActionIcon>
        ))}
      </span>
    </div>
  );
}
