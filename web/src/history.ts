// SPDX-License-Identifier: Apache-2.0
// The last frames, so that one who has paused can look at those before.
import type { FrameMessage } from "./protocol.ts";

const kMostFrames = 90;
const kMostBytes = 48 << 20;

/** Messages in the order in which they came, within bounds of number and memory; `current` is the one that is shown. */
export class History {
  #messages: FrameMessage[] = [];
  #bytes = 0;
  #current = -1;

  /** Takes the newest message, which becomes the current one. */
  add(message: FrameMessage): void {
    this.#messages.push(message);
    this.#bytes += message.buffer.byteLength;
    while (this.#messages.length > 1 && (this.#messages.length > kMostFrames || this.#bytes > kMostBytes)) {
      this.#bytes -= this.#messages.shift()!.buffer.byteLength;
    }
    this.#current = this.#messages.length - 1;
  }

  /** The neighbour of the current message, which becomes the current one; null at the ends. */
  move(by: -1 | 1): FrameMessage | null {
    const message = this.#messages[this.#current + by];
    if (!message) return null;
    this.#current += by;
    return message;
  }

  canGoBack(): boolean {
    return this.#current > 0;
  }

  clear(): void {
    this.#messages = [];
    this.#bytes = 0;
    this.#current = -1;
  }
}
