// Numbers of experiments: three digits that count, tiny ones as a power of ten.
import type { AccuracyFigure } from '../../api/types';
import { number } from '../format';

const UNITS: Record<string, string> = { deg: '°', 'deg/s': ' °/s', '1': '', '%': ' %', times: ' ×' };
const RAISED = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];

/** The unit as it stands behind a number or beside an axis. */
export function unitSign(unit: string): string {
  return UNITS[unit] ?? (unit ? ` ${unit}` : '');
}

/** A measured number with its unit. */
export function figure(value: number | null | undefined, unit: string): string {
  if (value === null || value === undefined || !Number.isFinite(value)) return '–';
  const size = Math.abs(value);
  if (size > 0 && size < 1e-3) {
    const power = Math.floor(Math.log10(size));
    const raised = String(-power).replace(/\d/g, (digit) => RAISED[Number(digit)] ?? '');
    return `${number(value / 10 ** power, 1)} · 10⁻${raised}${unitSign(unit)}`;
  }
  const digits = size === 0 || size >= 100 ? 0 : size >= 10 ? 1 : size >= 1 ? 2 : 3;
  const text = number(value, digits);
  return (digits > 0 ? text.replace(/[.,]?0+$/, '') : text) + unitSign(unit);
}

/** Whether the figure is judged against a limit, and not only shown. */
export function isJudged(one: AccuracyFigure): boolean {
  return one.required !== null && one.required !== undefined;
}
