// SPDX-License-Identifier: Apache-2.0
// The pointer on the image and the points: it chooses, places and moves landmarks, paints masks, and moves the image.
import type { AnnotateChanges } from "./annotate_changes.ts";
import type { AnnotateFrames } from "./annotate_frames.ts";
import type { AnnotateState, Drag } from "./annotate_state.ts";
import { middleOf, zoomAt } from "./image_aim.ts";
import type { LabelRequest } from "./label_protocol.ts";
import type { MaskTool } from "./mask_tool.ts";
import type { Hand, Point2, Side } from "./protocol.ts";
import { showProbe } from "./view_controls.ts";
import type { Views } from "./views.ts";

const kReach_px = 14;  // of a landmark around the pointer
const kMoves_px = 2;  // less is a click that trembles
const kWheelZoom = 1.2;

interface Parts {
  state: AnnotateState;
  views: Views;
  mask: MaskTool;
  frames: AnnotateFrames;
  changes: AnnotateChanges;
}

export class AnnotatePointer {
  #parts: Parts;
  #press: Point2 | null = null;  // of a pointer that is held down beside all landmarks of the points, and has not moved yet

  constructor(parts: Parts) {
    this.#parts = parts;
  }

  listen(): void {
    const { imageCanvas, cloudCanvas } = this.#parts.views;
    imageCanvas.addEventListener("pointerdown", (event) => this.#beginInImage(event));
    imageCanvas.addEventListener("contextmenu", (event) => event.preventDefault());
    imageCanvas.addEventListener("wheel", (event) => this.#zoom(event), { passive: false });
    cloudCanvas.addEventListener("pointerdown", (event) => this.#beginInCloud(event), { capture: true });
    cloudCanvas.addEventListener("pointermove", (event) => this.#turnInCloud(event));
    cloudCanvas.addEventListener("pointerup", () => this.#clickInCloud());
    for (const canvas of [imageCanvas, cloudCanvas]) {
      canvas.addEventListener("pointermove", (event) => this.#move(canvas, event));
      canvas.addEventListener("pointerup", () => this.#end());
      canvas.addEventListener("pointercancel", () => this.#cancel());
    }
  }

  // ---- Down ----

  #beginInImage(event: PointerEvent): void {
    const { state, views, mask } = this.#parts;
    if (!state.header) return;
    const at: Point2 = [event.offsetX, event.offsetY];
    if (event.button !== 0) {
      views.image.centre ??= middleOf(state.header);
      state.drag = { view: "image", from: at, at, start: null, hasMoved: false, pans: views.image.centre };
    } else if (mask.tool !== "landmarks") {
      mask.begin(views.image.placeAt(...at));
      state.imageChanged = true;
    } else {
      this.#beginLandmark(at);
    }
    views.imageCanvas.setPointerCapture(event.pointerId);
  }

  /** Chooses the landmark under the pointer, or places the one that is chosen there. */
  #beginLandmark(at: Point2): void {
    const { state, changes } = this.#parts;
    const found = this.#landmarkAt(...at, this.#inImage);
    if (found) this.#choose(found);
    // One that is only chosen stays where it is until the pointer moves.
    state.drag = { view: "image", from: at, at, start: null, hasMoved: found === null, pans: null };
    if (!found) changes.preview(this.#wanted(state.drag)!);
  }

  /** Takes a landmark of the points; beside one, the view is turned, or a click places the one that is chosen. */
  #beginInCloud(event: PointerEvent): void {
    const { state, views } = this.#parts;
    const at: Point2 = [event.offsetX, event.offsetY];
    const found = event.button === 0 ? this.#landmarkAt(...at, this.#inCloud) : null;
    this.#press = event.button === 0 && event.isPrimary && !found ? at : null;
    if (!found || !views.cloud) return;
    views.cloud.hold(true);
    this.#choose(found);
    const start = state.hand?.landmarks_mm[state.landmark] ?? null;
    state.drag = { view: "cloud", from: at, at, start, hasMoved: false, pans: null };
    views.cloudCanvas.setPointerCapture(event.pointerId);
  }

  /** What moves is no click: it turns the view. */
  #turnInCloud(event: PointerEvent): void {
    const press = this.#press;
    if (press && Math.hypot(event.offsetX - press[0], event.offsetY - press[1]) > kMoves_px) this.#press = null;
  }

  /** Places the landmark that is chosen on the measured point that was clicked, as on its pixel of the image. */
  #clickInCloud(): void {
    const { views: { cloud }, mask, changes } = this.#parts;
    const pixel = this.#press && mask.tool === "landmarks" ? cloud?.pixelAt(...this.#press) : null;
    this.#press = null;
    if (pixel) changes.make(changes.ofLandmark("place", { pixel }));
  }

  #choose({ side, name }: { side: Side; name: string }): void {
    this.#parts.state.chooseSide(side);
    this.#parts.state.choose(name);
  }

  // ---- Moves ----

  #move(canvas: HTMLCanvasElement, event: PointerEvent): void {
    const { state, views, mask, changes } = this.#parts;
    const isImage = canvas === views.imageCanvas;
    if (isImage && mask.tool !== "landmarks") {
      mask.move(views.image.placeAt(event.offsetX, event.offsetY));
      state.imageChanged = true;
    }
    const { drag } = state;
    if (!drag || (drag.view === "image") !== isImage) {
      if (isImage) showProbe(views, event);
      return;
    }
    drag.at = [event.offsetX, event.offsetY];
    if (drag.pans) return this.#pan(drag, drag.pans);
    if (Math.hypot(drag.at[0] - drag.from[0], drag.at[1] - drag.from[1]) > kMoves_px) drag.hasMoved = true;
    if (drag.hasMoved) changes.preview(this.#wanted(drag)!);
  }

  #pan(drag: Drag, centre: Point2): void {
    const { state, views: { image } } = this.#parts;
    const from = image.placeAt(...drag.from);
    const at = image.placeAt(...drag.at);
    image.centre = [centre[0] + from[0] - at[0], centre[1] + from[1] - at[1]];
    state.imageChanged = true;
  }

  #zoom(event: WheelEvent): void {
    event.preventDefault();
    const { state, views } = this.#parts;
    if (!state.header) return;
    zoomAt(views.image, event.deltaY < 0 ? kWheelZoom : 1 / kWheelZoom, event.offsetX, event.offsetY, state.header);
    state.imageChanged = true;
  }

  // ---- Up ----

  #end(): void {
    const { state: { drag }, mask, changes } = this.#parts;
    if (mask.stroke) changes.paint(mask);
    if (!drag) return;
    const wanted = drag.hasMoved && !drag.pans ? this.#wanted(drag) : null;
    this.#drop();
    if (wanted) changes.make(wanted);
  }

