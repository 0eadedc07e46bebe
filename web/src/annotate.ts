// SPDX-License-Identifier: Apache-2.0
// The page for labelling: its parts put together, and when they are drawn.
import { AnnotateChanges } from "./annotate_changes.ts";
import { AnnotateControls } from "./annotate_controls.ts";
import { AnnotateFrames } from "./annotate_frames.ts";
import { AnnotateNotices } from "./annotate_notices.ts";
import { AnnotatePointer } from "./annotate_pointer.ts";
import { AnnotateState } from "./annotate_state.ts";
import { AnnotateTexts } from "./annotate_texts.ts";
import { drawLabels } from "./annotate_views.ts";
import { ChangeQueue } from "./change_queue.ts";
import { FilmStrip } from "./film_strip.ts";
import { fetchFrame, fetchInfo, listenToChanges } from "./label_client.ts";
import { MaskTool } from "./mask_tool.ts";
import { depthPalette } from "./palette.ts";
import { element } from "./panel.ts";
import type { Point2, Point3 } from "./protocol.ts";
import { Views } from "./views.ts";
import { WorkTimer } from "./work_timer.ts";

// Asked for before anything is set up: opening WebGL takes a while, in which the program can answer.
const firstFrame = Math.max(0, Math.trunc(Number(new URLSearchParams(location.search).get("frame") ?? "0")) || 0);
const first = { info: fetchInfo(), frame: fetchFrame(firstFrame) };
for (const answer of Object.values(first)) answer.catch(() => undefined);  // whoever waits for it hears of it

const kCloseness = 2.2;  // of the points: the hand fills the view

const palette = depthPalette();
const state = new AnnotateState();
const views = new Views(state, palette);
views.image.namesHands = false;
if (views.cloud) views.cloud.closeness = kCloseness;
const mask = new MaskTool();
const timer = new WorkTimer(performance.now());
const notices = new AnnotateNotices();
const strip = new FilmStrip(element("strip"), palette, (frame) => void frames.leaveFor(() => frame));
const queue = new ChangeQueue({
  attempt: (act) => notices.attempt(act),
  takeAnswer: (answer) => changes.takeAnswer(answer),
  takePreview: (answer) => changes.takePreview(answer),
  takeSeconds: () => timer.take_s(performance.now()),
});
const frames = new AnnotateFrames({ state, views, strip, queue, notices, timer });
const changes = new AnnotateChanges({ state, views, queue, frames, notices });
const texts = new AnnotateTexts({ state, strip, mask, timer });

async function begin(): Promise<void> {
  await notices.attempt(async () => {
    const info = await first.info;
    state.info = info;
    state.landmark = info.landmarks[0] ?? "wrist";
    texts.showInfo(info);
    await (firstFrame < info.frames ? frames.open(firstFrame, first.frame) : frames.open(0));
    frames.askForStandings();
  });
  listenToChanges((change) => frames.takeChange(change), (isOpen) => {
    frames.takeConnection(isOpen);
    texts.showConnection(isOpen);
    notices.showConnection(isOpen);
  });
}

function tick(): void {
  if (views.draw()) {
    drawLabels(views, state, mask);
    texts.show();
    const since = queue.undrawnSince;
    requestAnimationFrame(() => queue.noteDrawn(since));  // the next picture begins when this one is done
  }
  texts.showTimer();
  requestAnimationFrame(tick);
}

/** For tests, and for the curious in the browser's console. */
Object.assign(globalThis, {
  knuckle: {
    frame: () => state.frame,
    open: (frame: number) => void frames.open(frame),
    header: () => state.header,
    labels: () => state.labels,
    isQuiet: () => queue.isQuiet && !state.imageChanged && state.header !== null,
    imageAt: (at: Point2) => views.image.canvasAt(at),
    cloudAt: (at: Point3) => views.cloud?.canvasAt(at) ?? null,
    landmark: () => state.landmark,
    tool: () => mask.tool,
    brush_px: () => mask.radius_px,
    placeAt: (x: number, y: number) => views.image.placeAt(x, y),
    answered_ms: () => queue.answered_ms,
    drawn_ms: () => queue.drawn_ms,
    fit_ms: () => state.fit_ms,
    standings: () => state.standings,
    depth_mm: (column: number, row: number) => (state.images.depth[row * state.images.width + column] ?? 0) * (state.header?.depth_unit_mm ?? 0),
  },
});

new AnnotateControls({ state, views, mask, strip, frames, changes, timer }).listen();
new AnnotatePointer({ state, views, mask, frames, changes }).listen();
void begin();
requestAnimationFrame(tick);
