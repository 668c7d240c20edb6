// uPlot inside React: made once per description, resized with its box, redrawn in the theme's colours.
import { useComputedColorScheme } from '@mantine/core';
import { useEffect, useLayoutEffect, useRef } from 'react';
import uPlot from 'uplot';

export type PlotOptions = Omit<uPlot.Options, 'width' | 'height'>;

/** A colour of the theme as the canvas needs it. */
export function themeColour(name: `--tm-${string}`): string {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim() || '#000';
}

export const CHART_FONT = "14px 'Atkinson Hyperlegible Next Variable', system-ui, sans-serif";

/** An axis in the theme's quiet grey. */
export function axis(more: uPlot.Axis = {}): uPlot.Axis {
  return {
    stroke: () => themeColour('--tm-muted'),
    font: CHART_FONT,
    grid: { stroke: () => themeColour('--tm-line'), width: 1 },
    ticks: { show: false },
    gap: 6,
    ...more,
  };
}

export interface PlotProps {
  /** Keep it the same object while the description is the same: a new one makes a new chart. */
  options: PlotOptions;
  data: uPlot.AlignedData;
  height: number;
  /** What the picture says, for those who do not see it. */
  label: string;
  onReady?: (plot: uPlot | null) => void;
}

export function Plot({ options, data, height, label, onReady }: PlotProps) {
  const box = useRef<HTMLDivElement>(null);
  const plot = useRef<uPlot | null>(null);
  const latest = useRef({ data, onReady });
  latest.current = { data, onReady };
  const scheme = useComputedColorScheme('light');

  useLayoutEffect(() => {
    const element = box.current;
    if (!element) return;
    const made = new uPlot(
      { ...options, width: Math.max(60, element.clientWidth), height },
      latest.current.data,
      element,
    );
    plot.current = made;
    latest.current.onReady?.(made);
    const observer = new ResizeObserver(() => {
      const width = Math.max(60, element.clientWidth);
      if (width !== made.width || height !== made.height) made.setSize({ width, height });
    });
    observer.observe(element);
    return () => {
      observer.disconnect();
      latest.current.onReady?.(null);
      made.destroy();
      plot.current = null;
    };
  }, [options, height, scheme]);

  useEffect(() => {
    plot.current?.setData(data);
  }, [data]);

  return <div ref={box} className="plot" role="img" aria-label={label} style={{ height }} />;
}
