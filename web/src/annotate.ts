// SPDX-License-Identifier: Apache-2.0
// The page for labelling: what is known, what the user does, and when to draw.
import { ChangeQueue } from "./change_queue.ts";
import { CloudView, type Viewpoint } from "./cloud_view.ts";
import { DepthRange } from "./depth_range.ts";
import { kCoarse_px, kDepthStep_mm, kFine_px, listenToFineSteps } from "./fine_steps.ts";
import { FilmStrip, type StripOrder } from "./film_strip.ts";
import { aimAt, middleOf, zoomAt } from "./image_aim.ts";
import { ImageView, type ImageKind } from "./image_view.ts";
import {
  fetchFrame, fetchInfo, fetchNext, fetchStandings, listenToChanges, Refusal, type Change,
} from "./label_client.ts";
import { readLabelled, type HandLabels, type LabelAnswer, type Labelled, type LabelInfo, type LabelRequest, type Standings } from "./label_protocol.ts";
import { drawLabelMarks } from "./label_marks.ts";
import { inWords, LandmarkList } from "./landmark_list.ts";
import { MaskTool, pixelsIn, type Tool } from "./mask_tool.ts";
import { depthPalette } from "./palette.ts";
import { Announcer, element, Notices, setText } from "./panel.ts";
import { FrameImages, MessageError, type FrameHeader, type FrameMessage, type Hand, type Point2, type Point3, type Side } from "./protocol.ts";
import { kTurn_deg, listenToKeys, listenToTurningKeys, listShortcuts, type Shortcut } from "./shortcuts.ts";
import { currentTheme, nextTheme, remember, remembered, restoreTheme } from "./theme.ts";
import { WorkTimer } from "./work_timer.ts";

// Asked for before anything is set up: opening WebGL takes a while, in which the program can answer.
const firstFrame = Math.max(0, Math.trunc(Number(new URLSearchParams(location.search).get("frame") ?? "0")) || 0);
const first = { info: fetchInfo(), frame: fetchFrame(firstFrame) };
for (const answer of Object.values(first)) answer.catch(() => undefined);  // whoever waits for it hears of it

const kReach_px = 14;  // of a landmark around the pointer
const kCloseness = 2.2;  // of the points: the hand fills the view
const kRangeMargin_mm = 30;  // joints lie 10 to 20 mm below the skin; more, and fingers are hard to tell apart
const kRemarkShown_ms = 8000;

/** All that the page knows; what is seen follows from it. */
const state = {
  info: null as LabelInfo | null,
  frame: 0,
  header: null as FrameHeader | null,
  labels: [] as HandLabels[],
  side: "right" as Side,
  landmark: "wrist",
  standings: null as Standings | null,
  usesModel: true,
  isOpen: false,  // the line that tells of changes
  drag: null as { view: "image" | "cloud"; from: Point2; at: Point2; start: Point3 | null; hasMoved: boolean; pans: Point2 | null } | null,
  fit_ms: null as number | null,
  imageChanged: false,
  cloudChanged: false,
};

const palette = depthPalette();
const images = new FrameImages();
const range = new DepthRange();
const imageCanvas = element<HTMLCanvasElement>("image");
const cloudCanvas = element<HTMLCanvasElement>("cloud");
const imageView = new ImageView(imageCanvas, palette);
imageView.namesHands = false;
const cloudView = openCloudView();
if (cloudView) cloudView.closeness = kCloseness;
const maskTool = new MaskTool();
const strip = new FilmStrip(element("strip"), palette, (frame) => void leaveFor(() => frame));
const landmarkList = new LandmarkList(element("landmarks"), choose);
const notices = new Notices(element("notices"));
const announcer = new Announcer(element("announcer"));
const timer = new WorkTimer(performance.now());
const changes = new ChangeQueue({ attempt, takeAnswer, takePreview, takeSeconds: () => timer.take_s(performance.now()) });

function openCloudView(): CloudView | null {
  try {
    return new CloudView(cloudCanvas, palette, () => { state.cloudChanged = true; });
  } catch {
    cloudCanvas.hidden = true;
    const placard = element("cloud-missing");
    setText(placard, "This browser has no WebGL 2, so points in space cannot be drawn. The image works without it.");
    placard.hidden = false;
    return null;
  }
}

// ---- What is known ----

