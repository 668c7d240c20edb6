// How accurate this version is: every published experiment, their figure, what is required, ours, and how to measure it again.
import { IconCheck, IconChevronRight, IconQuestionMark, IconX } from '@tabler/icons-react';
import { useEffect, useState } from 'react';
import { useAccuracy } from '../api/queries';
import type { AccuracyFigure, AccuracyPlot, AccuracyProtocol, AccuracyReport } from '../api/types';
import { LineChart } from '../charts/LineChart';
import { CopyBox } from '../components/CopyBox';
import { QueryBoundary } from '../components/Feedback';
import { Page } from '../components/Page';
import { t } from '../i18n';
import { figure, isJudged, unitSign } from '../lib/assessment/figures';
import { date, number } from '../lib/format';
import './Accuracy.css';

const SHOWN_FIRST = 12;

type Verdict = AccuracyFigure['verdict'];

const MARKS = { pass: IconCheck, open: IconQuestionMark, short: IconX };
const WORDS = { pass: 'accuracy.met', open: 'accuracy.open', short: 'accuracy.missed' } as const;

function Mark({ verdict }: { verdict: Verdict }) {
  const Icon = MARKS[verdict];
  return (
    <span className={verdict === 'short' ? 'tag tag-alert' : 'tag'}>
      <Icon size={17} stroke={2.6} aria-hidden />
      {t(WORDS[verdict])}
    </span>
  );
}

function Row({ one }: { one: AccuracyFigure }) {
  const judged = isJudged(one);
  // A mean stands in no other column.
  const hasEstimate = judged || one.judged_by === 'mean';
  const isDrawn = hasEstimate && one.each !== 'recording';
  return (
    <tr className={judged ? undefined : 'row-left-out'}>
      <th scope="row">{one.name}</th>
      <td className="number">{figure(one.published, one.unit)}</td>
      <td className="number">
        {judged ? `${one.at_most ? '≤' : '≥'} ${figure(one.required, one.unit)}` : t('accuracy.shownOnly')}
      </td>
      <td className="number strong">{hasEstimate && figure(one.judged, one.unit)}</td>
      <td className="number">
        {isDrawn && t('accuracy.from', { low: figure(one.low, one.unit), high: figure(one.high, one.unit) })}
      </td>
      <td className="number">{figure(one.median, one.unit)}</td>
      <td className="number">{figure(one.worst, one.unit)}</td>
      <td className="number">{number(one.values.length)}</td>
      <td>{judged && <Mark verdict={one.verdict} />}</td>
    </tr>
  );
}

function Table({ figures, caption }: { figures: readonly AccuracyFigure[]; caption: string }) {
  return (
    // A table that scrolls must be reachable by keyboard.
    // eslint-disable-next-line jsx-a11y/no-noninteractive-tabindex
    <div className="table-scroll" tabIndex={0} role="region" aria-label={caption}>
      <table className="plain-table wide-table">
        <thead>
          <tr>
            <th scope="col">{t('accuracy.figure')}</th>
            <th scope="col">{t('accuracy.published')}</th>
            <th scope="col">{t('accuracy.required')}</th>
            <th scope="col">{t('accuracy.judged')}</th>
            <th scope="col">{t('accuracy.interval')}</th>
            <th scope="col">{t('accuracy.median')}</th>
            <th scope="col">{t('accuracy.worst')}</th>
            <th scope="col">{t('accuracy.count')}</th>
            <th scope="col">{t('accuracy.mark')}</th>
          </tr>
        </thead>
        <tbody>
          {figures.map((one) => (
            <Row key={one.name} one={one} />
          ))}
        </tbody>
      </table>
    </div>
  );
}

function Curves({ plot }: { plot: AccuracyPlot }) {
  const withUnit = (label: string, unit: string) =>
    unitSign(unit).trim() ? `${label} (${unitSign(unit).trim()})` : label;
  return (
    <figure className="figure">
      <figcaption className="strong">{plot.title}</figcaption>
      <LineChart
        lines={plot.curves}
        xTitle={withUnit(plot.x_label, plot.x_unit)}
        yTitle={withUnit(plot.y_label, plot.y_unit)}
        logarithmic={plot.logarithmic}
        label={t('accuracy.plotLabel', {
          title: plot.title,
          y: plot.y_label,
          x: plot.x_label,
          lines: plot.curves.map((curve) => curve.name).join(', '),
        })}
      />
    </figure>
  );
}

interface ProtocolProps {
  protocol: AccuracyProtocol;
  command: string;
  isOpen: boolean;
  onToggle: (isOpen: boolean) => void;
}

