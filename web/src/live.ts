// SPDX-License-Identifier: Apache-2.0
// The live page: its parts put together, what comes from the server, and when to draw.
import { Connection, type ConnectionState } from "./connection.ts";
import { LiveControls } from "./live_controls.ts";
import { LivePlaying } from "./live_playing.ts";
import { LiveRecording } from "./live_recording.ts";
import { LiveState } from "./live_state.ts";
import { LiveTexts } from "./live_texts.ts";
import { LiveTiming } from "./live_timing.ts";
import { depthPalette } from "./palette.ts";
import { element, Notices } from "./panel.ts";
import type { FrameMessage, Info } from "./protocol.ts";
import { RangeScale } from "./range_scale.ts";
import { Views } from "./views.ts";

const kNumbersEvery_ms = 250;
const kChartsEvery_ms = 125;
const kChartsEveryWithReducedMotion_ms = 1000;

const palette = depthPalette();
const state = new LiveState();
const views = new Views(state, palette);
const scale = new RangeScale(palette);
const notices = new Notices(element("notices"));
const timing = new LiveTiming();
const texts = new LiveTexts({ state, views, scale, notices });
const playing = new LivePlaying({ state, texts });
const recording = new LiveRecording({ state, notices });
const connection = new Connection({ state: takeConnection, info: takeInfo, frame: takeFrame, malformed: takeMalformed });
const reducedMotion = matchMedia("(prefers-reduced-motion: reduce)");

// ---- What comes from the server ----

function takeConnection(now: ConnectionState): void {
  if (now.is === "open" && state.connection.is !== "open") state.openedAt_ms = performance.now();
  if (now.is === "lost") views.cloud?.forget();
  state.connection = now;
  texts.showConnection();
}

function takeInfo(info: Info): void {
  state.info = info;
  state.recording = info.recording;
  views.redraw();
  texts.showStream();
  recording.show();
}

function takeFrame(message: FrameMessage): void {
  const { header } = message;
  state.lastFrame_ms = performance.now();
  ++state.received;
  timing.takeFrame(state.lastFrame_ms, header.arrived ?? state.received, header.record.latency_ms);
  if (header.recording && !state.isAskingToRecord) state.recording = header.recording;
  playing.take(message);
}

function takeMalformed(reason: string): void {
  ++state.malformed;
  state.lastMalformed_ms = performance.now();
  texts.showMalformed(reason);
}

// ---- When to draw ----

function show(message: FrameMessage, now_ms: number): void {
  state.images.take(message);
  state.header = message.header;
  state.newest = null;
  views.range.follow(state.images.depth, message.header.depth_unit_mm);
  views.take();
  timing.takePicture(now_ms, ++state.shown);
}

function showNumbers(now_ms: number): void {
  texts.showConnection();
  recording.show();
  if (state.connection.is === "open") timing.showNumbers(now_ms);
  texts.showPassing(now_ms);
}

let nextNumbers_ms = 0;
let nextCharts_ms = 0;

function tick(): void {
  const now = performance.now();
  if (views.cloud?.tick(now)) state.cloudChanged = true;
  if (state.newest) show(state.newest, now);
  if (views.draw()) texts.showRecord();
  if (now >= nextNumbers_ms) {
    nextNumbers_ms = now + kNumbersEvery_ms;
    showNumbers(now);
  }
  if (now >= nextCharts_ms) {
    nextCharts_ms = now + (reducedMotion.matches ? kChartsEveryWithReducedMotion_ms : kChartsEvery_ms);
    timing.drawCharts(now);
  }
  requestAnimationFrame(tick);
}

/** Says when the graphics processor is taken away, and leaves no control that does nothing. */
function watchCloud(): void {
  if (views.cloud) {
    views.cloudCanvas.addEventListener("webglcontextlost", () => {
      views.missCloud("The graphics processor was taken away from this page. It comes back by itself, or with reloading.");
    });
    views.cloudCanvas.addEventListener("webglcontextrestored", () => {
      element("cloud-missing").hidden = true;
      state.cloudChanged = true;
    });
  } else {
    for (const control of document.querySelectorAll<HTMLInputElement | HTMLButtonElement>("#cloud-panel input, #cloud-panel button")) control.disabled = true;
  }
}

/** For tests, and for the curious in the browser's console. */
Object.assign(globalThis, {
  knuckle: {
    seenFrom: () => views.cloud?.seenFrom() ?? null,
    frame: () => state.header?.record.frame ?? null,
    header: () => state.header,
    counts: () => ({ received: state.received, shown: state.shown, malformed: state.malformed }),
  },
});

watchCloud();
new LiveControls({ state, views, playing, recording, connection }).listen();
void connection.open();
requestAnimationFrame(tick);
