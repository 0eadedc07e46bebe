// SPDX-License-Identifier: Apache-2.0
// How fast frames come and are shown, and how old they are then: as numbers and as curves.
import { drawChart, Rate, Samples } from "./chart.ts";
import { element, setText } from "./panel.ts";
import { currentTheme } from "./theme.ts";

/** Times are those of performance.now(). */
export class LiveTiming {
  #latencies = new Samples();
  #rates = new Samples();
  #pictureRates = new Samples();
  #frameRate = new Rate();
  #pictureRate = new Rate();

  /** A frame came, after `arrived` in all; `latency_ms`: its age, where it is known. */
  takeFrame(now_ms: number, arrived: number, latency_ms: number | null): void {
    if (latency_ms !== null) this.#latencies.add(now_ms, latency_ms);
    this.#frameRate.update(now_ms, arrived);
  }

  /** A frame is shown, after `shown` in all. */
  takePicture(now_ms: number, shown: number): void {
    this.#pictureRate.update(now_ms, shown);
  }

  showNumbers(now_ms: number): void {
    const rate = this.#frameRate.perSecond(now_ms);
    const pictures = this.#pictureRate.perSecond(now_ms);
    if (rate !== null) this.#rates.add(now_ms, rate);
    if (pictures !== null) this.#pictureRates.add(now_ms, pictures);
    setText(element("rate"), rate === null ? "–" : `${rate.toFixed(1)} /s`);
    setText(element("pictures"), pictures === null ? "–" : `${pictures.toFixed(1)} /s`);
    const median = this.#latencies.percentile(0.5, now_ms - 2000);
    const high = this.#latencies.percentile(0.99, now_ms - 20_000);
    setText(element("latency"), median === null ? "–" : `${median.toFixed(1)} ms`);
    setText(element("latency-high"), high === null ? "" : `99 % below ${high.toFixed(1)} ms`);
  }

  drawCharts(now_ms: number): void {
    const style = getComputedStyle(document.documentElement);
    const colour = (name: string): string => resolved(style.getPropertyValue(name));
    const [line, soft] = [colour("--line"), colour("--soft")];
    drawChart(element<HTMLCanvasElement>("latency-chart"), now_ms, [{ samples: this.#latencies, colour: colour("--latency") }], line, soft, 10);
    drawChart(element<HTMLCanvasElement>("rate-chart"), now_ms,
              [{ samples: this.#rates, colour: soft }, { samples: this.#pictureRates, colour: colour("--accent") }], line, soft, 30);
  }
}

/** The half of "light-dark(a, b)" that holds now. */
function resolved(colour: string): string {
  const halves = /^light-dark\((.*?),(.*)\)$/.exec(colour.trim());
  if (!halves) return colour;
  const isDark = currentTheme() === "dark" || (currentTheme() === "auto" && matchMedia("(prefers-color-scheme: dark)").matches);
  return halves[isDark ? 2 : 1]!.trim();
}
