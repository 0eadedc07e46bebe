// SPDX-License-Identifier: Apache-2.0
// The controls of the live page and its keys: what each of them does.
import type { Connection } from "./connection.ts";
import type { LivePlaying } from "./live_playing.ts";
import type { LiveRecording } from "./live_recording.ts";
import type { LiveState } from "./live_state.ts";
import { listenToKeySwitch, listenToPageControls, onClick, pageShortcuts, press } from "./page_controls.ts";
import { describeHands, element } from "./panel.ts";
import { composePicture, download } from "./screenshot.ts";
import { kTurn_deg, kZoom, listenToKeys, listenToTurningKeys, listShortcuts, type Shortcut } from "./shortcuts.ts";
import { listenToViewControls, lookingShortcuts, showingShortcuts, showProbe } from "./view_controls.ts";
import type { Views } from "./views.ts";

interface Parts {
  state: LiveState;
  views: Views;
  playing: LivePlaying;
  recording: LiveRecording;
  connection: Connection;
}

export class LiveControls {
  #parts: Parts;

  constructor(parts: Parts) {
    this.#parts = parts;
  }

  listen(): void {
    const { views } = this.#parts;
    listenToPageControls();
    listenToViewControls(views, { followRange: () => this.#followRange(), aim: () => views.aimCloud() });
    this.#listenToControls();
    this.#listenToKeys();
  }

  #followRange(): void {
    const { state: { header, images }, views } = this.#parts;
    if (header) views.range.follow(images.depth, header.depth_unit_mm);
  }

  #listenToControls(): void {
    const { views, playing, recording } = this.#parts;
    onClick("pause", () => playing.toggle());
    onClick("step", () => playing.step(1));
    onClick("back", () => playing.step(-1));
    onClick("record", () => void recording.toggle());
    onClick("screenshot", () => void this.#takeScreenshot());
    onClick("zoom-in", () => views.cloud?.zoom(kZoom));
    onClick("zoom-out", () => views.cloud?.zoom(1 / kZoom));
    views.imageCanvas.addEventListener("pointermove", (event) => showProbe(views, event));
    views.imageCanvas.addEventListener("pointerleave", () => { element("probe").hidden = true; });
  }

  async #takeScreenshot(): Promise<void> {
    const { state: { header, info }, views } = this.#parts;
    if (!header) return;
    const { record } = header;
    views.drawImage();
    views.drawCloud();
    const canvases = [views.imageCanvas];
    if (views.cloud) canvases.push(views.cloudCanvas);
    const time = record.time_s === null ? "" : `, ${record.time_s.toFixed(3)} s`;
    const said = describeHands(record.hands, record.status);
    const picture = composePicture(canvases, `Knuckle   ${info?.source ?? ""}   frame ${record.frame}${time}   ${said}`);
    await download(picture, `knuckle-${String(record.frame).padStart(6, "0")}.png`);
  }

  #listenToKeys(): void {
    const { views } = this.#parts;
    const areOn = listenToKeySwitch();
    const list = this.#shortcuts();
    listenToKeys(list, areOn);
    listenToTurningKeys(views.cloudCanvas, () => views.cloud);
    listShortcuts(element("shortcuts"), [
      ...list,
      { shown: "← → ↑ ↓", does: `in the points: turn by ${kTurn_deg}°; with Shift: move` },
      { shown: "+ −", does: "in the points: zoom" },
    ]);
  }

  /** In the order of the list of keys. */
  #shortcuts(): Shortcut[] {
    const { views, playing, connection } = this.#parts;
    return [
      { keys: [" "], shown: "Space", does: "pause, play", act: () => press("pause") },
      { keys: ["."], shown: ".", does: "pause, and one frame on", act: () => playing.step(1), repeats: true },
      { keys: [","], shown: ",", does: "pause, and one frame back", act: () => playing.step(-1), repeats: true },
      { keys: ["r", "R"], shown: "R", does: "start and stop a recording", act: () => press("record") },
      { keys: ["s", "S"], shown: "S", does: "save a screenshot (PNG)", act: () => press("screenshot") },
      ...showingShortcuts(views),
      { keys: ["a", "A"], shown: "A", does: "range of colours automatic or fixed", act: () => press("range-auto") },
      ...lookingShortcuts(views),
      { keys: ["0"], shown: "0", does: "aim at the hand again", act: () => views.aimCloud() },
      { keys: ["c", "C"], shown: "C", does: "try to connect now", act: () => connection.retry() },
      ...pageShortcuts(),
    ];
  }
}
