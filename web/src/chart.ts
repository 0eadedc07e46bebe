// SPDX-License-Identifier: Apache-2.0
// A curve of the last seconds on a small canvas.
import { fitCanvas } from "./fit_canvas.ts";

const kMostSamples = 2048;

/** Values with the times at which they were measured, within a ring. */
export class Samples {
  times = new Float64Array(kMostSamples);
  values = new Float64Array(kMostSamples);
  #next = 0;
  count = 0;

  add(time_ms: number, value: number): void {
    this.times[this.#next] = time_ms;
    this.values[this.#next] = value;
    this.#next = (this.#next + 1) % kMostSamples;
    this.count = Math.min(this.count + 1, kMostSamples);
  }

  /** Index in the ring of the sample that is `back` before the newest. */
  at(back: number): number {
    return (this.#next - 1 - back + 2 * kMostSamples) % kMostSamples;
  }

  /** How many samples are not older than `since_ms`. */
  countSince(since_ms: number): number {
    let count = 0;
    while (count < this.count && this.times[this.at(count)]! >= since_ms) ++count;
    return count;
  }

  /** The value below which `share` of the samples since then lie; null without any. */
  percentile(share: number, since_ms: number): number | null {
    const count = this.countSince(since_ms);
    if (count === 0) return null;
    const values: number[] = [];
    for (let back = 0; back < count; ++back) values.push(this.values[this.at(back)]!);
    values.sort((a, b) => a - b);
    return values[Math.min(count - 1, Math.floor(share * count))]!;
  }
}

/** Counts events, and says how many there are in a second. */
export class Rate {
  #samples = new Samples();
  #last: number | null = null;

  /** `total` events have happened until now; a total that goes back is another stream's. */
  update(now_ms: number, total: number): void {
    if (this.#last !== null && total < this.#last) this.#samples = new Samples();
    this.#last = total;
    this.#samples.add(now_ms, total);
  }

  /** Per second, over the last two seconds; null as long as that is not known. */
  perSecond(now_ms: number): number | null {
    const count = this.#samples.countSince(now_ms - 2000);
    if (count < 2) return null;
    const newest = this.#samples.at(0);
    const oldest = this.#samples.at(count - 1);
    const seconds = (this.#samples.times[newest]! - this.#samples.times[oldest]!) / 1000;
    return seconds < 0.2 ? null : (this.#samples.values[newest]! - this.#samples.values[oldest]!) / seconds;
  }
}

export const kChartSpan_ms = 20_000;

export interface Curve {
  samples: Samples;
  colour: string;
}

/** Draws curves over the last 20 seconds, with a line at each `grid` from 0 on. Returns the upper end of the scale. */
export function drawChart(canvas: HTMLCanvasElement, now_ms: number, curves: Curve[], gridColour: string, textColour: string, least: number): number {
  const ratio = fitCanvas(canvas);
  const { width, height } = canvas;
  const context = canvas.getContext("2d")!;
  const top = upperEnd(curves, now_ms, least);
  context.clearRect(0, 0, width, height);
  const rowOf = (value: number): number => height - ratio - (value / top) * (height - 2 * ratio);
  drawGrid(context, width, rowOf, top, ratio, gridColour, textColour);
  for (const curve of curves) drawCurve(context, curve, now_ms, width, rowOf, ratio);
  return top;
}

function upperEnd(curves: Curve[], now_ms: number, least: number): number {
  let most = least;
  for (const { samples } of curves) {
    const count = samples.countSince(now_ms - kChartSpan_ms);
    for (let back = 0; back < count; ++back) most = Math.max(most, samples.values[samples.at(back)]!);
  }
  const power = 10 ** Math.floor(Math.log10(most));
  return power * ([1, 2, 4, 5, 8, 10].find((factor) => factor * power >= 1.05 * most) ?? 20);
}

function drawGrid(context: CanvasRenderingContext2D, width: number, rowOf: (value: number) => number, top: number, ratio: number,
                  colour: string, textColour: string): void {
  context.strokeStyle = colour;
  context.fillStyle = textColour;
  context.lineWidth = ratio;
  context.font = `${10 * ratio}px system-ui, sans-serif`;
  context.textBaseline = "top";
  for (const value of [0, top / 2, top]) {
    const row = Math.round(rowOf(value)) + 0.5 * ratio;
    context.beginPath();
    context.moveTo(0, row);
    context.lineTo(width, row);
    context.stroke();
    if (value > 0) context.fillText(String(value), 2 * ratio, row + 2 * ratio);
  }
}

function drawCurve(context: CanvasRenderingContext2D, { samples, colour }: Curve, now_ms: number, width: number,
                   rowOf: (value: number) => number, ratio: number): void {
  const count = samples.countSince(now_ms - kChartSpan_ms);
  context.beginPath();
  let before = now_ms;
  for (let back = 0; back < count; ++back) {
    const i = samples.at(back);
    const column = width * (1 - (now_ms - samples.times[i]!) / kChartSpan_ms);
    const isGap = before - samples.times[i]! > 1500;  // nothing came meanwhile
    if (back === 0 || isGap) context.moveTo(column, rowOf(samples.values[i]!));
    else context.lineTo(column, rowOf(samples.values[i]!));
    before = samples.times[i]!;
  }
  context.strokeStyle = colour;
  context.lineWidth = 1.6 * ratio;
  context.lineJoin = "round";
  context.stroke();
}
