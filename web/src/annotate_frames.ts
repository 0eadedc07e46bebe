// SPDX-License-Identifier: Apache-2.0
// Opens the frames of the page for labelling: another one, the one that is proposed, or the same again where its labels were changed elsewhere.
import type { AnnotateNotices } from "./annotate_notices.ts";
import type { AnnotateState } from "./annotate_state.ts";
import { aimImage, followRange } from "./annotate_views.ts";
import type { ChangeQueue } from "./change_queue.ts";
import type { FilmStrip } from "./film_strip.ts";
import { fetchFrame, fetchNext, fetchStandings, type Change } from "./label_client.ts";
import { readLabelled } from "./label_protocol.ts";
import type { FrameMessage } from "./protocol.ts";
import { remember } from "./theme.ts";
import { allowInfrared } from "./view_controls.ts";
import type { Views } from "./views.ts";
import type { WorkTimer } from "./work_timer.ts";

const kStandingsAfter_ms = 300;

interface Parts {
  state: AnnotateState;
  views: Views;
  strip: FilmStrip;
  queue: ChangeQueue;
  notices: AnnotateNotices;
  timer: WorkTimer;
}

export class AnnotateFrames {
  #parts: Parts;
  #turn = 0;
  #standingsTimer = 0;

  constructor(parts: Parts) {
    this.#parts = parts;
  }

  /** `early`: the frame, where it was asked for already. */
  async open(frame: number, early: Promise<FrameMessage> | null = null): Promise<void> {
    const count = this.#parts.state.info?.frames ?? 0;
    if (!(frame >= 0 && frame < count)) return;
    const turn = ++this.#turn;
    await this.#parts.notices.attempt(async () => {
      const message = await (early ?? fetchFrame(frame));
      if (turn === this.#turn) this.#take(frame, message);  // else another one was asked for meanwhile
    });
  }

  /** Opens a frame once the changes that were made here are answered: they belong to this one. */
  async leaveFor(frame: () => number | null): Promise<void> {
    await this.#parts.queue.settled();
    const next = frame();
    if (next !== null) await this.open(next);
  }

  step(by: -1 | 1): void {
    const { state, strip } = this.#parts;
    void this.leaveFor(() => state.info && strip.beside(state.frame, by, state.info.frames, state.standings));
  }

  async openProposed(): Promise<void> {
    const { state, queue, notices } = this.#parts;
    await queue.settled();
    await notices.attempt(async () => {
      const next = await fetchNext(state.frame);
      if (next === null) notices.remark("All frames are verified.");
      else await this.open(next);
    });
  }

  /** The frame to go on with once this one's hand is verified; where that was refused, it stays. */
  async goOn(): Promise<void> {
    const { state, strip, queue } = this.#parts;
    await queue.settled();
    if (state.handLabels?.state !== "verified") return;
    if (strip.order === "time") this.step(1);
    else await this.openProposed();
  }

  /** Asks how all frames stand: soon, and once for many changes. */
  askForStandings(): void {
    if (this.#standingsTimer !== 0) return;
    this.#standingsTimer = window.setTimeout(() => {
      this.#standingsTimer = 0;
      const { state, notices } = this.#parts;
      void notices.attempt(async () => {
        state.standings = await fetchStandings();
        state.imageChanged = true;
      });
    }, kStandingsAfter_ms);
  }

  /** Labels were changed, here or elsewhere. */
  takeChange(change: Change): void {
    const { state, queue, notices } = this.#parts;
    this.askForStandings();
    if (change.frame !== state.frame || queue.isPosting || state.drag) return;
    const known = state.labels.find(({ side }) => side === change.side)?.revision ?? 0;
    if (change.revision <= known) return;
    if (known > 0) notices.remark("The labels of this frame were changed elsewhere; what you see now is how they stand.");
    void this.open(state.frame);
  }

  /** The line that tells of changes was opened or lost: what was changed meanwhile is not known. */
  takeConnection(isOpen: boolean): void {
    const { state } = this.#parts;
    if (isOpen && !state.isOpen && state.header) void this.open(state.frame);
    state.isOpen = isOpen;
  }

  #take(frame: number, message: FrameMessage): void {
    const { state, views, timer } = this.#parts;
    const isOther = frame !== state.frame || state.header === null;
    state.images.take(message);
    state.frame = frame;
    state.header = message.header;
    state.labels = readLabelled(message.said).labels;
    if (!state.handLabels && state.labels.length > 0) state.side = state.labels[0]!.side;
    followRange(views, state);
    if (isOther) {
      timer.restart(performance.now());
      views.cloud?.forget();
      aimImage(views, state);
      remember("knuckle.frame", String(frame));
    }
    allowInfrared(views, message.header.infrared);
    views.take();
  }
}
