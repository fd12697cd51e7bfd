/** Quality over generations, as it grows. */

import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";

import { number } from "../text/format";

export interface Point {
  generation: number;
  best: number | null;
  mean?: number | null;
}

const HEIGHT = 170;

export class ConvergenceChart {
  private readonly host: HTMLElement;
  private readonly observer: ResizeObserver;
  private chart: uPlot | null = null;
  private data: uPlot.AlignedData = [[], [], []];

  constructor(host: HTMLElement) {
    this.host = host;
    host.setAttribute("role", "img");
    this.observer = new ResizeObserver(() => {
      this.chart?.setSize({ width: Math.max(host.clientWidth, 200), height: HEIGHT });
    });
    this.observer.observe(host);
    this.build();
  }

  set(points: readonly Point[]): void {
    this.data = [
      points.map((point) => point.generation),
      points.map((point) => point.best),
      points.map((point) => point.mean ?? null),
    ];
    this.chart?.setData(this.data);
    const known = points.filter((point) => point.best !== null);
    const [first, last] = [known[0], known.at(-1)];
    this.host.setAttribute(
      "aria-label",
      first === undefined || last === undefined
        ? "Quality over generations: no grasp that holds so far"
        : `Quality over generations: from ${number(first.best)} in generation ${first.generation} to ` +
            `${number(last.best)} in generation ${last.generation}`,
    );
  }

  /** Takes the colours of the page as they are now. */
  restyle(): void {
    this.build();
  }

  dispose(): void {
    this.observer.disconnect();
    this.chart?.destroy();
  }

  private build(): void {
    this.chart?.destroy();
    const style = getComputedStyle(document.documentElement);
    const color = (name: string): string => style.getPropertyValue(name).trim();
    const axis = (label: string): uPlot.Axis => ({
      label,
      labelSize: 18,
      labelFont: "12px system-ui, sans-serif",
      font: "11px system-ui, sans-serif",
      stroke: color("--muted"),
      grid: { stroke: color("--line"), width: 1 },
      ticks: { stroke: color("--line"), width: 1, size: 4 },
    });
    const value = (_: uPlot, raw: number | null): string => number(raw);
    this.chart = new uPlot(
      {
        width: Math.max(this.host.clientWidth, 200),
        height: HEIGHT,
        scales: { x: { time: false }, y: { range: (_, low, high) => padded(low, high) } },
        axes: [axis("generation"), { ...axis("quality ε"), size: 52 }],
        series: [
          { label: "generation" },
          { label: "best", stroke: color("--accent"), width: 2, value, spanGaps: true },
          { label: "mean", stroke: color("--muted"), width: 1, dash: [4, 3], value },
        ],
        cursor: { drag: { x: false, y: false } },
        legend: { live: true },
      },
      this.data,
      this.host,
    );
  }
}

/** A range with room at the ends, also around a single value. */
export function padded(low: number | null, high: number | null): [number, number] {
  if (low === null || high === null) {
    return [0, 1];
  }
  const room = Math.max(0.08 * (high - low), 0.02 * Math.abs(high), 1e-9);
  return [Math.max(0, low - room), high + room];
}