function hand(): Hand | null {
  return state.header?.record.hands.find(({ side }) => side === state.side) ?? null;
}

function handLabels(): HandLabels | null {
  return state.labels.find(({ side }) => side === state.side) ?? null;
}

function bones(): [string, string][] {
  return state.info?.bones ?? [];
}

function takeLabels(labelled: Labelled): void {
  if (!state.header) return;
  state.header.record = labelled.record;
  state.header.surface = labelled.surface;
  state.labels = labelled.labels;
  redraw();
}

function redraw(): void {
  if (state.header) cloudView?.take(images, state.header, bones());
  state.imageChanged = state.cloudChanged = true;
}

/** Does something that may fail, and says why it did. */
async function attempt(act: () => Promise<void>): Promise<void> {
  try {
    await act();
  } catch (error) {
    if (!(error instanceof Refusal) && !(error instanceof MessageError)) throw error;
    remark(error instanceof MessageError ? `The server's answer cannot be read: ${error.message}.` : error.message);
  }
}

let remarkTimer = 0;

function remark(text: string): void {
  clearTimeout(remarkTimer);
  notices.set("remark", text === "" ? null : text);
  if (text !== "") remarkTimer = window.setTimeout(() => notices.set("remark", null), kRemarkShown_ms);
}

// ---- Frames ----

let opening = 0;

/** `early`: the frame, where it was asked for already. */
async function openFrame(frame: number, early: Promise<FrameMessage> | null = null): Promise<void> {
  const count = state.info?.frames ?? 0;
  if (!(frame >= 0 && frame < count)) return;
  const turn = ++opening;
  await attempt(async () => {
    const message = await (early ?? fetchFrame(frame));
    if (turn !== opening) return;  // another one was asked for meanwhile
    const isOther = frame !== state.frame || state.header === null;
    images.take(message);
    state.frame = frame;
    state.header = message.header;
    state.labels = readLabelled(message.said).labels;
    if (!handLabels() && state.labels.length > 0) state.side = state.labels[0]!.side;
    followRange();
    if (isOther) {
      timer.restart(performance.now());
      cloudView?.forget();
      aimImage();
      remember("knuckle.frame", String(frame));
    }
    const infrared = document.querySelector<HTMLInputElement>("#image-kind [value=infrared]")!;
    infrared.disabled = !message.header.infrared;
    if (!message.header.infrared) chooseImage("depth");
    redraw();
  });
}

/** Once the changes that were made here are answered: they belong to this frame. */
async function leaveFor(frame: () => number | null): Promise<void> {
  await changes.settled();
  const next = frame();
  if (next !== null) await openFrame(next);
}

function step(by: -1 | 1): void {
  void leaveFor(() => state.info && strip.beside(state.frame, by, state.info.frames, state.standings));
}

async function openProposed(): Promise<void> {
  await changes.settled();
  await attempt(async () => {
    const next = await fetchNext(state.frame);
    if (next === null) remark("All frames are verified.");
    else await openFrame(next);
  });
}

let standingsTimer = 0;

/** Soon, and once for many changes. */
function askForStandings(): void {
  if (standingsTimer !== 0) return;
  standingsTimer = window.setTimeout(() => {
    standingsTimer = 0;
    void attempt(async () => {
      state.standings = await fetchStandings();
      state.imageChanged = true;
    });
  }, 300);
}

function takeChange(change: Change): void {
  askForStandings();
  if (change.frame !== state.frame || changes.isPosting || state.drag) return;
  const known = state.labels.find(({ side }) => side === change.side)?.revision ?? 0;
  if (change.revision <= known) return;
  if (known > 0) remark("The labels of this frame were changed elsewhere; what you see now is how they stand.");
  void openFrame(state.frame);
}

// ---- Changes ----

function request(act: LabelRequest["act"], more: Partial<LabelRequest> = {}): LabelRequest {
  return { act, frame: state.frame, side: state.side, revision: handLabels()?.revision ?? 0, model: state.usesModel, ...more };
}

function requestOfLandmark(act: LabelRequest["act"], more: Partial<LabelRequest> = {}): LabelRequest {
  return request(act, { landmark: state.landmark, ...more });
}

