// Two conditions that the therapist chooses, such as eyes open and closed: what changes, and whether chance explains it.
import { SegmentedControl, TextInput } from '@mantine/core';
import { IconShoe } from '@tabler/icons-react';
import { useMemo, useState } from 'react';
import { useParams } from 'react-router';
import { useConditions, usePatient, useWalks } from '../../api/queries';
import type { Conditions, MeasureChange, WalkRow } from '../../api/types';
import { QueryBoundary, Empty } from '../../components/Feedback';
import { Page } from '../../components/Page';
import { t } from '../../i18n';
import { dateTime, number } from '../../lib/format';
import { fullName, patientCrumbs } from '../../lib/people';
import { measureLabel, measureText, partsOf } from './gait';
import './ConditionsPage.css';

type Condition = 'a' | 'b' | '';
const CLEAR = 0.05;

function chance(p: number | null): string {
  if (p === null) return '–';
  return p < 0.001 ? t('conditions.below') : t('conditions.chanceOf', { percent: number(100 * p, 1) });
}

function Row({ change }: { change: MeasureChange }) {
  const isClear = change.p !== null && change.p < CLEAR;
  return (
    <tr>
      <th scope="row">{measureLabel(change.measure)}</th>
      <td>{change.foot === 'both' ? t('numbers.both') : t(`numbers.${change.foot}`)}</td>
      <td className="number">{measureText(change.a, change.unit)}</td>
      <td className="number">{measureText(change.b, change.unit)}</td>
      <td className="number strong">{measureText(change.difference, change.unit, change.sigma)}</td>
      <td className="number">{chance(change.p)}</td>
      <td>
        {isClear ? (
          <span className="tag tag-accent">{t('conditions.clear')}</span>
        ) : (
          <span className="muted">{t('conditions.unclear')}</span>
        )}
      </td>
    </tr>
  );
}

function Result({ found, names }: { found: Conditions; names: readonly [string, string] }) {
  const count = found.changes[0]?.count ?? 0;
  return (
    <>
      {/* eslint-disable-next-line jsx-a11y/no-noninteractive-tabindex -- a scrolling region must be reachable by keyboard */}
      <div className="table-scroll" role="group" aria-labelledby="condition-result" tabIndex={0}>
        <table className="plain-table wide-table">
          <thead>
            <tr>
              <th scope="col">{t('numbers.measure')}</th>
              <th scope="col">{t('strides.foot')}</th>
              <th scope="col">{names[0]}</th>
              <th scope="col">{names[1]}</th>
              <th scope="col">{t('conditions.difference')}</th>
              <th scope="col">{t('conditions.chance')}</th>
              <th scope="col">
                <span className="visually-hidden">{t('conditions.result')}</span>
              </th>
            </tr>
          </thead>
          {partsOf(found.changes).map(([part, changes]) => (
            <tbody key={part}>
              <tr>
                <th scope="rowgroup" colSpan={7} className="table-part">
                  {t(`conditions.part.${part}`)}
                </th>
              </tr>
              {changes.map((change) => (
                <Row key={`${change.measure}${change.foot}`} change={change} />
              ))}
            </tbody>
          ))}
        </table>
      </div>
      <p className="muted small">
        {found.method === 'pairs' ? t('conditions.pairs', { count }) : t('conditions.strides')}{' '}
        {t('conditions.many', { count: found.changes.length })}
      </p>
    </>
  );
}

function Choice({ patientId, walks }: { patientId: string; walks: readonly WalkRow[] }) {
  const [names, setNames] = useState<readonly [string, string]>([t('conditions.defaultA'), t('conditions.defaultB')]);
  const [chosen, setChosen] = useState<Record<string, Condition>>({});
  const inOrder = useMemo(() => [...walks].sort((one, two) => one.started_at.localeCompare(two.started_at)), [walks]);
  const ids = (condition: Condition) =>
    inOrder.filter((one) => chosen[one.session_id] === condition).map((one) => one.session_id);
  const [a, b] = [ids('a'), ids('b')];
  const found = useConditions(patientId, a, b);
  return (
    <div className="stack">
      <section className="card stack" aria-labelledby="condition-choice">
        <h2 id="condition-choice">{t('conditions.choose')}</h2>
        <p className="muted">{t('conditions.help')}</p>
        <div className="condition-names">
          <TextInput
            label={t('conditions.nameA')}
            value={names[0]}
            maxLength={40}
            onChange={(event) => setNames([event.currentTarget.value, names[1]])}
          />
          <TextInput
            label={t('conditions.nameB')}
            value={names[1]}
            maxLength={40}
            onChange={(event) => setNames([names[0], event.currentTarget.value])}
          />
        </div>
        <ul className="plain-list lines">
          {walks.map((walk) => (
            <li key={walk.session_id} className="condition-line">
              <span>
                <span className="strong">{dateTime(walk.started_at)}</span>{' '}
                <span className="muted small">
                  {walk.exercise_name ?? t(`walk.kind.${walk.kind}`)}
                  {walk.distance_m !== null && ` · ${number(walk.distance_m, 1)} m`}
                  {walk.speed_mps !== null && ` · ${number(walk.speed_mps, 2)} m/s`}
                </span>
              </span>
              <SegmentedControl
                aria-label={t('conditions.group', { when: dateTime(walk.started_at) })}
                value={chosen[walk.session_id] ?? ''}
                onChange={(value) => setChosen({ ...chosen, [walk.session_id]: value as Condition })}
                data={[
                  { value: '', label: t('conditions.neither') },
                  { value: 'a', label: names[0] || 'A' },
                  { value: 'b', label: names[1] || 'B' },
                ]}
              />
            </li>
          ))}
        </ul>
      </section>
      <section className="card" aria-labelledby="condition-result">
        <div className="card-head">
          <h2 id="condition-result">{t('conditions.result')}</h2>
        </div>
        {a.length === 0 || b.length === 0 ? (
          <p className="muted">{t('conditions.need')}</p>
        ) : (
          <QueryBoundary of={found} lines={6}>
            {(data) => <Result found={data} names={names} />}
          </QueryBoundary>
        )}
      </section>
    </div>
  );
}

export function ConditionsPage() {
  const { patientId = '' } = useParams();
  const patient = usePatient(patientId);
  const walks = useWalks(patientId);
  const name = patient.data ? fullName(patient.data) : '';
  return (
    <Page title={t('conditions.title')} lead={t('conditions.lead')} crumbs={patientCrumbs(patientId, name)}>
      <QueryBoundary of={walks} lines={6}>
        {(list) =>
          list.length === 0 ? (
            <Empty icon={<IconShoe size={42} aria-hidden />} title={t('conditions.noWalks')}>
              {t('conditions.noWalksText')}
            </Empty>
          ) : (
            <Choice patientId={patientId} walks={list} />
          )
        }
      </QueryBoundary>
    </Page>
  );
}
