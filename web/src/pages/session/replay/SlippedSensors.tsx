// Sensors that turned in their strap, with the moment and what not to read after it: above the picture, which shows it.
import { IconAlertTriangle } from '@tabler/icons-react';
import type { SessionDetail } from '../../../api/types';
import { Notice } from '../../../components/Feedback';
import { eventText } from '../../../lib/events';

export function SlippedSensors({ session }: { session: SessionDetail }) {
  const slipped = session.events.filter((event) => event.kind === 'sensor_slipped');
  return slipped.map((event) => (
    <Notice key={event.time_s} icon={<IconAlertTriangle size={22} aria-hidden />}>
      <p>{eventText(event)}</p>
    </Notice>
  ));
}
