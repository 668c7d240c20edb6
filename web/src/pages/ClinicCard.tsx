// The clinic's time zone: administrators choose it, the weeks of exercises begin there.
import { Select } from '@mantine/core';
import { useChangeClinic } from '../api/changes';
import { useClinic } from '../api/queries';
import { QueryBoundary, Problem } from '../components/Feedback';
import { t } from '../i18n';

/** Names of places as the browser knows them, with those that must be there in any case. */
export function timeZones(...needed: string[]): string[] {
  return [...new Set([...needed, 'UTC', ...Intl.supportedValuesOf('timeZone')])].sort();
}

export function ClinicCard() {
  const clinic = useClinic();
  const change = useChangeClinic();
  return (
    <section className="card stack" aria-labelledby="clinic-zone">
      <h2 id="clinic-zone">{t('clinic.settings')}</h2>
      <QueryBoundary of={clinic} lines={2}>
        {(found) => (
          <Select
            label={t('clinic.zone')}
            description={t('clinic.zoneHelp')}
            searchable
            maw={420}
            allowDeselect={false}
            limit={300}
            data={timeZones(found.time_zone).map((name) => ({ value: name, label: name.replaceAll('_', ' ') }))}
            value={found.time_zone}
            disabled={change.isPending}
            onChange={(zone) => zone && change.mutate({ time_zone: zone })}
          />
        )}
      </QueryBoundary>
      {change.error ? (
        <Problem error={change.error} />
      ) : change.data ? (
        <p role="status">{t('clinic.zoneSaved')}</p>
      ) : (
        clinic.data && !clinic.data.is_time_zone_set && <p className="muted small">{t('clinic.zoneNotSet')}</p>
      )}
    </section>
  );
}