async function takeAnswer(answer: LabelAnswer): Promise<void> {
  if (answer.fit_ms !== null && answer.fit_ms > 0) state.fit_ms = answer.fit_ms;
  notices.set("disk", answer.fault === "" ? null
    : `The labels cannot be written: ${answer.fault}. ${answer.waiting} changes wait in the program's memory, and are written once there is room.`);
  if (answer.refused) changes.clear();
  remark(answer.remark);
  askForStandings();
  const nothing = answer.labels.length === 0 && answer.refused;  // nothing to undo
  if (answer.record.frame !== state.frame && !nothing) await openFrame(answer.record.frame);
  else if (!nothing) takeLabels(answer);
}

function takePreview(answer: LabelAnswer): void {
  if (!state.drag || answer.refused || answer.remark !== "") return;
  const revisions = state.labels.map(({ revision }) => revision);
  takeLabels(answer);
  state.labels.forEach((labels, i) => { labels.revision = revisions[i] ?? labels.revision; });
}

function verify(goesOn: boolean): void {
  changes.add(() => request("verify"));
  if (goesOn) void openProposedAfterPosting();
}

async function openProposedAfterPosting(): Promise<void> {
  await changes.settled();
  if (handLabels()?.state !== "verified") return;  // it was refused: stay
  if (strip.order === "time") step(1);
  else await openProposed();
}

function stepBack(act: "undo" | "redo"): void {
  changes.add(() => ({ act }));
}

function place(): Point3 | null {
  return hand()?.landmarks_mm[state.landmark] ?? null;
}

/** A fine step across the image [px], or along the line of sight [mm]. */
function nudge(right: number, down: number, away_mm: number): void {
  const { landmark, side } = state;
  changes.add(() => {
    const at = state.header?.record.hands.find((one) => one.side === side)?.landmarks_mm[landmark];
    return at ? request("move", { side, landmark, point_mm: nudged(at, right, down, away_mm) }) : null;
  });
}

function nudged(at: Point3, right: number, down: number, away_mm: number): Point3 {
  const camera = state.header!.camera;
  const depth = camera.model === "orthographic" ? 1 : at[2];
  const growth = camera.model === "orthographic" ? 1 : (at[2] + away_mm) / at[2];
  return [at[0] * growth + (right * depth) / camera.fx, at[1] * growth + (down * depth) / camera.fy, at[2] + away_mm];
}

function toggleVisible(): void {
  const { landmark } = state;
  changes.add(() => {
    const label = handLabels()?.landmarks[landmark];
    return label ? request("look", { landmark, visible: !label.visible }) : null;
  });
}

function free(): void {
  const wanted = requestOfLandmark("free");
  changes.add(() => ({ ...wanted, revision: handLabels()?.revision ?? 0 }));
}

/** What was painted goes to the hand that is chosen. */
function endStroke(): void {
  const { side } = state;
  const { radius_px } = maskTool;
  const erases = maskTool.tool === "eraser";
  for (const points of maskTool.end()) {
    changes.add(() => ({ act: "brush", frame: state.frame, side, revision: handLabels()?.revision ?? 0, points, radius_px, erases }));
  }
  state.imageChanged = true;
}

function outline(): void {
  changes.add(() => ({ act: "outline", frame: state.frame, side: state.side, revision: handLabels()?.revision ?? 0 }));
}

function chooseTool(tool: Tool): void {
  maskTool.tool = tool;
  document.querySelector<HTMLInputElement>(`#tool [value=${tool}]`)!.checked = true;
  state.imageChanged = true;
}

function resizeBrush(by: 1 | -1): void {
  maskTool.resize(by);
  state.imageChanged = true;
}

// ---- Drawing ----

function fitCanvas(canvas: HTMLCanvasElement): void {
  const ratio = Math.min(window.devicePixelRatio, 2);
  const width = Math.max(1, Math.round(canvas.clientWidth * ratio));
  const height = Math.max(1, Math.round(canvas.clientHeight * ratio));
  if (canvas.width === width && canvas.height === height) return;
  canvas.width = width;
  canvas.height = height;
}

function drawImage(): void {
  if (!state.header) return;
  imageView.colour(images, state.header.depth_unit_mm, range);
  fitCanvas(imageCanvas);
  imageView.draw(state.header, bones());
  maskTool.draw(imageCanvas, imageView, state.labels, state.side);
  if (imageView.showsSkeleton) drawLabelMarks(imageCanvas, imageView, state.header.record.hands, state.labels, state);
}

