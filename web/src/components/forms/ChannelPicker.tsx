import { Button, Checkbox, Popover } from '@mantine/core';
import { IconAdjustmentsHorizontal } from '@tabler/icons-react';
import { t } from '../../i18n';
import { channelLabel } from '../../lib/channels';
import './ChannelPicker.css';

const MOST = 8;

/** Which angles are drawn; at most eight, so that each stays readable. */
export function ChannelPicker({
  available,
  value,
  onChange,
  title,
}: {
  available: readonly string[];
  value: readonly string[];
  onChange: (channels: string[]) => void;
  /** Of what is no angle. */
  title?: string;
}) {
  const toggle = (channel: string) => {
    const next = value.includes(channel) ? value.filter((one) => one !== channel) : [...value, channel];
    onChange(available.filter((one) => next.includes(one)));
  };
  return (
    <Popover position="bottom-end" withinPortal trapFocus shadow="md" width={330}>
      <Popover.Target>
        <Button variant="default" size="sm" leftSection={<IconAdjustmentsHorizontal size={18} aria-hidden />}>
          {title ?? t('channels.choose')}
        </Button>
      </Popover.Target>
      <Popover.Dropdown>
        <fieldset className="fieldset picker">
          <legend>{title ?? t('channels.legend', { most: MOST })}</legend>
          {available.map((channel) => (
            <Checkbox
              key={channel}
              label={channelLabel(channel).text}
              checked={value.includes(channel)}
              disabled={!value.includes(channel) && value.length >= MOST}
              onChange={() => toggle(channel)}
            />
          ))}
        </fieldset>
      </Popover.Dropdown>
    </Popover>
  );
}
