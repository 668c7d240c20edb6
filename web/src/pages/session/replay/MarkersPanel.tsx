// Markers of a camera system beside a session's sensors: upload, and how well they fit.
import { Button, FileButton, NumberInput, Select, TextInput } from '@mantine/core';
import { IconDownload, IconFileUpload, IconRoute } from '@tabler/icons-react';
import { useMutation, useQueryClient } from '@tanstack/react-query';
import { useState, type FormEvent } from 'react';
import { Link } from 'react-router';
import { upload } from '../../../api/client';
import { address, key, ofSession } from '../../../api/address';
import { useJob, useMarkers } from '../../../api/queries';
import type { Markers, MarkerReport, MarkerUploadIn, Placement, SessionDetail } from '../../../api/types';
import { LineChart } from '../../../charts/LineChart';
import { Problem } from '../../../components/Feedback';
import { t } from '../../../i18n';
import { placementLabel } from '../../../lib/channels';
import { dateTime, number, pair, spreadAlone } from '../../../lib/format';

const UNITS = ['mm', 'cm', 'm', 'inch'] as const;
const UPS = ['z', 'y', 'x', '-z', '-y', '-x'] as const;
const mm = (metres: number | null | undefined, digits = 1) =>
  number(metres === null || metres === undefined ? null : metres * 1000, digits);
const spreadMm = (metres: number) => spreadAlone(metres * 1000, 1);

function Form({ session }: { session: SessionDetail }) {
  const client = useQueryClient();
  const [file, setFile] = useState<File | null>(null);
  const [segment, setSegment] = useState<string | null>(session.placements[0] ?? null);
  const [marker, setMarker] = useState('');
  const [up, setUp] = useState<(typeof UPS)[number]>('z');
  const [unit, setUnit] = useState<(typeof UNITS)[number]>('mm');
  const [rate, setRate] = useState<number | null>(null);
  const refresh = () => client.invalidateQueries({ queryKey: key('sessions', session.id, 'markers') });
  const send = useMutation({
    mutationFn: (form: FormData) =>
      upload('/api/sessions/{session_id}/markers', ofSession(session.id), form, () => undefined),
    onSuccess: refresh,
  });
  const job = useJob(send.data?.id ?? null, () => void refresh());
  const isCsv = file !== null && !/\.c3d$/i.test(file.name);
  const isBusy = send.isPending || job.data?.status === 'queued' || job.data?.status === 'running';
  const submit = (event: FormEvent) => {
    event.preventDefault();
    if (!file || !segment) return;
    const declaration: MarkerUploadIn = {
      segment: segment as Placement,
      format: isCsv ? 'csv' : 'c3d',
      marker: marker.trim() || null,
      cluster: [],
      up,
      unit,
      rate_hz: isCsv ? rate : null,
      delimiter: ',',
    };
    const form = new FormData();
    form.set('declaration', JSON.stringify(declaration));
    form.set('file', file);
    send.mutate(form);
  };
  return (
    <form className="stack" onSubmit={submit}>
      <FileButton onChange={setFile} accept=".c3d,.csv,text/csv,application/octet-stream">
        {(props) => (
          <Button variant="default" leftSection={<IconFileUpload size={18} aria-hidden />} {...props}>
            {file ? t('markers.other', { name: file.name }) : t('markers.choose')}
          </Button>
        )}
      </FileButton>
      <Select
        label={t('markers.segment')}
        data={session.placements.map((one) => ({ value: one, label: placementLabel(one) }))}
        value={segment}
        onChange={setSegment}
        allowDeselect={false}
      />
      <TextInput
        label={t('markers.marker')}
        description={t('markers.markerHelp')}
        value={marker}
        onChange={(event) => setMarker(event.currentTarget.value)}
        maxLength={100}
      />
      <Select
        label={t('markers.up')}
        data={[...UPS]}
        value={up}
        onChange={(value) => setUp((value ?? 'z') as (typeof UPS)[number])}
        allowDeselect={false}
      />
      {isCsv && (
        <>
          <Select
            label={t('markers.unit')}
            data={[...UNITS]}
            value={unit}
            onChange={(value) => setUnit((value ?? 'mm') as (typeof UNITS)[number])}
            allowDeselect={false}
          />
          <NumberInput
            label={t('markers.rate')}
            description={t('markers.rateHelp')}
            value={rate ?? ''}
            min={1}
            max={10000}
            onChange={(value) => setRate(typeof value === 'number' ? value : null)}
          />
        </>
      )}
      <Button type="submit" disabled={!file || !segment} loading={isBusy}>
        {t('markers.send')}
      </Button>
      {send.error && <Problem error={send.error} />}
    </form>
  );
}