function tick(): void {
  const hasChanged = state.imageChanged;
  if (state.imageChanged) drawImage();
  if (state.cloudChanged && state.header) cloudView?.draw(range);
  state.imageChanged = state.cloudChanged = false;
  if (hasChanged) showAll();
  showTimer();
  requestAnimationFrame(tick);
}

// ---- What the page says ----

function showAll(): void {
  if (!state.info || !state.header) return;
  const labels = handLabels();
  const { record } = state.header;
  setText(element("frame"), `${state.frame} of ${state.info.frames}${record.name && record.name !== String(state.frame) ? ` (${record.name})` : ""}`);
  setText(element("hand-state"), labels ? `${labels.side}, ${labels.state}, by ${labels.author}` : `no ${state.side} hand is labelled`);
  const fit = labels && labels.rms_mm !== null ? `${labels.rms_mm.toFixed(1)} mm from the labels, skin ${labels.gap_mm?.toFixed(1) ?? "–"} mm` : "–";
  setText(element("fit"), state.fit_ms === null ? fit : `${fit}; ${state.fit_ms.toFixed(0)} ms`);
  const size = labels?.mask ? `${pixelsIn(labels.mask)} px` : "none";
  setText(element("mask"), maskTool.tool === "landmarks" ? size : `${size}; ${maskTool.tool} of ${maskTool.radius_px} px`);
  const { standings } = state;
  const count = standings ? [...standings.states].filter((letter) => letter === "v").length : 0;
  setText(element("progress"), standings ? `${count} of ${state.info.frames} frames${standings.median_s === null ? "" : `, ${standings.median_s.toFixed(0)} s per hand`}` : "–");
  const empty = element("empty");
  empty.hidden = labels !== null;
  setText(empty, `No ${state.side} hand is labelled here. Click to place: ${inWords(state.landmark)}.`);
  for (const box of document.querySelectorAll<HTMLInputElement>("#side input")) box.checked = box.value === state.side;
  showLandmarks();
  strip.show(state.frame, state.info.frames, standings);
  announcer.update(`Frame ${state.frame}, ${inWords(state.landmark)}, ${labels?.landmarks[state.landmark]?.state ?? "not labelled"}`, performance.now());
}

function showLandmarks(): void {
  const labels = handLabels();
  landmarkList.show(labels, state.landmark);
  const label = labels?.landmarks[state.landmark] ?? null;
  const visible = element<HTMLInputElement>("visible");
  visible.disabled = !label;
  visible.checked = label?.visible ?? false;
  element<HTMLButtonElement>("free").disabled = !label || label.state !== "corrected";
  element<HTMLButtonElement>("verify").disabled = !labels;
}

function showTimer(): void {
  const text = `${timer.total_s(performance.now()).toFixed(0)} s${state.labels.length > 0 ? `; before: ${(handLabels()?.seconds ?? 0).toFixed(0)} s` : ""}`;
  setText(element("timer"), text);
}

function showConnection(isOpen: boolean): void {
  if (isOpen && !state.isOpen && state.header) void openFrame(state.frame);
  state.isOpen = isOpen;
  element("connection").dataset["state"] = isOpen ? "open" : "lost";
  setText(element("connection-text"), isOpen ? "Connected" : "No connection");
  notices.set("connection", isOpen ? null : "Connection lost: knuckle has ended, or the network is interrupted. What was labelled until then is kept; the page tries again.");
}

// ---- What the user does ----

function choose(landmark: string): void {
  state.landmark = landmark;
  state.imageChanged = true;
}

function chooseBeside(by: number): void {
  const names = state.info?.landmarks ?? [];
  choose(names[(names.indexOf(state.landmark) + by + names.length) % names.length] ?? state.landmark);
}

function chooseSide(side: Side): void {
  state.side = side;
  state.imageChanged = true;
}

function chooseImage(kind: ImageKind): void {
  const choice = document.querySelector<HTMLInputElement>(`#image-kind [value=${kind}]`)!;
  if (choice.disabled && kind !== "depth") return;
  choice.checked = true;
  imageView.kind = kind;
  state.imageChanged = true;
}

/** Shows the hand large, or the whole image where there is none. */
function aimImage(): void {
  if (!state.header) return;
  const points = Object.values(hand()?.landmarks_px ?? {}).filter((point): point is Point2 => point !== null);
  aimAt(imageView, points, state.header);
  state.imageChanged = true;
}

