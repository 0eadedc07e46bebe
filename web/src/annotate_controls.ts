// SPDX-License-Identifier: Apache-2.0
// The controls of the page for labelling and its keys: what each of them does.
import type { AnnotateChanges } from "./annotate_changes.ts";
import type { AnnotateFrames } from "./annotate_frames.ts";
import type { AnnotateState } from "./annotate_state.ts";
import { aimImage, followRange } from "./annotate_views.ts";
import type { FilmStrip, StripOrder } from "./film_strip.ts";
import { kCoarse_px, kDepthStep_mm, kFine_px, listenToFineSteps } from "./fine_steps.ts";
import type { MaskTool, Tool } from "./mask_tool.ts";
import { checkChoice, listenToKeySwitch, listenToPageControls, onChange, onClick, pageShortcuts, press } from "./page_controls.ts";
import { element } from "./panel.ts";
import type { Side } from "./protocol.ts";
import { kTurn_deg, listenToKeys, listenToTurningKeys, listShortcuts, type Shortcut } from "./shortcuts.ts";
import { listenToViewControls, lookingShortcuts, showingShortcuts } from "./view_controls.ts";
import type { Views } from "./views.ts";
import type { WorkTimer } from "./work_timer.ts";

interface Parts {
  state: AnnotateState;
  views: Views;
  mask: MaskTool;
  strip: FilmStrip;
  frames: AnnotateFrames;
  changes: AnnotateChanges;
  timer: WorkTimer;
}

export class AnnotateControls {
  #parts: Parts;

  constructor(parts: Parts) {
    this.#parts = parts;
  }

  listen(): void {
    const { state, views } = this.#parts;
    listenToPageControls();
    listenToViewControls(views, { followRange: () => followRange(views, state), aim: () => this.#aim() });
    this.#listenToControls();
    this.#listenToWork();
    this.#listenToKeys();
  }

  // ---- What they do beside frames and changes ----

  #aim(): void {
    const { state, views } = this.#parts;
    aimImage(views, state);
    views.aimCloud();
  }

  #setOrder(order: StripOrder): void {
    this.#parts.strip.order = order;
    checkChoice("order", order);
    this.#parts.state.imageChanged = true;
  }

