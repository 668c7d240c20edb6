// The curves of a template: which is drawn on, and which count.
import { Button, Switch } from '@mantine/core';
import { useState } from 'react';
import type { PhaseCurve } from '../../../api/types';
import { limbOf } from '../../../lib/placements';
import { t } from '../../../i18n';
import { pickCurves } from '../../../lib/assessment/comparison';
import type { Draft } from '../../../lib/assessment/design';
import './CurveList.css';

const SHOWN_FIRST = 7;

/** Compensation stands right after the main angle: it is what therapists limit most. */
function rank(channel: string, primary: string): number {
  if (channel === primary) return 0;
  if (channel.startsWith('trunk_') || channel.startsWith('shoulder_hike')) return 1;
  return channel.includes('.') ? 3 : 2;
}

interface Props {
  curves: readonly PhaseCurve[];
  primary: string;
  draft: Draft;
  selected: string;
  onSelect: (channel: string) => void;
  onWatched: (channel: string, isWatched: boolean) => void;
}

export function CurveList({ curves, primary, draft, selected, onSelect, onWatched }: Props) {
  const [showsAll, setShowsAll] = useState(false);
  const ordered = pickCurves(curves, true, primary).sort((a, b) => rank(a.channel, primary) - rank(b.channel, primary));
  const isChanged = (channel: string) =>
    channel in draft.bands || channel in draft.loose || draft.watched.includes(channel);
  const shown = ordered.filter(
    (one, index) => showsAll || index < SHOWN_FIRST || one.channel === selected || isChanged(one.channel),
  );
  const state = (channel: string) => {
    if (channel === primary) return t(limbOf(channel) === 'foot' ? 'design.isMainCurve' : 'design.isMain');
    if (draft.watched.includes(channel)) return t('design.isWatched');
    return channel in draft.bands || channel in draft.loose ? t('design.isDrawn') : t('design.isRecorded');
  };
  return (
    <nav className="curve-list" aria-labelledby="curves">
      <h2 id="curves">{t('design.curves')}</h2>
      <ul className="plain-list">
        {shown.map((one) => (
          <li key={one.channel} className={one.channel === selected ? 'curve-item curve-item-on' : 'curve-item'}>
            <button
              type="button"
              className="curve-button"
              aria-pressed={one.channel === selected}
              onClick={() => onSelect(one.channel)}
            >
              <span className="strong">{one.label}</span>
              <span className="muted small">{state(one.channel)}</span>
            </button>
            {one.channel !== primary && (
              <Switch
                size="md"
                label={t('design.counts')}
                labelPosition="left"
                aria-label={t('design.countsOf', { curve: one.label })}
                checked={!draft.watched.includes(one.channel)}
                onChange={(event) => onWatched(one.channel, !event.currentTarget.checked)}
              />
            )}
          </li>
        ))}
      </ul>
      {ordered.length > SHOWN_FIRST && (
        <Button variant="subtle" size="sm" aria-expanded={showsAll} onClick={() => setShowsAll(!showsAll)}>
          {t(showsAll ? 'design.fewerCurves' : 'design.moreCurves')}
        </Button>
      )}
    </nav>
  );
}