function zoomImage(factor: number, x: number, y: number): void {
  if (!state.header) return;
  zoomAt(imageView, factor, x, y, state.header);
  state.imageChanged = true;
}

/** The landmark that is chosen, where it is near the pointer; else the nearest one, of any hand; null where none is near. */
function landmarkAt(x: number, y: number, canvasAt: (one: Hand, name: string) => Point2 | null): { side: Side; name: string } | null {
  const chosen = hand();
  const ofChosen = chosen && canvasAt(chosen, state.landmark);
  if (ofChosen && Math.hypot(ofChosen[0] - x, ofChosen[1] - y) <= kReach_px) return { side: state.side, name: state.landmark };
  let nearest: { side: Side; name: string } | null = null;
  let least = kReach_px;
  for (const one of state.header?.record.hands ?? []) {
    for (const name of Object.keys(one.landmarks_px)) {
      const at = canvasAt(one, name);
      const distance = at ? Math.hypot(at[0] - x, at[1] - y) : Infinity;
      if (distance > least || one.side === null) continue;
      least = distance;
      nearest = { side: one.side, name };
    }
  }
  return nearest;
}

function inImage(one: Hand, name: string): Point2 | null {
  const at = one.landmarks_px[name];
  return at ? imageView.canvasAt(at) : null;
}

function inCloud(one: Hand, name: string): Point2 | null {
  const at = one.landmarks_mm[name];
  return at && cloudView ? cloudView.canvasAt(at) : null;
}

/** What a drag asks for where the pointer is. */
function dragged(): LabelRequest | null {
  const { drag } = state;
  if (!drag) return null;
  if (drag.view === "image") return requestOfLandmark("place", { pixel: imageView.placeAt(...drag.at) });
  if (!drag.start || !cloudView) return null;
  return requestOfLandmark("move", { point_mm: cloudView.movedOnScreen(drag.start, drag.at[0] - drag.from[0], drag.at[1] - drag.from[1]) });
}

function listenToImage(): void {
  imageCanvas.addEventListener("pointerdown", (event) => {
    if (!state.header) return;
    const at: Point2 = [event.offsetX, event.offsetY];
    const pans = event.button !== 0;
    if (!pans && maskTool.tool !== "landmarks") {
      maskTool.begin(imageView.placeAt(...at));
      state.imageChanged = true;
    } else if (!pans) {
      const found = landmarkAt(...at, inImage);
      if (found) {
        state.side = found.side;
        choose(found.name);
      }
      // One that is only chosen stays where it is until the pointer moves.
      state.drag = { view: "image", from: at, at, start: null, hasMoved: found === null, pans: null };
      if (!found) changes.preview(dragged()!);
    } else {
      imageView.centre ??= middleOf(state.header);
      state.drag = { view: "image", from: at, at, start: null, hasMoved: false, pans: imageView.centre };
    }
    imageCanvas.setPointerCapture(event.pointerId);
  });
  imageCanvas.addEventListener("contextmenu", (event) => event.preventDefault());
  imageCanvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    zoomImage(event.deltaY < 0 ? 1.2 : 1 / 1.2, event.offsetX, event.offsetY);
  }, { passive: false });
}

function listenToCloud(): void {
  cloudCanvas.addEventListener("pointerdown", (event) => {
    const at: Point2 = [event.offsetX, event.offsetY];
    const found = event.button === 0 ? landmarkAt(...at, inCloud) : null;
    if (!found || !cloudView) return;
    cloudView.hold(true);
    state.side = found.side;
    choose(found.name);
    state.drag = { view: "cloud", from: at, at, start: place(), hasMoved: false, pans: null };
    cloudCanvas.setPointerCapture(event.pointerId);
  }, { capture: true });
}

