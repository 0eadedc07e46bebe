// SPDX-License-Identifier: Apache-2.0
// The distances that colours stand for: those of most pixels, or what the user sets.

const kBins = 1024;
const kStep = 7;  // every seventh pixel says enough

/** Near and far end of the colours [mm]. */
export class DepthRange {
  near_mm = 300;
  far_mm = 1500;
  isAutomatic = true;
  #bins = new Uint32Array(kBins);
  #isSettled = false;

  /** Follows the image where the range is automatic: from its 1st to its 98th percentile, slowly, so that colours do not flicker. */
  follow(depth: Uint16Array, unit_mm: number): void {
    if (!this.isAutomatic) return;
    const near = percentile(depth, this.#bins, 0.01);
    if (near < 0) return;
    const far = percentileOfBins(this.#bins, 0.98);
    const near_mm = near * unit_mm;
    const far_mm = Math.max(far * unit_mm, near_mm + 50);
    const weight = this.#isSettled ? 0.08 : 1;
    this.near_mm += weight * (near_mm - this.near_mm);
    this.far_mm += weight * (far_mm - this.far_mm);
    this.#isSettled = true;
  }

  /** What the user sets; an impossible one changes nothing. */
  fix(near_mm: number, far_mm: number): boolean {
    if (!(near_mm >= 0) || !(far_mm > near_mm) || far_mm > 1e6) return false;
    this.near_mm = near_mm;
    this.far_mm = far_mm;
    return true;
  }

  /** Follows some points instead of the image, where the range is automatic: all of them, and as much around. */
  followPoints(depths_mm: number[], margin_mm: number): void {
    if (!this.isAutomatic || depths_mm.length === 0) return;
    this.near_mm = Math.max(0, Math.min(...depths_mm) - margin_mm);
    this.far_mm = Math.max(...depths_mm) + margin_mm;
  }

  setAutomatic(isAutomatic: boolean): void {
    this.isAutomatic = isAutomatic;
    this.#isSettled = false;
  }
}

/** Counts measured pixels into `bins` of 64 counts each; the value below which a share of them lies, or -1 without any. */
function percentile(depth: Uint16Array, bins: Uint32Array, share: number): number {
  bins.fill(0);
  for (let i = 0; i < depth.length; i += kStep) {
    const count = depth[i]!;
    if (count !== 0) ++bins[count >> 6]!;
  }
  return percentileOfBins(bins, share);
}

function percentileOfBins(bins: Uint32Array, share: number): number {
  let total = 0;
  for (let i = 0; i < kBins; ++i) total += bins[i]!;
  if (total === 0) return -1;
  let left = share * total;
  for (let i = 0; i < kBins; ++i) {
    if (left < bins[i]!) return (i + left / bins[i]!) * 64;
    left -= bins[i]!;
  }
  return kBins * 64;
}

/** The brightest of nearly all infrared pixels, for its white. */
export function infraredWhite(infrared: Uint16Array, bins: Uint32Array = infraredBins): number {
  return Math.max(1, percentile(infrared, bins, 0.995));
}
const infraredBins = new Uint32Array(kBins);

/** Three to seven round distances within a range [mm]. */
export function roundTicks(near_mm: number, far_mm: number, most = 6): number[] {
  const rough = (far_mm - near_mm) / most;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = power * ([1, 2, 5, 10].find((factor) => factor * power >= rough) ?? 10);
  const ticks: number[] = [];
  for (let tick = Math.ceil(near_mm / step) * step; tick <= far_mm; tick += step) ticks.push(tick);
  return ticks;
}
