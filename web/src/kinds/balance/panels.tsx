// Balance tests: what the therapist marks while it is recorded, lean and sway now, and the tests side by side.
import { Button, Group } from '@mantine/core';
import { useMutation, useQuery } from '@tanstack/react-query';
import { useEffect, useState } from 'react';
import { ofSession } from '../../api/address';
import { byHand } from '../../api/client';
import measures from '../../api/measures.json';
import { question } from '../../api/queries';
import type { Named } from '../../api/types';
import { QueryBoundary, Notice, Problem } from '../../components/Feedback';
import { t, tOr } from '../../i18n';
import { placementLabel } from '../../lib/channels';
import { number, position, quantity } from '../../lib/format';
import type { KindPanels, LiveProps, ReplayProps } from '../kind';
import { levelled, measureText, readLean, rootMeanSquare, type LeanNow } from './sway';

type Balance = Named<'BalanceTestOut'>;
type Trial = Balance['trials'][number];
type Condition = Trial['condition'];

const CONDITIONS = ['eyes_open_firm', 'eyes_closed_firm', 'eyes_open_foam', 'eyes_closed_foam', 'reach'] as const;
const QUIET_S = 30;
const REFRESH_MS = 250;
const { main: MAIN, more: REST } = measures.sway;
const label = (name: string) => tOr(`stand.measure.${name}`, name.replaceAll('_', ' '));

function Tests({ session, isRecording, mayRecord }: LiveProps) {
  const [running, setRunning] = useState<{ condition: (typeof CONDITIONS)[number]; sinceMs: number } | null>(null);
  const [done, setDone] = useState<Partial<Record<Condition, number>>>({});
  const [nowMs, setNowMs] = useState(0);
  const mark = useMutation({
    mutationFn: (label: string) =>
      byHand.post('/api/sessions/{session_id}/mark', { ...ofSession(session.id), body: { label } }),
    onSuccess: (_, label) => {
      if (running) setDone((before) => ({ ...before, [running.condition]: (before[running.condition] ?? 0) + 1 }));
      const started = CONDITIONS.find((one) => one === label);
      setNowMs(performance.now());
      setRunning(started ? { condition: started, sinceMs: performance.now() } : null);
    },
  });
  useEffect(() => {
    if (!running) return;
    const timer = setInterval(() => setNowMs(performance.now()), REFRESH_MS);
    return () => clearInterval(timer);
  }, [running]);
  const elapsedS = running ? Math.max(0, (nowMs - running.sinceMs) / 1000) : 0;
  return (
    <section className="card stack" aria-labelledby="tests">
      <h2 id="tests">{t('stand.tests')}</h2>
      <p>{isRecording ? t('stand.help') : t('stand.first')}</p>
      {mark.error && <Problem error={mark.error} />}
      {running ? (
        <>
          <p className="figure-large" role="status" style={{ fontSize: '1.5rem', fontWeight: 650 }}>
            {t('stand.running', { condition: t(`stand.condition.${running.condition}`), time: position(elapsedS, 0) })}
          </p>
          {running.condition !== 'reach' && elapsedS >= QUIET_S && (
            <p className="strong" role="status">
              {t('stand.enough')}
            </p>
          )}
          <Group>
            <Button size="lg" onClick={() => mark.mutate('rest')} loading={mark.isPending} disabled={!mayRecord}>
              {t('stand.end')}
            </Button>
          </Group>
        </>
      ) : (
        <Group>
          {CONDITIONS.map((condition) => (
            <Button
              key={condition}
              size="lg"
              variant="default"
              disabled={!isRecording || !mayRecord}
              loading={mark.isPending && mark.variables === condition}
              onClick={() => mark.mutate(condition)}
            >
              {t(`stand.condition.${condition}`)}
              {done[condition] ? ` · ${t('stand.done', { count: done[condition] })}` : ''}
            </Button>
          ))}
        </Group>
      )}
    </section>
  );
}

