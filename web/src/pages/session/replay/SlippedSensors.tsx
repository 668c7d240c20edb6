// Sensors that turned in their strap, with the moment and what not to read after it, and calibrations that the movements
// contradict: above the picture, which shows it.
import { IconAlertTriangle } from '@tabler/icons-react';
import type { SessionDetail } from '../../../api/types';
import { Notice } from '../../../components/Feedback';
import { eventText, isAboutSensors } from '../../../lib/events';

export function SlippedSensors({ session }: { session: SessionDetail }) {
  return session.events.filter(isAboutSensors).map((event) => (
    <Notice key={`${event.kind} ${event.time_s} ${event.text}`} icon={<IconAlertTriangle size={22} aria-hidden />}>
      <p>{eventText(event)}</p>
    </Notice>
  ));
}
