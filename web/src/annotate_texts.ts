// SPDX-License-Identifier: Apache-2.0
// What the page for labelling says of the frame, its hand and its landmarks, and how far the person has come.
import type { AnnotateState } from "./annotate_state.ts";
import type { FilmStrip } from "./film_strip.ts";
import type { HandLabels, LabelInfo } from "./label_protocol.ts";
import { inWords, LandmarkList } from "./landmark_list.ts";
import { pixelsIn, type MaskTool } from "./mask_tool.ts";
import { Announcer, element, setText } from "./panel.ts";
import type { WorkTimer } from "./work_timer.ts";

interface Parts {
  state: AnnotateState;
  strip: FilmStrip;
  mask: MaskTool;
  timer: WorkTimer;
}

export class AnnotateTexts {
  #parts: Parts;
  #landmarkList: LandmarkList;
  #announcer = new Announcer(element("announcer"));

  constructor(parts: Parts) {
    this.#parts = parts;
    this.#landmarkList = new LandmarkList(element("landmarks"), (landmark) => parts.state.choose(landmark));
  }

  /** What stays as long as the page is open; to be called once. */
  showInfo(info: LabelInfo): void {
    this.#landmarkList.make(info.landmarks);
    setText(element("source"), info.source);
    setText(element("file"), `${info.file}, by ${info.author}`);
    setText(element("version"), `Knuckle ${info.version}`);
    document.title = `${info.source} – Knuckle annotate`;
  }

  /** All that follows from the state; what is said by colours over the image, too, is drawn elsewhere. */
  show(): void {
    const { state, strip } = this.#parts;
    if (!state.info || !state.header) return;
    const labels = state.handLabels;
    const { name } = state.header.record;
    setText(element("frame"), `${state.frame} of ${state.info.frames}${name && name !== String(state.frame) ? ` (${name})` : ""}`);
    this.#showHand(labels);
    this.#showProgress(state.info.frames);
    this.#showLandmarks(labels);
    strip.show(state.frame, state.info.frames, state.standings);
    const said = labels?.landmarks[state.landmark]?.state ?? "not labelled";
    this.#announcer.update(`Frame ${state.frame}, ${inWords(state.landmark)}, ${said}`, performance.now());
  }

  showTimer(): void {
    const { state, timer } = this.#parts;
    const before = state.labels.length > 0 ? `; before: ${(state.handLabels?.seconds ?? 0).toFixed(0)} s` : "";
    setText(element("timer"), `${timer.total_s(performance.now()).toFixed(0)} s${before}`);
  }

  showConnection(isOpen: boolean): void {
    element("connection").dataset["state"] = isOpen ? "open" : "lost";
    setText(element("connection-text"), isOpen ? "Connected" : "No connection");
  }

  #showHand(labels: HandLabels | null): void {
    const { state, mask } = this.#parts;
    setText(element("hand-state"), labels ? `${labels.side}, ${labels.state}, by ${labels.author}` : `no ${state.side} hand is labelled`);
    const fit = labels && labels.rms_mm !== null ? `${labels.rms_mm.toFixed(1)} mm from the labels, skin ${labels.gap_mm?.toFixed(1) ?? "–"} mm` : "–";
    setText(element("fit"), state.fit_ms === null ? fit : `${fit}; ${state.fit_ms.toFixed(0)} ms`);
    const size = labels?.mask ? `${pixelsIn(labels.mask)} px` : "none";
    setText(element("mask"), mask.tool === "landmarks" ? size : `${size}; ${mask.tool} of ${mask.radius_px} px`);
    const empty = element("empty");
    empty.hidden = labels !== null;
    setText(empty, `No ${state.side} hand is labelled here. Click to place: ${inWords(state.landmark)}.`);
    for (const box of document.querySelectorAll<HTMLInputElement>("#side input")) box.checked = box.value === state.side;
  }

  #showProgress(frames: number): void {
    const { standings } = this.#parts.state;
    const verified = standings ? [...standings.states].filter((letter) => letter === "v").length : 0;
    const pace = standings?.median_s == null ? "" : `, ${standings.median_s.toFixed(0)} s per hand`;
    setText(element("progress"), standings ? `${verified} of ${frames} frames${pace}` : "–");
  }

  #showLandmarks(labels: HandLabels | null): void {
    const { state } = this.#parts;
    this.#landmarkList.show(labels, state.landmark);
    const label = labels?.landmarks[state.landmark] ?? null;
    const visible = element<HTMLInputElement>("visible");
    visible.disabled = !label;
    visible.checked = label?.visible ?? false;
    element<HTMLButtonElement>("free").disabled = !label || label.state !== "corrected";
    element<HTMLButtonElement>("verify").disabled = !labels;
  }
}