  #setModel(isOn: boolean): void {
    this.#parts.state.usesModel = isOn;
    element<HTMLInputElement>("model").checked = isOn;
  }

  #chooseTool(tool: Tool): void {
    this.#parts.mask.tool = tool;
    checkChoice("tool", tool);
    this.#parts.state.imageChanged = true;
  }

  #resizeBrush(by: 1 | -1): void {
    this.#parts.mask.resize(by);
    this.#parts.state.imageChanged = true;
  }

  // ---- Controls ----

  #listenToControls(): void {
    const { state, views, frames, changes } = this.#parts;
    onClick("back", () => frames.step(-1));
    onClick("forward", () => frames.step(1));
    onClick("proposed", () => void frames.openProposed());
    onClick("undo", () => changes.stepBack("undo"));
    onClick("redo", () => changes.stepBack("redo"));
    onClick("verify", () => changes.verify());
    onClick("free", () => changes.free());
    onClick("outline", () => changes.outline());
    onChange("visible", () => changes.toggleVisible());
    onChange("model", (box) => this.#setModel(box.checked));
    onChange("side", (box) => state.chooseSide(box.value as Side));
    onChange("tool", (box) => this.#chooseTool(box.value as Tool));
    onChange("order", (box) => this.#setOrder(box.value as StripOrder));
    onChange("cut", (box) => views.setInSpace("isCut", box.checked));
  }

  /** Whatever is done by hand is work on the frame. */
  #listenToWork(): void {
    const { timer } = this.#parts;
    for (const kind of ["pointermove", "pointerdown", "keydown", "wheel"]) {
      document.addEventListener(kind, () => timer.touch(performance.now()), { capture: true, passive: true });
    }
  }

  // ---- Keys ----

  #listenToKeys(): void {
    const { views, changes } = this.#parts;
    const areOn = listenToKeySwitch();
    const list = this.#shortcuts();
    listenToTurningKeys(views.cloudCanvas, () => views.cloud);
    listenToFineSteps(views.cloudCanvas, areOn, (right, down, away_mm) => changes.nudge(right, down, away_mm));
    this.#listenToUndo();
    listenToKeys(list, areOn);
    listShortcuts(element("shortcuts"), [
      ...list,
      { shown: "Ctrl+Z Ctrl+Y", does: "undo, redo; also Ctrl+Shift+Z" },
      { shown: "← → ↑ ↓", does: `the landmark by ${kFine_px} px, with Shift by ${kCoarse_px}; in the points: turn by ${kTurn_deg}°, with Shift move` },
      { shown: "+ −", does: `the landmark by ${kDepthStep_mm} mm away and nearer, with Shift by 5; in the points: zoom` },
      { shown: "PageUp PageDown", does: "as + and −, also with Shift" },
      { shown: "click drag", does: "place or move the landmark, in the image and on the points; beside a landmark of the points a drag turns them" },
      { shown: "wheel", does: "zoom" },
      { shown: "right\u00a0button", does: "move what is shown" },
    ]);
  }

  /** Control and Z, Y: as everywhere. */
  #listenToUndo(): void {
    const { changes } = this.#parts;
    document.addEventListener("keydown", (event) => {
      if (!(event.ctrlKey || event.metaKey) || !["z", "Z", "y"].includes(event.key) || document.querySelector("dialog[open]")) return;
      event.preventDefault();
      changes.stepBack(event.key === "z" && !event.shiftKey ? "undo" : "redo");
    });
  }

  /** In the order of the list of keys. */
  #shortcuts(): Shortcut[] {
    const { views, strip } = this.#parts;
    return [
      ...this.#frameShortcuts(),
      ...this.#landmarkShortcuts(),
      ...this.#maskShortcuts(),
      { keys: ["o", "O"], shown: "O", does: "frames in time, worst first", act: () => this.#setOrder(strip.order === "time" ? "doubt" : "time") },
      ...showingShortcuts(views),
      { keys: ["c", "C"], shown: "C", does: "points cut at the range of colours", act: () => press("cut") },
      ...lookingShortcuts(views),
      { keys: ["0"], shown: "0", does: "aim both views at the hand", act: () => this.#aim() },
      ...pageShortcuts(),
    ];
  }

  #frameShortcuts(): Shortcut[] {
    const { frames, changes } = this.#parts;
    const goOn = (): void => {
      changes.verify();
      void frames.goOn();
    };
    return [
      { keys: ["."], shown: ".", does: "next frame", act: () => frames.step(1), repeats: true },
      { keys: [","], shown: ",", does: "frame before", act: () => frames.step(-1), repeats: true },
      { keys: ["n", "N"], shown: "N", does: "the frame whose correction changes most", act: () => void frames.openProposed() },
      { keys: ["v", "V"], shown: "V", does: "verify: all of the hand is right", act: () => changes.verify() },
      { keys: ["Enter"], shown: "Enter", does: "verify, and go on", act: goOn },
      { keys: ["z", "Z"], shown: "Z", does: "undo", act: () => changes.stepBack("undo"), repeats: true },
      { keys: ["y", "Y"], shown: "Y", does: "redo", act: () => changes.stepBack("redo"), repeats: true },
    ];
  }

  #landmarkShortcuts(): Shortcut[] {
    const { state, changes } = this.#parts;
    return [
      { keys: ["]"], shown: "]", does: "next landmark", act: () => state.chooseBeside(1), repeats: true },
      { keys: ["["], shown: "[", does: "landmark before", act: () => state.chooseBeside(-1), repeats: true },
      { keys: ["h", "H"], shown: "H", does: "the landmark is visible, hidden", act: () => changes.toggleVisible() },
      { keys: ["u", "U"], shown: "U", does: "the landmark follows the model again", act: () => press("free") },
      { keys: ["m", "M"], shown: "M", does: "hand model on and off", act: () => this.#setModel(!state.usesModel) },
      { keys: ["s", "S"], shown: "S", does: "right hand, left hand", act: () => state.chooseSide(state.side === "right" ? "left" : "right") },
    ];
  }

  #maskShortcuts(): Shortcut[] {
    const { changes } = this.#parts;
    return [
      { keys: ["l", "L"], shown: "L", does: "the pointer places landmarks", act: () => this.#chooseTool("landmarks") },
      { keys: ["b", "B"], shown: "B", does: "it paints the hand's mask", act: () => this.#chooseTool("brush") },
      { keys: ["e", "E"], shown: "E", does: "it erases from the mask", act: () => this.#chooseTool("eraser") },
      { keys: ["{"], shown: "{", does: "a smaller brush", act: () => this.#resizeBrush(-1), repeats: true },
      { keys: ["}"], shown: "}", does: "a larger brush", act: () => this.#resizeBrush(1), repeats: true },
      { keys: ["g", "G"], shown: "G", does: "the mask begins with what was measured on the hand model", act: () => changes.outline() },
    ];
  }
}
