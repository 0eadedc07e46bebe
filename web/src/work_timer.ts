// SPDX-License-Identifier: Apache-2.0
// The time that a person works on a frame: pauses do not count.

const kPause_ms = 30_000;  // without a key or a move of the pointer for so long, nobody works

export class WorkTimer {
  #total_ms = 0;
  #since_ms = 0;  // what the next change takes along
  #last_ms: number;

  constructor(now_ms: number) {
    this.#last_ms = now_ms;
  }

  /** Something was done by hand. */
  touch(now_ms: number): void {
    const passed = Math.min(Math.max(0, now_ms - this.#last_ms), kPause_ms);
    this.#total_ms += passed;
    this.#since_ms += passed;
    this.#last_ms = now_ms;
  }

  /** Another frame is worked on. */
  restart(now_ms: number): void {
    this.#total_ms = 0;
    this.#since_ms = 0;
    this.#last_ms = now_ms;
  }

  /** Seconds since the last change, which then belong to that one. */
  take_s(now_ms: number): number {
    this.touch(now_ms);
    const seconds = this.#since_ms / 1000;
    this.#since_ms = 0;
    return seconds;
  }

  total_s(now_ms: number): number {
    return (this.#total_ms + Math.min(Math.max(0, now_ms - this.#last_ms), kPause_ms)) / 1000;
  }
}