function Protocol({ protocol, command, isOpen, onToggle }: ProtocolProps) {
  const judgedFirst = [...protocol.figures].sort((a, b) => Number(isJudged(b)) - Number(isJudged(a)));
  const first = judgedFirst.slice(0, SHOWN_FIRST);
  const rest = judgedFirst.slice(SHOWN_FIRST);
  return (
    <section className="card" id={protocol.name} aria-labelledby={`${protocol.name}-title`}>
      <details className="fold" open={isOpen} onToggle={(event) => onToggle(event.currentTarget.open)}>
        <summary>
          <IconChevronRight className="fold-sign" size={20} stroke={2.2} aria-hidden />
          <h2 id={`${protocol.name}-title`} className="protocol-title">
            {protocol.title}
          </h2>
          <Mark verdict={protocol.verdict} />
        </summary>
        {isOpen && (
          <div className="stack">
            <div>
              <p className="muted small">{protocol.source}</p>
              <p className="measure-text">{protocol.what}</p>
            </div>
            <Table figures={first} caption={protocol.title} />
            {rest.length > 0 && (
              <details className="as-table">
                <summary>{t('accuracy.more', { count: rest.length })}</summary>
                <Table figures={rest} caption={t('accuracy.moreOf', { title: protocol.title })} />
              </details>
            )}
            {protocol.plots.length > 0 && (
              <div className="plot-grid">
                {protocol.plots.map((plot) => (
                  <Curves key={plot.title} plot={plot} />
                ))}
              </div>
            )}
            <div>
              <p className="muted small">
                {t('accuracy.again', {
                  seeds: protocol.seeds,
                  seconds: number(protocol.seconds, protocol.seconds < 10 ? 1 : 0),
                })}
              </p>
              <CopyBox
                label={t('accuracy.commandOf', { title: protocol.title })}
                text={command.replace('validate', `validate ${protocol.name}`)}
              />
            </div>
          </div>
        )}
      </details>
    </section>
  );
}

function Report({ report }: { report: AccuracyReport }) {
  const count = (verdict: Verdict) => report.protocols.filter((one) => one.verdict === verdict).length;
  // Sixty experiments are a long page: closed but for what falls short and what was asked for.
  const [open, setOpen] = useState(
    () =>
      new Set([
        ...report.protocols.filter((one) => one.verdict === 'short').map((one) => one.name),
        window.location.hash.slice(1),
      ]),
  );
  // The report comes after the browser has looked for what the address names.
  useEffect(() => {
    if (window.location.hash) document.getElementById(window.location.hash.slice(1))?.scrollIntoView();
  }, []);
  const turn = (name: string, isOpen: boolean) =>
    setOpen((now) => {
      const next = new Set(now);
      if (isOpen) next.add(name);
      else next.delete(name);
      return next;
    });
  return (
    <div className="stack">
      <section className="card stack" aria-labelledby="overview">
        <div className="line-head">
          <h2 id="overview" className="protocol-title">
            {t('accuracy.overview', { met: count('pass'), all: report.protocols.length })}
          </h2>
          <Mark verdict={count('short') > 0 ? 'short' : count('open') > 0 ? 'open' : 'pass'} />
        </div>
        <p>{t('accuracy.notMet', { open: count('open'), short: count('short') })}</p>
        <p className="measure-text">{t('accuracy.how', { seeds: report.seeds })}</p>
        <ol className="protocol-index">
          {report.protocols.map((one) => (
            <li key={one.name}>
              <a href={`#${one.name}`} onClick={() => turn(one.name, true)}>
                {one.title}
              </a>
              {one.verdict !== 'pass' && (
                <span className={one.verdict === 'short' ? 'alert-text' : 'muted'}> ({t(WORDS[one.verdict])})</span>
              )}
            </li>
          ))}
        </ol>
        <div>
          <p className="muted small">
            {t('accuracy.made', {
              version: report.version,
              date: date(report.made_at, new Date(0)),
              machine: report.machine,
              seconds: number(report.seconds),
            })}
          </p>
          <CopyBox label={t('accuracy.command')} text={report.command} />
        </div>
      </section>
      {report.protocols.map((one) => (
        <Protocol
          key={one.name}
          protocol={one}
          command={report.command}
          isOpen={open.has(one.name)}
          onToggle={(isOpen) => turn(one.name, isOpen)}
        />
      ))}
    </div>
  );
}

export function AccuracyPage() {
  const report = useAccuracy();
  return (
    <Page title={t('accuracy.title')} lead={t('accuracy.lead')}>
      <QueryBoundary of={report} lines={8} height={40}>
        {(data) => <Report report={data} />}
      </QueryBoundary>
    </Page>
  );
}
