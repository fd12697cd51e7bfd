/** A chart of the quality over the generations. */

import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import "./convergence.css";

import { count, number, steps } from "../text/format";

export interface Point {
  generation: number;
  best: number | null;
  mean?: number | null;
  evaluations?: number;
}

/** The value of a series at an index; undefined past the end of the data. */
type Value = number | null | undefined;
const whole = (value: Value): string => count(value ?? NaN);

/** Height of curves and axes, without the legend, in pixels. */
const HEIGHT = 180;
const LEAST_WIDTH = 200;

export class ConvergenceChart {
  private readonly host: HTMLElement;
  private readonly observer: ResizeObserver;
  private chart: uPlot | null = null;
  private data: uPlot.AlignedData = [[], [], [], []];

  constructor(host: HTMLElement) {
    this.host = host;
    host.setAttribute("role", "img");
    host.setAttribute("aria-label", summary([]));
    this.observer = new ResizeObserver(() => {
      this.chart?.setSize({ width: this.width(), height: HEIGHT });
    });
    this.observer.observe(host);
    this.build();
  }

  /** Shows the points; those of one generation must be adjacent. */
  set(points: readonly Point[]): void {
    const shown = lastOfEach(points);
    this.data = [
      shown.map((point) => point.generation),
      shown.map((point) => point.best),
      shown.map((point) => point.mean ?? null),
      shown.map((point) => point.evaluations ?? null),
    ];
    this.chart?.setData(this.data);
    this.showNewest();
    this.host.setAttribute("aria-label", summary(shown));
  }

  /** Applies the current colours of the page. */
  restyle(): void {
    this.build();
  }

  dispose(): void {
    this.observer.disconnect();
    this.chart?.destroy();
    this.chart = null;
  }

  private width(): number {
    return Math.max(this.host.clientWidth, LEAST_WIDTH);
  }

  /** Shows the newest values in the legend while the pointer is not on the chart. */
  private showNewest(): void {
    if (this.chart !== null && this.data[0].length > 0 && this.chart.cursor.idx == null) {
      this.chart.setLegend({ idx: this.data[0].length - 1 }, false);
    }
  }

  private build(): void {
    this.chart?.destroy();
    const style = getComputedStyle(document.documentElement);
    const color = (name: string): string => style.getPropertyValue(name).trim();
    const axis = (label: string, size: uPlot.Axis.Size): uPlot.Axis => ({
      label,
      size,
      labelSize: 16,
      labelGap: 0,
      gap: 4,
      labelFont: "12px system-ui, sans-serif",
      font: "11px system-ui, sans-serif",
      stroke: color("--muted"),
      grid: { stroke: color("--line"), width: 1 },
      ticks: { stroke: color("--line"), width: 1, size: 4 },
    });
    const line = (label: string, stroke: string, width: number): uPlot.Series => ({
      label,
      stroke: color(stroke),
      width,
      value: (_, raw: Value) => number(raw),
      points: { size: 5, fill: color(stroke) },
    });
    this.chart = new uPlot(
      {
        width: this.width(),
        height: HEIGHT,
        padding: [8, 12, 0, 0],
        scales: {
          x: { time: false, range: (_, low, high) => [low, Math.max(high, low + 1)] },
          y: { range: (_, low, high) => padded(low, high) },
          evaluations: {},
        },
        axes: [
          {
            ...axis("generation", 26),
            incrs: [1, 2, 5, 10, 20, 50, 100, 200, 500, 1e3, 2e3, 5e3, 1e4, 2e4, 5e4],
          },
          {
            ...axis("quality ε", (_, texts) => axisWidth(texts)),
            values: (_, ticks) => steps(ticks),
          },
        ],
        series: [
          {
            label: "generation",
            value: (_, raw: Value) => whole(raw),
          },
          { ...line("best", "--accent", 2), spanGaps: true },
          { ...line("mean", "--muted", 1), dash: [4, 3] },
          {
            label: "evaluations",
            scale: "evaluations",
            paths: () => null,
            points: { show: false },
            value: (_, raw: Value) => whole(raw),
          },
        ],
        cursor: { drag: { x: false, y: false }, points: { size: 7 } },
        legend: { live: true },
        hooks: {
          setCursor: [
            (): void => {
              this.showNewest();
            },
          ],
        },
      },
      this.data,
      this.host,
    );
    this.showNewest();
  }
}

/** Width of an axis with these labels, in pixels; without labels, a typical width. */
function axisWidth(texts: readonly string[] | null): number {
  const longest = Math.max(5, ...(texts ?? []).map((text) => text.length));
  return Math.ceil(12 + 6.5 * longest);
}

/** The last point of each generation: a chart shows one value per generation. */
export function lastOfEach(points: readonly Point[]): Point[] {
  return points.filter((point, index) => points[index + 1]?.generation !== point.generation);
}

/** Describes the chart in a sentence, for screen readers. */
export function summary(points: readonly Point[]): string {
  const known = points.filter((point) => point.best !== null);
  const [first, last] = [known[0], known.at(-1)];
  if (first === undefined || last === undefined) {
    return "Quality over generations: no grasp that holds so far";
  }
  return (
    `Quality over generations: from ${number(first.best)} in generation ${count(first.generation)} to ` +
    `${number(last.best)} in generation ${count(last.generation)}`
  );
}

/** A range with some room at both ends, also around a single value. */
export function padded(low: number | null, high: number | null): [number, number] {
  if (low === null || high === null) {
    return [0, 1];
  }
  const room = Math.max(0.08 * (high - low), 0.02 * Math.abs(high), 1e-9);
  return [Math.max(0, low - room), high + room];
}
