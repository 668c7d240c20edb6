// Left beside right, and where another walk was chosen, before beside now.
import { Button } from '@mantine/core';
import { useState } from 'react';
import type { Gait, WalkMeasure } from '../../../api/types';
import { Measured } from '../../../components/Measured';
import { t } from '../../../i18n';
import { findMeasure, footOf, measureLabel, measureNames, measureText } from '../gait';

const SIDES = ['left', 'right'] as const;

function Shown({ of }: { of: WalkMeasure | undefined }) {
  return <Measured text={of ? measureText(of.value, of.unit, of.sigma) : '–'} />;
}

export function WalkNumbers({ gait, before, affected }: { gait: Gait; before: Gait | null; affected: string | null }) {
  const [all, setAll] = useState(false);
  const both = [...gait.both, ...(gait.balance?.measures ?? [])];
  const turning = [...new Set(gait.feet.flatMap((foot) => (foot.turning ?? []).map((one) => one.measure)))];
  const sideName = (side: (typeof SIDES)[number]) =>
    t(`numbers.${side}`) + (affected === side || affected === 'both' ? ` (${t('walk.affected')})` : '');
  const counted = gait.feet.reduce((sum, foot) => sum + (findMeasure(foot.measures, 'stride_length')?.count ?? 0), 0);
  return (
    <section className="card" aria-labelledby="numbers">
      <div className="card-head">
        <h2 id="numbers">{t('numbers.title')}</h2>
        <span className="muted small">{t('numbers.strides', { count: counted })}</span>
        <span className="end">
          <Button variant="default" size="sm" onClick={() => setAll(!all)} aria-expanded={all}>
            {all ? t('numbers.fewer') : t('numbers.more')}
          </Button>
        </span>
      </div>
      {/* eslint-disable-next-line jsx-a11y/no-noninteractive-tabindex -- a scrolling region must be reachable by keyboard */}
      <div className="table-scroll" role="group" aria-labelledby="numbers" tabIndex={0}>
        <table className="plain-table stacked-table">
          <thead>
            <tr>
              <th scope="col">{t('numbers.measure')}</th>
              {SIDES.map((side) => [
                before && (
                  <th scope="col" key={`${side}before`}>
                    {t('numbers.before', { side: t(`numbers.${side}`) })}
                  </th>
                ),
                <th scope="col" key={side}>
                  {sideName(side)}
                </th>,
              ])}
              <th scope="col">{t('numbers.difference')}</th>
              <th scope="col">{t('numbers.counted')}</th>
            </tr>
          </thead>
          <tbody>
            {measureNames(gait, all).map((name) => (
              <tr key={name}>
                <th scope="row">{measureLabel(name)}</th>
                {SIDES.map((side) => [
                  before && (
                    <td
                      className="muted"
                      key={`${side}before`}
                      data-label={t('numbers.before', { side: t(`numbers.${side}`) })}
                    >
                      <Shown of={findMeasure(footOf(before, side)?.measures, name)} />
                    </td>
                  ),
                  <td className="strong" key={side} data-label={sideName(side)}>
                    <Shown of={findMeasure(footOf(gait, side)?.measures, name)} />
                  </td>,
                ])}
                <td data-label={t('numbers.difference')}>
                  <Shown of={findMeasure(gait.asymmetry, name)} />
                </td>
                <td className="number muted" data-label={t('numbers.counted')}>
                  {SIDES.map((side) => findMeasure(footOf(gait, side)?.measures, name)?.count ?? 0).join(' + ')}
                </td>
              </tr>
            ))}
          </tbody>
        </table>
        {turning.length > 0 && (
          <table className="plain-table stacked-table">
            <caption>{t('numbers.turning')}</caption>
            <thead>
              <tr>
                <th scope="col">{t('numbers.measure')}</th>
                {SIDES.map((side) => (
                  <th scope="col" key={side}>
                    {sideName(side)}
                  </th>
                ))}
                <th scope="col">{t('numbers.counted')}</th>
              </tr>
            </thead>
            <tbody>
              {turning.map((name) => (
                <tr key={name}>
                  <th scope="row">{measureLabel(name)}</th>
                  {SIDES.map((side) => (
                    <td className="strong" key={side} data-label={sideName(side)}>
                      <Shown of={findMeasure(footOf(gait, side)?.turning, name)} />
                    </td>
                  ))}
                  <td className="number muted" data-label={t('numbers.counted')}>
                    {SIDES.map((side) => findMeasure(footOf(gait, side)?.turning, name)?.count ?? 0).join(' + ')}
                  </td>
                </tr>
              ))}
            </tbody>
          </table>
        )}
        {both.length > 0 && (
          <table className="plain-table stacked-table">
            <thead>
              <tr>
                <th scope="col">{t('numbers.measure')}</th>
                {before && <th scope="col">{t('numbers.before', { side: t('numbers.both') })}</th>}
                <th scope="col">{t('numbers.both')}</th>
                <th scope="col">{t('numbers.counted')}</th>
              </tr>
            </thead>
            <tbody>
              {both.map((one) => (
                <tr key={one.measure}>
                  <th scope="row">{measureLabel(one.measure)}</th>
                  {before && (
                    <td className="muted" data-label={t('numbers.before', { side: t('numbers.both') })}>
                      <Shown of={findMeasure([...before.both, ...(before.balance?.measures ?? [])], one.measure)} />
                    </td>
                  )}
                  <td className="strong" data-label={t('numbers.both')}>
                    <Shown of={one} />
                  </td>
                  <td className="number muted" data-label={t('numbers.counted')}>
                    {one.count}
                  </td>
                </tr>
              ))}
            </tbody>
          </table>
        )}
      </div>
      <p className="muted small">{t('numbers.help')}</p>
    </section>
  );
}
