// SPDX-License-Identifier: Apache-2.0
// How many points are drawn: fewer where the machine cannot show enough pictures with them.

const kLook_ms = 1000;
const kSlow_perSecond = 15;
const kFast_perSecond = 45;
const kFewest = 8000;

export class PointBudget {
  #most: number;
  #points: number;
  #since_ms = Number.NaN;
  #last_ms = Number.NaN;
  #pictures = 0;

  constructor(most: number) {
    this.#most = this.#points = most;
  }

  get points(): number {
    return this.#points;
  }

  /** To be called before each of the browser's pictures, whether it differs or not; true where the budget has changed. */
  tick(now_ms: number): boolean {
    const paused = !(now_ms - this.#last_ms < kLook_ms);  // in the background no pictures are made
    this.#last_ms = now_ms;
    if (paused) this.#begin(now_ms);
    else ++this.#pictures;
    const passed_ms = now_ms - this.#since_ms;
    if (passed_ms < kLook_ms) return false;
    const before = this.#points;
    const rate = (1000 * this.#pictures) / passed_ms;
    if (rate < kSlow_perSecond) this.#points = Math.max(kFewest, this.#points / 2);
    else if (rate > kFast_perSecond) this.#points = Math.min(this.#most, this.#points * 2);
    this.#begin(now_ms);
    return this.#points !== before;
  }

  #begin(now_ms: number): void {
    this.#since_ms = now_ms;
    this.#pictures = 0;
  }
}