function listenToDrags(): void {
  for (const canvas of [imageCanvas, cloudCanvas]) {
    canvas.addEventListener("pointermove", (event) => {
      if (canvas === imageCanvas && maskTool.tool !== "landmarks") {
        maskTool.move(imageView.placeAt(event.offsetX, event.offsetY));
        state.imageChanged = true;
      }
      const { drag } = state;
      if (!drag || (drag.view === "image") !== (canvas === imageCanvas)) return showProbe(canvas, event);
      drag.at = [event.offsetX, event.offsetY];
      if (drag.pans) return pan();
      if (Math.hypot(drag.at[0] - drag.from[0], drag.at[1] - drag.from[1]) > 2) drag.hasMoved = true;
      if (drag.hasMoved) changes.preview(dragged()!);
    });
    canvas.addEventListener("pointerup", endDrag);
    canvas.addEventListener("pointercancel", () => {
      maskTool.drop();
      if (state.drag) dropDrag();
      void openFrame(state.frame);
    });
  }
}

function pan(): void {
  const { drag } = state;
  const from = imageView.placeAt(...drag!.from);
  const at = imageView.placeAt(...drag!.at);
  imageView.centre = [drag!.pans![0] + from[0] - at[0], drag!.pans![1] + from[1] - at[1]];
  state.imageChanged = true;
}

function dropDrag(): void {
  state.drag = null;
  changes.dropPreview();
  cloudView?.hold(false);
}

function endDrag(): void {
  if (maskTool.stroke) endStroke();
  const { drag } = state;
  if (!drag) return;
  const wanted = drag.hasMoved && !drag.pans ? dragged() : null;
  dropDrag();
  if (wanted) changes.add(() => ({ ...wanted, revision: handLabels()?.revision ?? 0 }));
}

/** Says the distance under the pointer. */
function showProbe(canvas: HTMLCanvasElement, event: PointerEvent): void {
  if (canvas !== imageCanvas || !state.header) return;
  const probe = element("probe");
  const pixel = imageView.pixelAt(event.offsetX, event.offsetY);
  probe.hidden = !pixel;
  if (!pixel) return;
  const count = images.depth[pixel[1] * images.width + pixel[0]]!;
  setText(probe, `${pixel[0]}, ${pixel[1]}: ${count === 0 ? "not measured" : `${Math.round(count * state.header.depth_unit_mm)} mm`}`);
}

function setRange(): void {
  const near = element<HTMLInputElement>("range-near");
  const far = element<HTMLInputElement>("range-far");
  const isAutomatic = element<HTMLInputElement>("range-auto").checked;
  near.disabled = far.disabled = isAutomatic;
  range.setAutomatic(isAutomatic);
  const isPossible = isAutomatic || range.fix(near.valueAsNumber, far.valueAsNumber);
  for (const field of [near, far]) field.setAttribute("aria-invalid", String(!isPossible));
  followRange();
  state.imageChanged = state.cloudChanged = true;
}

/** Colours tell the hand's own depths apart; without a hand, those of the image. */
function followRange(): void {
  if (!state.header || !range.isAutomatic) return;
  const depths = Object.values(hand()?.landmarks_mm ?? {}).filter((point) => point !== null).map((point) => point[2]);
  if (depths.length > 2) {
    range.followPoints(depths, kRangeMargin_mm);
  } else {
    range.setAutomatic(true);
    range.follow(images.depth, state.header.depth_unit_mm);
  }
  element<HTMLInputElement>("range-near").value = String(Math.round(range.near_mm));
  element<HTMLInputElement>("range-far").value = String(Math.round(range.far_mm));
}

function setOrder(order: StripOrder): void {
  strip.order = order;
  document.querySelector<HTMLInputElement>(`#order [value=${order}]`)!.checked = true;
  state.imageChanged = true;
}

function setModel(isOn: boolean): void {
  state.usesModel = isOn;
  element<HTMLInputElement>("model").checked = isOn;
}

function setInSpace(id: "show-cloud" | "show-surface" | "cut", isOn: boolean): void {
  if (!cloudView) return;
  if (id === "show-cloud") cloudView.showsCloud = isOn;
  else if (id === "show-surface") cloudView.showsSurface = isOn;
  else cloudView.isCut = isOn;
  state.cloudChanged = true;
}

function aim(): void {
  aimImage();
  cloudView?.reset(state.header, images);
}

function flip(id: string): void {
  const box = element<HTMLInputElement>(id);
  if (!box.disabled) box.click();
}

