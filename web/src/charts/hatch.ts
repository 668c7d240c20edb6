// Hatching: the mark for stretches that must not be read as measured.
import type uPlot from 'uplot';
import { themeColour } from './Plot';

let tile: { colour: string; pattern: CanvasPattern } | null = null;

function pattern(context: CanvasRenderingContext2D): CanvasPattern | null {
  const colour = themeColour('--tm-line-strong');
  if (tile?.colour === colour) return tile.pattern;
  const canvas = document.createElement('canvas');
  canvas.width = canvas.height = 10;
  const pen = canvas.getContext('2d');
  if (!pen) return null;
  pen.strokeStyle = colour;
  pen.globalAlpha = 0.5;
  pen.lineWidth = 1.5;
  pen.beginPath();
  pen.moveTo(-2, 12);
  pen.lineTo(12, -2);
  pen.moveTo(-2, 2);
  pen.lineTo(2, -2);
  pen.moveTo(8, 12);
  pen.lineTo(12, 8);
  pen.stroke();
  const made = context.createPattern(canvas, 'repeat');
  if (made) tile = { colour, pattern: made };
  return made;
}

/** Hatch the plot between two x values over its full height. */
export function hatch(plot: uPlot, fromX: number, untilX: number): void {
  const style = pattern(plot.ctx);
  if (!style) return;
  const left = plot.valToPos(fromX, 'x', true);
  const right = plot.valToPos(untilX, 'x', true);
  plot.ctx.save();
  plot.ctx.fillStyle = style;
  plot.ctx.fillRect(left, plot.bbox.top, Math.max(1, right - left), plot.bbox.height);
  plot.ctx.restore();
}