function Now({ session, player }: LiveProps) {
  const [now, setNow] = useState<LeanNow | null>(null);
  const place = session.placements.includes('pelvis') ? 'pelvis' : 'sternum';
  useEffect(() => {
    const timer = setInterval(() => setNow(readLean(player, place)), REFRESH_MS);
    return () => clearInterval(timer);
  }, [player, place]);
  if (!now) return null;
  return (
    <section className="card" aria-labelledby="lean-now">
      <div className="card-head">
        <h2 id="lean-now">{t('stand.now')}</h2>
        <span className="muted small">{t('stand.sensor', { place: placementLabel(place) })}</span>
      </div>
      <dl className="facts">
        <dt>{t('stand.forward')}</dt>
        <dd className="number" data-testid="lean-forward">
          {number((now.forward.at(-1) ?? NaN) * DEGREES, 1)}°
        </dd>
        <dt>{t('stand.left')}</dt>
        <dd className="number">{number((now.left.at(-1) ?? NaN) * DEGREES, 1)}°</dd>
        <dt>{t('stand.sway')}</dt>
        <dd className="number" data-testid="sway-now">
          {quantity(rootMeanSquare(levelled(now)), 'm/s²')}
        </dd>
      </dl>
      <Way
        path={now.forward.map((one, index) => [one * DEGREES, (now.left[index] ?? 0) * DEGREES])}
        ellipse={null}
        half={10}
        label={t('stand.picture')}
        scale="10°"
      />
    </section>
  );
}

const DEGREES = 180 / Math.PI;

interface WayProps {
  /** Forward and left. */
  path: readonly (readonly number[])[];
  ellipse: Trial['ellipse'];
  /** Half the width of the picture, in the unit of the path. */
  half: number;
  label: string;
  /** What the outer ring is. */
  scale: string;
}

/** A way over the floor seen from above: forward is up, left is left. */
function Way({ path, ellipse, half, label, scale }: WayProps) {
  const points = path.map(([ahead = 0, left = 0]) => `${(-left).toFixed(4)},${(-ahead).toFixed(4)}`).join(' ');
  const newest = path.at(-1);
  const line = half / 120;
  return (
    <svg
      viewBox={`${-1.25 * half} ${-1.25 * half} ${2.5 * half} ${2.5 * half}`}
      role="img"
      aria-label={label}
      style={{ width: '100%', maxWidth: 260, display: 'block', margin: '0 auto' }}
    >
      {[0.5, 1].map((share) => (
        <circle key={share} r={share * half} fill="none" stroke="var(--tm-line)" strokeWidth={line} />
      ))}
      <path d={`M${-half} 0H${half}M0 ${-half}V${half}`} stroke="var(--tm-line)" strokeWidth={line} />
      <polyline points={points} fill="none" stroke="var(--tm-series-1)" strokeWidth={1.5 * line} />
      {ellipse && (
        <ellipse
          rx={ellipse.long_m}
          ry={ellipse.short_m}
          transform={`rotate(${-90 - ellipse.angle_rad * DEGREES})`}
          fill="none"
          stroke="var(--tm-series-2)"
          strokeWidth={2.5 * line}
        />
      )}
      {!ellipse && newest && <circle cx={-(newest[1] ?? 0)} cy={-(newest[0] ?? 0)} r={4 * line} fill="var(--tm-ink)" />}
      <g fill="var(--tm-muted)" fontSize={half / 8} textAnchor="middle">
        <text y={-1.06 * half}>{t('stand.ahead')}</text>
        <text y={1.18 * half}>{t('stand.back')}</text>
        <text x={-1.08 * half} transform={`rotate(-90 ${-1.08 * half} 0)`}>
          {t('stand.toLeft')}
        </text>
        <text x={1.08 * half} transform={`rotate(90 ${1.08 * half} 0)`}>
          {t('stand.toRight')}
        </text>
        <text x={0.78 * half} y={-0.78 * half}>
          {scale}
        </text>
      </g>
    </svg>
  );
}

const measureOf = (trial: Trial, name: string) => trial.measures.find((one) => one.measure === name);

function Ways({ trials, onSeek, startS }: { trials: readonly Trial[]; startS: number; onSeek: ReplayProps['onSeek'] }) {
  const far = Math.max(...trials.flatMap((one) => [one.ellipse?.long_m ?? 0, ...one.path_m.map(reachOf)]));
  const half = Math.max(0.01, Math.ceil(far * 100) / 100);
  return (
    <section className="card" aria-labelledby="ways">
      <h2 id="ways">{t('stand.way')}</h2>
      <div style={{ display: 'grid', gap: 16, gridTemplateColumns: 'repeat(auto-fit, minmax(190px, 1fr))' }}>
        {trials.map((one) => (
          <figure key={one.start_s} style={{ margin: 0 }}>
            <figcaption className="strong">{t(`stand.condition.${one.condition}`)}</figcaption>
            <Way
              path={one.path_m}
              ellipse={one.ellipse}
              half={half}
              label={t(`stand.condition.${one.condition}`)}
              scale={`${number(half * 100)} cm`}
            />
            <Button size="compact-sm" variant="subtle" onClick={() => onSeek(one.start_s - startS)}>
              {position(one.start_s - startS, 0)} · {t('stand.seconds', { seconds: number(one.end_s - one.start_s) })}
            </Button>
          </figure>
        ))}
      </div>
      <p className="muted small">{t('stand.wayHelp')}</p>
    </section>
  );
}