function listenToControls(): void {
  const click = (id: string, act: () => void): void => element(id).addEventListener("click", act);
  const changed = (id: string, act: (box: HTMLInputElement) => void): void => {
    element(id).addEventListener("change", (event) => act(event.target as HTMLInputElement));
  };
  click("back", () => step(-1));
  click("forward", () => step(1));
  click("proposed", () => void openProposed());
  click("undo", () => stepBack("undo"));
  click("redo", () => stepBack("redo"));
  click("verify", () => verify(false));
  click("free", free);
  click("outline", outline);
  click("theme", () => { nextTheme(); showTheme(); });
  click("help", () => element<HTMLDialogElement>("help-dialog").showModal());
  click("reset", aim);
  for (const button of document.querySelectorAll<HTMLButtonElement>("[data-look]")) {
    button.addEventListener("click", () => cloudView?.look(button.dataset["look"] as Viewpoint));
  }
  changed("visible", toggleVisible);
  changed("model", (box) => setModel(box.checked));
  changed("side", (box) => chooseSide(box.value as Side));
  changed("tool", (box) => chooseTool(box.value as Tool));
  changed("order", (box) => setOrder(box.value as StripOrder));
  changed("image-kind", (box) => chooseImage(box.value as ImageKind));
  changed("show-skeleton", (box) => {
    imageView.showsSkeleton = box.checked;
    if (cloudView) cloudView.showsSkeleton = box.checked;
    state.imageChanged = state.cloudChanged = true;
  });
  for (const id of ["show-cloud", "show-surface", "cut"] as const) changed(id, (box) => setInSpace(id, box.checked));
  for (const id of ["range-auto", "range-near", "range-far"]) changed(id, setRange);
  const resizes = new ResizeObserver(() => { state.imageChanged = state.cloudChanged = true; });
  for (const screen of document.querySelectorAll(".screen")) resizes.observe(screen);
  for (const kind of ["pointermove", "pointerdown", "keydown", "wheel"]) {
    document.addEventListener(kind, () => timer.touch(performance.now()), { capture: true, passive: true });
  }
}

function shortcuts(): Shortcut[] {
  return [
    { keys: ["."], shown: ".", does: "next frame", act: () => step(1), repeats: true },
    { keys: [","], shown: ",", does: "frame before", act: () => step(-1), repeats: true },
    { keys: ["n", "N"], shown: "N", does: "the frame whose correction changes most", act: () => void openProposed() },
    { keys: ["v", "V"], shown: "V", does: "verify: all of the hand is right", act: () => verify(false) },
    { keys: ["Enter"], shown: "Enter", does: "verify, and go on", act: () => verify(true) },
    { keys: ["z", "Z"], shown: "Z", does: "undo", act: () => stepBack("undo"), repeats: true },
    { keys: ["y", "Y"], shown: "Y", does: "redo", act: () => stepBack("redo"), repeats: true },
    { keys: ["]"], shown: "]", does: "next landmark", act: () => chooseBeside(1), repeats: true },
    { keys: ["["], shown: "[", does: "landmark before", act: () => chooseBeside(-1), repeats: true },
    { keys: ["h", "H"], shown: "H", does: "the landmark is visible, hidden", act: toggleVisible },
    { keys: ["u", "U"], shown: "U", does: "the landmark follows the model again", act: () => { if (!element<HTMLButtonElement>("free").disabled) free(); } },
    { keys: ["m", "M"], shown: "M", does: "hand model on and off", act: () => setModel(!state.usesModel) },
    { keys: ["s", "S"], shown: "S", does: "right hand, left hand", act: () => chooseSide(state.side === "right" ? "left" : "right") },
    { keys: ["l", "L"], shown: "L", does: "the pointer places landmarks", act: () => chooseTool("landmarks") },
    { keys: ["b", "B"], shown: "B", does: "it paints the hand's mask", act: () => chooseTool("brush") },
    { keys: ["e", "E"], shown: "E", does: "it erases from the mask", act: () => chooseTool("eraser") },
    { keys: ["{"], shown: "{", does: "a smaller brush", act: () => resizeBrush(-1), repeats: true },
    { keys: ["}"], shown: "}", does: "a larger brush", act: () => resizeBrush(1), repeats: true },
    { keys: ["g", "G"], shown: "G", does: "the mask begins with what was measured on the hand model", act: outline },
    { keys: ["o", "O"], shown: "O", does: "frames in time, worst first", act: () => setOrder(strip.order === "time" ? "doubt" : "time") },
    { keys: ["i", "I"], shown: "I", does: "depth, infrared", act: () => chooseImage(imageView.kind === "depth" ? "infrared" : "depth") },
    { keys: ["k", "K"], shown: "K", does: "skeleton on and off", act: () => flip("show-skeleton") },
    { keys: ["p", "P"], shown: "P", does: "points on and off", act: () => flip("show-cloud") },
    { keys: ["f", "F"], shown: "F", does: "fitted surface on and off", act: () => flip("show-surface") },
    { keys: ["c", "C"], shown: "C", does: "points cut at the range of colours", act: () => flip("cut") },
    { keys: ["1"], shown: "1", does: "look from the camera", act: () => cloudView?.look("front") },
    { keys: ["2"], shown: "2", does: "look from the side", act: () => cloudView?.look("side") },
    { keys: ["3"], shown: "3", does: "look from above", act: () => cloudView?.look("top") },
    { keys: ["0"], shown: "0", does: "aim both views at the hand", act: aim },
    { keys: ["t", "T"], shown: "T", does: "theme: as the system, light, dark", act: () => element("theme").click() },
    { keys: ["?"], shown: "?", does: "this list", act: () => element("help").click() },
  ];
}