function Report({ report }: { report: MarkerReport }) {
  const { curves } = report;
  const [offset, offsetSpread] = pair(report.offset_s * 1000, report.offset_sigma_s * 1000, 1);
  const [drift, driftSpread] = pair(report.drift_ppm, report.drift_sigma_ppm, 0);
  const longest = report.gaps.reduce(
    (most, gap) => (gap.length_s > most.length_s ? gap : most),
    report.gaps[0] ?? { length_s: 0, sigma_m: 0, start_s: 0, withheld: false },
  );
  const withheld = report.gaps.filter((gap) => gap.withheld).length;
  const largest = Math.max(0, ...curves.residual_m.map((value) => value ?? 0));
  const inMm = (values: readonly (number | null)[]) => values.map((value) => (value === null ? null : value * 1000));
  return (
    <>
      <dl className="facts">
        <dt>{t('markers.offset')}</dt>
        <dd>{t('markers.offsetText', { offset, sigma: offsetSpread, drift, driftSigma: driftSpread })}</dd>
        <dt>{t('markers.correlation')}</dt>
        <dd>
          {t('markers.correlationText', {
            correlation: number(report.correlation, 3),
            overlap: number(report.overlap_s),
            rival: number(report.rival, 2),
          })}
        </dd>
        <dt>{t('markers.lever')}</dt>
        <dd>
          {report.lever_arm_m
            .map((one, axis) => pair(one * 1000, (report.lever_arm_sigma_m[axis] ?? NaN) * 1000, 1).join(' ± '))
            .join(' / ')}{' '}
          mm
        </dd>
        <dt>{t('markers.residual')}</dt>
        <dd>{report.residual_rms_m.map((one) => mm(one, 2)).join(' / ')} mm</dd>
        <dt>{t('markers.frames')}</dt>
        <dd>
          {t('markers.framesText', {
            used: number(report.used_count),
            count: number(report.frame_count),
            rejected: number(report.rejected_count),
          })}
        </dd>
        <dt>{t('markers.gaps')}</dt>
        <dd>
          {report.gap_count === 0
            ? t('markers.gapsNone')
            : t('markers.gapsText', {
                count: number(report.gap_count),
                length: number(longest.length_s, 2),
                sigma: spreadMm(longest.sigma_m),
              })}
        </dd>
      </dl>
      {withheld > 0 && <p className="alert-text">{t('markers.withheld', { count: number(withheld) })}</p>}
      <LineChart
        lines={[
          { name: t('markers.curve.residual'), x: curves.time_s, y: inMm(curves.residual_m) },
          { name: t('markers.curve.sigma'), x: curves.time_s, y: inMm(curves.sigma_m) },
        ]}
        xTitle={t('markers.time')}
        yTitle={t('markers.millimetres')}
        label={t('markers.plotLabel', { largest: mm(largest) })}
        height={200}
      />
      {report.checks.length > 0 && (
        <table className="plain-table">
          <caption>{t('markers.checks')}</caption>
          <thead>
            <tr>
              <th scope="col">{t('markers.check.length')}</th>
              <th scope="col">{t('markers.check.count')}</th>
              <th scope="col">{t('markers.check.inertial')}</th>
              <th scope="col">{t('markers.check.spline')}</th>
            </tr>
          </thead>
          <tbody>
            {report.checks.map((check) => (
              <tr key={check.length_s}>
                <th scope="row">{number(check.length_s, 1)} s</th>
                <td>{number(check.count)}</td>
                <td>{mm(check.inertial_m)} mm</td>
                <td>{mm(check.spline_m)} mm</td>
              </tr>
            ))}
          </tbody>
        </table>
      )}
      {report.reasons.map((reason) => (
        <p key={reason} className="muted small">
          {reason}
        </p>
      ))}
    </>
  );
}

function Entry({ found }: { found: Markers }) {
  const name = t('markers.of', {
    marker: found.report?.marker ?? found.format.toUpperCase(),
    segment: placementLabel(found.segment),
  });
  return (
    <section className="stack">
      <h4>
        {name} <span className="muted small">{found.uploaded_at ? dateTime(found.uploaded_at) : ''}</span>
      </h4>
      {found.status === 'failed' && (
        <p className="alert-text">
          {t('markers.failed')} {found.message}
        </p>
      )}
      {(found.status === 'queued' || found.status === 'running') && <p className="muted">{t('markers.waiting')}</p>}
      {found.report && <Report report={found.report} />}
      {found.report && (
        <Button
          component={Link}
          to={`/sessions/${found.session_id}?show=markers&markers=${found.id}`}
          leftSection={<IconRoute size={18} aria-hidden />}
        >
          {t('markers.show')}
        </Button>
      )}
      {found.report && (
        <Button
          component="a"
          href={address('/api/sessions/{session_id}/markers/motion', {
            ...ofSession(found.session_id),
            query: { markers_id: found.id },
          })}
          download
          variant="default"
          leftSection={<IconDownload size={18} aria-hidden />}
        >
          {t('markers.download')}
        </Button>
      )}
    </section>
  );
}

export function MarkersPanel({ session }: { session: SessionDetail }) {
  const markers = useMarkers(session.id);
  return (
    <section className="stack" aria-labelledby="markers-title">
      <h3 id="markers-title">{t('markers.title')}</h3>
      <p className="muted small">{t('markers.lead')}</p>
      {session.may_treat && session.state === 'analysed' && <Form session={session} />}
      {markers.error && <Problem error={markers.error} />}
      {markers.data?.length === 0 && <p className="muted">{t('markers.none')}</p>}
      {markers.data?.map((found) => (
        <Entry key={found.id} found={found} />
      ))}
    </section>
  );
}
