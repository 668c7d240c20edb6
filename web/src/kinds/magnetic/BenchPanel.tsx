// A bench session: where the sensor lay is typed stop by stop, and the coils of the source are found from it.
import { Button, Group, NumberInput, TextInput } from '@mantine/core';
import { useState, type FormEvent } from 'react';
import { useCalibrateSource } from '../../api/changes';
import { useSourceStops } from '../../api/queries';
import type { SourceStops } from '../../api/types';
import { QueryBoundary, Notice, Problem } from '../../components/Feedback';
import { t } from '../../i18n';
import { number, spreadAlone } from '../../lib/format';
import { placesOf, type Place } from './magneticSetup';

const AXES = ['x', 'y', 'z'] as const;

function Form({ sessionId, found }: { sessionId: string; found: SourceStops }) {
  const calibrate = useCalibrateSource(sessionId);
  const [places, setPlaces] = useState<Place[]>(() => found.stops.map(() => [null, null, null]));
  const [name, setName] = useState('');
  const [serial, setSerial] = useState('');
  const [rulerMm, setRuler] = useState(1);
  const typed = placesOf(places);
  const submit = (event: FormEvent) => {
    event.preventDefault();
    if (typed)
      calibrate.mutate({ name: name.trim(), serial: serial.trim(), positions_m: typed, place_sigma_m: rulerMm / 1000 });
  };
  if (found.stops.length === 0) return <p>{t('sources.noStops')}</p>;
  return (
    <form className="stack" onSubmit={submit}>
      <ol className="plain-list lines">
        {found.stops.map((stop, row) => (
          <li key={stop.start_s}>
            <span className="strong">
              {t('sources.stop', { number: row + 1, from: number(stop.start_s, 0), to: number(stop.end_s, 0) })}
            </span>{' '}
            <span className="muted small">
              {stop.position_m &&
                t('sources.about', { place: stop.position_m.map((value) => number(100 * value, 0)).join(' / ') })}
            </span>
            <div className="parameter-grid">
              {AXES.map((axis, column) => (
                <NumberInput
                  key={axis}
                  aria-label={t('sources.axis', { axis, number: row + 1 })}
                  placeholder={axis}
                  value={places[row]?.[column] ?? ''}
                  onChange={(value) =>
                    setPlaces((all) =>
                      all.map((one, index) =>
                        index === row
                          ? (one.map((old, at) =>
                              at === column ? (typeof value === 'number' ? value : null) : old,
                            ) as Place)
                          : one,
                      ),
                    )
                  }
                  decimalScale={2}
                  hideControls
                />
              ))}
            </div>
          </li>
        ))}
      </ol>
      <div className="parameter-grid">
        <TextInput
          label={t('sources.name')}
          required
          withAsterisk={false}
          maxLength={100}
          value={name}
          onChange={(event) => setName(event.currentTarget.value)}
        />
        <TextInput
          label={t('sources.serial')}
          required
          withAsterisk={false}
          maxLength={100}
          value={serial}
          onChange={(event) => setSerial(event.currentTarget.value)}
        />
        <NumberInput
          label={t('sources.ruler')}
          value={rulerMm}
          onChange={(value) => setRuler(typeof value === 'number' && value > 0 ? value : 1)}
          min={0.1}
          max={20}
          decimalScale={1}
          hideControls
        />
      </div>
      {calibrate.error && <Problem error={calibrate.error} />}
      {calibrate.data && (
        <Notice>
          {t('sources.saved', {
            name: calibrate.data.name,
            gain: spreadAlone(100 * calibrate.data.gain_sigma, 1),
            off: number(1000 * (calibrate.data.found.place_residual_m ?? 0), 1),
          })}
        </Notice>
      )}
      <Group justify="flex-end">
        <Button type="submit" disabled={typed === null} loading={calibrate.isPending}>
          {t('sources.keep')}
        </Button>
      </Group>
    </form>
  );
}

export function BenchPanel({ sessionId }: { sessionId: string }) {
  const [isOpen, setOpen] = useState(false);
  const stops = useSourceStops(sessionId, isOpen);
  return (
    <details className="as-table">
      <summary>{t('sources.calibrate')}</summary>
      <p className="muted small">{t('sources.calibrateHelp')}</p>
      {isOpen ? (
        <QueryBoundary of={stops} lines={4}>
          {(found) => <Form sessionId={sessionId} found={found} />}
        </QueryBoundary>
      ) : (
        <Button variant="default" onClick={() => setOpen(true)}>
          {t('sources.find')}
        </Button>
      )}
    </details>
  );
}