/** Control and Z, Y: as everywhere. */
function listenToUndo(): void {
  document.addEventListener("keydown", (event) => {
    if (!(event.ctrlKey || event.metaKey) || !["z", "Z", "y"].includes(event.key) || document.querySelector("dialog[open]")) return;
    event.preventDefault();
    stepBack(event.key === "z" && !event.shiftKey ? "undo" : "redo");
  });
}

function listenToAllKeys(): void {
  const kKey = "knuckle.keys";
  const box = element<HTMLInputElement>("keys-on");
  box.checked = remembered(kKey) !== "off";
  box.addEventListener("change", () => remember(kKey, box.checked ? "on" : "off"));
  const list = shortcuts();
  listenToTurningKeys(cloudCanvas, () => cloudView);
  listenToFineSteps(cloudCanvas, () => box.checked, nudge);
  listenToUndo();
  listenToKeys(list, () => box.checked);
  listShortcuts(element("shortcuts"), [
    ...list,
    { shown: "← → ↑ ↓", does: `the landmark by ${kFine_px} px, with Shift by ${kCoarse_px}; in the points: turn by ${kTurn_deg}°` },
    { shown: "+ −", does: `the landmark by ${kDepthStep_mm} mm away and nearer, with Shift by 5; in the points: zoom` },
  ]);
}

function showTheme(): void {
  setText(element("theme-label"), `Theme: ${currentTheme()}`);
}

async function begin(): Promise<void> {
  await attempt(async () => {
    const info = await first.info;
    state.info = info;
    state.landmark = info.landmarks[0] ?? "wrist";
    landmarkList.make(info.landmarks);
    setText(element("source"), info.source);
    setText(element("file"), `${info.file}, by ${info.author}`);
    setText(element("version"), `Knuckle ${info.version}`);
    document.title = `${info.source} – Knuckle annotate`;
    await (firstFrame < info.frames ? openFrame(firstFrame, first.frame) : openFrame(0));
    askForStandings();
  });
  listenToChanges(takeChange, showConnection);
}

/** For tests, and for the curious in the browser's console. */
Object.assign(globalThis, {
  knuckle: {
    frame: () => state.frame,
    open: (frame: number) => void openFrame(frame),
    header: () => state.header,
    labels: () => state.labels,
    isQuiet: () => changes.isQuiet && !state.imageChanged && state.header !== null,
    imageAt: (at: Point2) => imageView.canvasAt(at),
    cloudAt: (at: Point3) => cloudView?.canvasAt(at) ?? null,
    landmark: () => state.landmark,
    tool: () => maskTool.tool,
    brush_px: () => maskTool.radius_px,
    placeAt: (x: number, y: number) => imageView.placeAt(x, y),
    answered_ms: () => changes.answered_ms,
    fit_ms: () => state.fit_ms,
    standings: () => state.standings,
    depth_mm: (column: number, row: number) => (images.depth[row * images.width + column] ?? 0) * (state.header?.depth_unit_mm ?? 0),
  },
});

restoreTheme();
showTheme();
listenToControls();
listenToImage();
listenToCloud();
listenToDrags();
listenToAllKeys();
void begin();
requestAnimationFrame(tick);
