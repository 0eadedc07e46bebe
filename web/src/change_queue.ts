// SPDX-License-Identifier: Apache-2.0
// Changes on their way to the server, one at a time: each is made of what the last one's answer says.
import { postChange } from "./label_client.ts";
import type { LabelAnswer, LabelRequest } from "./label_protocol.ts";

/** What the page does with answers, and with what may fail. */
export interface ChangeHandlers {
  attempt: (act: () => Promise<void>) => Promise<void>;
  takeAnswer: (answer: LabelAnswer) => Promise<void>;
  takePreview: (answer: LabelAnswer) => void;
  /** The seconds that were worked since the last change. */
  takeSeconds: () => number;
}

export class ChangeQueue {
  answered_ms: number | null = null;  // from the last change to its answer
  drawn_ms: number | null = null;  // from the last change until its answer was seen; null until then
  undrawnSince: number | null = null;  // when the change was made whose answer is not drawn yet

  #handlers: ChangeHandlers;
  #waiting: (() => LabelRequest | null)[] = [];
  #isPosting = false;
  #nextPreview: LabelRequest | null = null;
  #isPreviewing = false;

  constructor(handlers: ChangeHandlers) {
    this.#handlers = handlers;
  }

  get isPosting(): boolean {
    return this.#isPosting;
  }

  get isQuiet(): boolean {
    return !this.#isPosting && !this.#isPreviewing;
  }

  /** `make` is called when the change's turn comes; null: there is nothing to do any more. */
  add(make: () => LabelRequest | null): void {
    this.#waiting.push(make);
    if (!this.#isPosting) void this.#postAll();
  }

  /** Forgets what has not been sent. */
  clear(): void {
    this.#waiting.length = 0;
  }

  /** Until all changes are answered. */
  async settled(): Promise<void> {
    while (this.#isPosting) await new Promise((done) => setTimeout(done, 5));
  }

  /** What a drag would do is asked for as often as it is answered. */
  preview(wanted: LabelRequest): void {
    this.#nextPreview = { ...wanted, preview: true };
    if (!this.#isPreviewing) void this.#previewAll();
  }

  dropPreview(): void {
    this.#nextPreview = null;
  }

  /** What was undrawn since then, when the views were drawn, is seen now. */
  noteDrawn(since: number | null): void {
    if (since === null || since !== this.undrawnSince) return;
    this.drawn_ms = performance.now() - since;
    this.undrawnSince = null;
  }

  async #postAll(): Promise<void> {
    this.#isPosting = true;
    while (this.#waiting.length > 0) {
      const made = this.#waiting.shift()!();
      if (!made) continue;
      const wanted = { ...made, seconds: this.#handlers.takeSeconds() };
      await this.#handlers.attempt(async () => {
        const begin = performance.now();
        this.drawn_ms = null;
        const answer = await postChange(wanted);
        this.answered_ms = performance.now() - begin;
        await this.#handlers.takeAnswer(answer);
        this.undrawnSince = begin;
      });
    }
    this.#isPosting = false;
  }

  async #previewAll(): Promise<void> {
    this.#isPreviewing = true;
    while (this.#nextPreview) {
      const wanted = this.#nextPreview;
      this.#nextPreview = null;
      await this.#handlers.attempt(async () => { this.#handlers.takePreview(await postChange(wanted)); });
    }
    this.#isPreviewing = false;
  }
}