  /** The browser took the pointer away: all is as it was. */
  #cancel(): void {
    const { state, mask, frames } = this.#parts;
    this.#press = null;
    mask.drop();
    if (state.drag) this.#drop();
    void frames.open(state.frame);
  }

  #drop(): void {
    const { state, views, changes } = this.#parts;
    state.drag = null;
    changes.dropPreview();
    views.cloud?.hold(false);
  }

  /** What a drag of a landmark asks for where the pointer is. */
  #wanted({ view, from, at, start }: Drag): LabelRequest | null {
    const { views: { image, cloud }, changes } = this.#parts;
    if (view === "image") return changes.ofLandmark("place", { pixel: image.placeAt(...at) });
    if (!start || !cloud) return null;
    return changes.ofLandmark("move", { point_mm: cloud.movedOnScreen(start, at[0] - from[0], at[1] - from[1]) });
  }

  // ---- What lies under it ----

  /** The landmark that is chosen, where it is near the pointer; else the nearest one, of any hand; null where none is near. */
  #landmarkAt(x: number, y: number, canvasAt: (hand: Hand, name: string) => Point2 | null): { side: Side; name: string } | null {
    const { state } = this.#parts;
    const ofChosen = state.hand && canvasAt(state.hand, state.landmark);
    if (ofChosen && Math.hypot(ofChosen[0] - x, ofChosen[1] - y) <= kReach_px) return { side: state.side, name: state.landmark };
    let nearest: { side: Side; name: string } | null = null;
    let least = kReach_px;
    for (const hand of state.header?.record.hands ?? []) {
      for (const name of Object.keys(hand.landmarks_px)) {
        const at = canvasAt(hand, name);
        const distance = at ? Math.hypot(at[0] - x, at[1] - y) : Infinity;
        if (distance > least || hand.side === null) continue;
        least = distance;
        nearest = { side: hand.side, name };
      }
    }
    return nearest;
  }

  #inImage = (hand: Hand, name: string): Point2 | null => {
    const at = hand.landmarks_px[name];
    return at ? this.#parts.views.image.canvasAt(at) : null;
  };

  #inCloud = (hand: Hand, name: string): Point2 | null => {
    const at = hand.landmarks_mm[name];
    return at ? (this.#parts.views.cloud?.canvasAt(at) ?? null) : null;
  };
}