const reachOf = (point: readonly number[]) => Math.hypot(point[0] ?? 0, point[1] ?? 0);

function Numbers({ trials }: { trials: readonly Trial[] }) {
  const [isAll, setAll] = useState(false);
  const names: readonly string[] = isAll ? [...MAIN, ...REST] : MAIN;
  return (
    <section className="card" aria-labelledby="sway-numbers">
      <div className="card-head">
        <h2 id="sway-numbers">{t('stand.numbers')}</h2>
        <span className="end">
          <Button variant="default" size="sm" onClick={() => setAll(!isAll)} aria-expanded={isAll}>
            {isAll ? t('stand.fewer') : t('stand.more')}
          </Button>
        </span>
      </div>
      {/* eslint-disable-next-line jsx-a11y/no-noninteractive-tabindex -- a scrolling region must be reachable by keyboard */}
      <div className="table-scroll" role="group" aria-labelledby="sway-numbers" tabIndex={0}>
        <table className="plain-table">
          <thead>
            <tr>
              <th scope="col">{t('stand.measure')}</th>
              {trials.map((one) => (
                <th scope="col" key={one.start_s}>
                  {t(`stand.condition.${one.condition}`)}
                </th>
              ))}
            </tr>
          </thead>
          <tbody>
            {names.map((name) => (
              <tr key={name}>
                <th scope="row">{label(name)}</th>
                {trials.map((one) => (
                  <td className="number" key={one.start_s}>
                    {measureText(measureOf(one, name))}
                  </td>
                ))}
              </tr>
            ))}
          </tbody>
        </table>
      </div>
      <p className="muted small">{t('stand.sigma')}</p>
    </section>
  );
}

function Panel({ session, resultId, player, onSeek }: ReplayProps) {
  const found = useQuery(
    question('/api/sessions/{session_id}/balance', { ...ofSession(session.id), query: { result_id: resultId } }),
  );
  return (
    <>
      <h2 className="visually-hidden">{t('stand.result')}</h2>
      <QueryBoundary of={found} lines={8}>
        {({ trials, romberg, reasons, placement }) => {
          const stood = trials.filter((one) => one.ellipse);
          const reached = trials.filter((one) => one.condition === 'reach' && one.measures.length > 0);
          return (
            <div className="stack">
              {romberg.map(({ surface, measures }) => (
                <section className="card" key={surface} aria-labelledby={`romberg-${surface}`}>
                  <h2 id={`romberg-${surface}`}>{t(`stand.romberg.${surface}`)}</h2>
                  <ul className="plain-list lines">
                    {measures.map((one) => (
                      <li key={one.measure}>
                        {t('stand.rombergText', {
                          measure: label(one.measure),
                          ratio: measureText(one),
                        })}
                      </li>
                    ))}
                  </ul>
                  <p className="muted small">{t('stand.rombergHelp')}</p>
                </section>
              ))}
              {stood.length > 0 && <Ways trials={stood} startS={player.clock().startS} onSeek={onSeek} />}
              {stood.length > 0 && <Numbers trials={stood} />}
              {reached.length > 0 && (
                <section className="card" aria-labelledby="reach">
                  <h2 id="reach">{t('stand.reach')}</h2>
                  {reached.map((one) => (
                    <p key={one.start_s}>
                      {t('stand.reachText', {
                        way: measureText(measureOf(one, 'reach_displacement')),
                        angle: measureText(measureOf(one, 'reach_lean')),
                      })}
                    </p>
                  ))}
                </section>
              )}
              {trials
                .filter((one) => one.reason)
                .map((one) => (
                  <Notice key={one.start_s}>
                    {t(`stand.condition.${one.condition}`)}: {one.reason}
                  </Notice>
                ))}
              <ul className="muted small">
                <li>{t('stand.sensor', { place: placementLabel(placement) })}</li>
                {reasons.map((reason) => (
                  <li key={reason}>{reason}</li>
                ))}
              </ul>
            </div>
          );
        }}
      </QueryBoundary>
    </>
  );
}

export const panels: KindPanels = {
  live: { Start: Tests, Side: Now },
  replay: { tab: { value: 'balance', title: () => t('stand.result'), Panel } },
};
