// SPDX-License-Identifier: Apache-2.0
// Which frames the live page shows: those that come, or, once paused, those that are stepped to.
import { History } from "./history.ts";
import type { LiveState } from "./live_state.ts";
import type { LiveTexts } from "./live_texts.ts";
import { element, setText } from "./panel.ts";
import type { FrameMessage } from "./protocol.ts";

interface Parts {
  state: LiveState;
  texts: LiveTexts;
}

export class LivePlaying {
  #parts: Parts;
  #history = new History();

  constructor(parts: Parts) {
    this.#parts = parts;
  }

  /** The newest frame wins: one that has not been drawn when the next comes is never drawn. */
  take(message: FrameMessage): void {
    const { state } = this.#parts;
    if (state.isPaused && !state.isStepping) return;
    state.isStepping = false;
    this.#history.add(message);
    state.newest = message;
  }

  toggle(): void {
    this.#setPaused(!this.#parts.state.isPaused);
  }

  /** One frame on: a later one that is remembered, or else the next that comes. One back: of those remembered. */
  step(by: -1 | 1): void {
    const { state } = this.#parts;
    if (!state.isPaused) this.#setPaused(true);
    const message = this.#history.move(by);
    if (message) state.newest = message;
    else if (by === 1) state.isStepping = true;
    this.#showStepping();
  }

  #setPaused(isPaused: boolean): void {
    const { state, texts } = this.#parts;
    state.isPaused = isPaused;
    state.isStepping = false;
    const button = element("pause");
    button.setAttribute("aria-pressed", String(isPaused));
    setText(button.querySelector(".label")!, isPaused ? "Play" : "Pause");
    button.title = isPaused ? "Play (space)" : "Pause (space)";
    this.#showStepping();
    texts.showConnection();
  }

  #showStepping(): void {
    const { isPaused } = this.#parts.state;
    element<HTMLButtonElement>("step").disabled = !isPaused;
    element<HTMLButtonElement>("back").disabled = !isPaused || !this.#history.canGoBack();
  }
}
