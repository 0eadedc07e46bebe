// SPDX-License-Identifier: Apache-2.0
// The scale below the image: which colours stand for which distances.
import { roundTicks, type DepthRange } from "./depth_range.ts";
import { kPaletteSize } from "./palette.ts";
import { element } from "./panel.ts";

const kNarrow_px = 260;  // has room for few ticks

export class RangeScale {
  #scale = element("scale");
  #ticks = element("ticks");
  #shown = "";

  constructor(palette: Uint8Array) {
    const context = element<HTMLCanvasElement>("scale-bar").getContext("2d")!;
    context.putImageData(new ImageData(new Uint8ClampedArray(palette), kPaletteSize, 1), 0, 0);
    new ResizeObserver(() => { this.#shown = ""; }).observe(this.#ticks);
  }

  show({ near_mm, far_mm }: DepthRange): void {
    const key = `${near_mm.toFixed(0)} ${far_mm.toFixed(0)}`;
    if (key === this.#shown) return;
    this.#shown = key;
    this.#scale.setAttribute("aria-label", `Colours of distances, from ${near_mm.toFixed(0)} to ${far_mm.toFixed(0)} mm`);
    this.#ticks.replaceChildren(...roundTicks(near_mm, far_mm, this.#ticks.clientWidth < kNarrow_px ? 3 : 6).map((tick) => {
      const label = document.createElement("span");
      label.textContent = String(tick);
      label.style.left = `${Math.min(97, Math.max(3, (100 * (tick - near_mm)) / (far_mm - near_mm))).toFixed(2)}%`;
      return label;
    }));
  }
}
