// SPDX-License-Identifier: Apache-2.0
// What a person changes about labels: asked for here, one change at a time, and shown as it was answered.
import type { AnnotateFrames } from "./annotate_frames.ts";
import type { AnnotateNotices } from "./annotate_notices.ts";
import type { AnnotateState } from "./annotate_state.ts";
import type { ChangeQueue } from "./change_queue.ts";
import type { LabelAnswer, LabelRequest } from "./label_protocol.ts";
import type { MaskTool } from "./mask_tool.ts";
import type { Camera, Point3 } from "./protocol.ts";
import type { Views } from "./views.ts";

interface Parts {
  state: AnnotateState;
  views: Views;
  queue: ChangeQueue;
  frames: AnnotateFrames;
  notices: AnnotateNotices;
}

/** Each change is made when its turn comes, of what the answer before it has said (see ChangeQueue). */
export class AnnotateChanges {
  #parts: Parts;

  constructor(parts: Parts) {
    this.#parts = parts;
  }

  /** All of the hand that is chosen is right. */
  verify(): void {
    this.#parts.queue.add(() => this.#request("verify"));
  }

  /** Undoes or redoes, on whichever frame that was. */
  stepBack(act: "undo" | "redo"): void {
    this.#parts.queue.add(() => ({ act }));
  }

  /** Moves the landmark by a fine step across the image [px], or along the line of sight [mm]. */
  nudge(right: number, down: number, away_mm: number): void {
    const { state, queue } = this.#parts;
    const { landmark, side } = state;
    queue.add(() => {
      const at = state.handOf(side)?.landmarks_mm[landmark];
      return at ? this.#request("move", { side, landmark, point_mm: nudged(at, state.header!.camera, right, down, away_mm) }) : null;
    });
  }

  toggleVisible(): void {
    const { state, queue } = this.#parts;
    const { landmark } = state;
    queue.add(() => {
      const label = state.handLabels?.landmarks[landmark];
      return label ? this.#request("look", { landmark, visible: !label.visible }) : null;
    });
  }

  /** The landmark follows the hand model again. */
  free(): void {
    this.make(this.ofLandmark("free"));
  }

  /** The mask begins with what was measured on the hand model. */
  outline(): void {
    const { state, queue } = this.#parts;
    queue.add(() => ({ act: "outline", frame: state.frame, side: state.side, revision: state.revision }));
  }

  /** What was painted goes to the hand that is chosen. */
  paint(mask: MaskTool): void {
    const { state, queue } = this.#parts;
    const { side } = state;
    const { radius_px } = mask;
    const erases = mask.tool === "eraser";
    for (const points of mask.end()) {
      queue.add(() => ({ act: "brush", frame: state.frame, side, revision: state.revision, points, radius_px, erases }));
    }
    state.imageChanged = true;
  }

  /** A request about the landmark that is chosen, to be previewed or made. */
  ofLandmark(act: LabelRequest["act"], more: Partial<LabelRequest> = {}): LabelRequest {
    return this.#request(act, { landmark: this.#parts.state.landmark, ...more });
  }

  make(wanted: LabelRequest): void {
    const { state, queue } = this.#parts;
    queue.add(() => ({ ...wanted, revision: state.revision }));
  }

  /** Shows what a request would do, while a drag goes on. */
  preview(wanted: LabelRequest): void {
    this.#parts.queue.preview(wanted);
  }

  dropPreview(): void {
    this.#parts.queue.dropPreview();
  }

  async takeAnswer(answer: LabelAnswer): Promise<void> {
    const { state, views, queue, frames, notices } = this.#parts;
    if (answer.fit_ms !== null && answer.fit_ms > 0) state.fit_ms = answer.fit_ms;
    notices.showDisk(answer.fault, answer.waiting);
    if (answer.refused) queue.clear();
    notices.remark(answer.remark);
    frames.askForStandings();
    if (answer.labels.length === 0 && answer.refused) return;  // nothing to undo
    if (answer.record.frame !== state.frame) return frames.open(answer.record.frame);
    state.takeLabels(answer);
    views.take();
  }

  /** The labels as a drag would leave them; their revisions stay, as nothing was changed. */
  takePreview(answer: LabelAnswer): void {
    const { state, views } = this.#parts;
    if (!state.drag || answer.refused || answer.remark !== "") return;
    const revisions = state.labels.map(({ revision }) => revision);
    state.takeLabels(answer);
    state.labels.forEach((labels, i) => { labels.revision = revisions[i] ?? labels.revision; });
    views.take();
  }

  #request(act: LabelRequest["act"], more: Partial<LabelRequest> = {}): LabelRequest {
    const { frame, side, revision, usesModel } = this.#parts.state;
    return { act, frame, side, revision, model: usesModel, ...more };
  }
}

function nudged(at: Point3, camera: Camera, right: number, down: number, away_mm: number): Point3 {
  const depth = camera.model === "orthographic" ? 1 : at[2];
  const growth = camera.model === "orthographic" ? 1 : (at[2] + away_mm) / at[2];
  return [at[0] * growth + (right * depth) / camera.fx, at[1] * growth + (down * depth) / camera.fy, at[2] + away_mm];
}
