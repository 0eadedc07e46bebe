// SPDX-License-Identifier: Apache-2.0
// The page: what comes from the server, what the user does, and when to draw.
import { drawChart, Rate, Samples } from "./chart.ts";
import { CloudView, type Viewpoint } from "./cloud_view.ts";
import { Connection, setRecording, type ConnectionState } from "./connection.ts";
import { DepthRange, roundTicks } from "./depth_range.ts";
import { History } from "./history.ts";
import { ImageView, type ImageKind } from "./image_view.ts";
import { depthPalette } from "./palette.ts";
import { Announcer, describeHands, element, HandList, Notices, setText } from "./panel.ts";
import { FrameImages, type FrameHeader, type FrameMessage, type Info, type Recording } from "./protocol.ts";
import { composePicture, download } from "./screenshot.ts";
import { kTurn_deg, kZoom, listenToKeys, listenToTurningKeys, listShortcuts, type Shortcut } from "./shortcuts.ts";
import { currentTheme, nextTheme, remember, remembered, restoreTheme } from "./theme.ts";

const kSilence_ms = 2000;  // without a frame for so long, the page says so
const kFaultShown_ms = 6000;

/** All that the page knows; what is seen follows from it. */
const state = {
  connection: { is: "connecting" } as ConnectionState,
  info: null as Info | null,
  header: null as FrameHeader | null,  // of the frame that is shown
  newest: null as FrameMessage | null,  // came, and is not shown yet
  isPaused: false,
  isStepping: false,  // the next frame that comes is shown, though paused
  recording: null as Recording | null,
  isAskingToRecord: false,
  malformed: 0,
  lastMalformed_ms: -Infinity,
  lastFrame_ms: -Infinity,
  openedAt_ms: 0,
  received: 0,
  shown: 0,
  imageChanged: false,  // the image has to be drawn again
  cloudChanged: false,
};

const palette = depthPalette();
const images = new FrameImages();
const history = new History();
const range = new DepthRange();
const imageView = new ImageView(element<HTMLCanvasElement>("image"), palette);
const cloudView = openCloudView();
const hands = new HandList(element("hands"), element("no-hands"));
const notices = new Notices(element("notices"));
const announcer = new Announcer(element("announcer"));
const latencies = new Samples();
const rates = new Samples();
const pictureRates = new Samples();
const frameRate = new Rate();
const pictureRate = new Rate();
const reducedMotion = matchMedia("(prefers-reduced-motion: reduce)");
const noBones: [string, string][] = [];

const connection = new Connection({
  state(now) {
    if (now.is === "open" && state.connection.is !== "open") state.openedAt_ms = performance.now();
    if (now.is === "lost") cloudView?.forget();
    state.connection = now;
    showConnection();
  },
  info(info) {
    state.info = info;
    state.recording = info.recording;
    state.imageChanged = state.cloudChanged = true;
    showStream();
  },
  frame: takeFrame,
  malformed(reason) {
    ++state.malformed;
    state.lastMalformed_ms = performance.now();
    const count = state.malformed === 1 ? "A message" : `${state.malformed} messages`;
    notices.set("malformed", `${count} from the server could not be read and ${state.malformed === 1 ? "was" : "were"} ignored; the last: ${reason}.`);
  },
});

function openCloudView(): CloudView | null {
  const canvas = element<HTMLCanvasElement>("cloud");
  try {
    const view = new CloudView(canvas, palette, () => { state.cloudChanged = true; });
    canvas.addEventListener("webglcontextlost", () => missCloud("The graphics processor was taken away from this page. It comes back by itself, or with reloading."));
    canvas.addEventListener("webglcontextrestored", () => { element("cloud-missing").hidden = true; state.cloudChanged = true; });
    return view;
  } catch {
    canvas.hidden = true;
    missCloud("This browser has no WebGL 2, so points in space cannot be drawn. The image works without it.");
    for (const control of document.querySelectorAll<HTMLInputElement | HTMLButtonElement>("#cloud-panel input, #cloud-panel button")) control.disabled = true;
    return null;
  }
}

function missCloud(text: string): void {
  const placard = element("cloud-missing");
  setText(placard, text);
  placard.hidden = false;
}

// ---- Frames ----

/** The newest frame wins: one that has not been drawn when the next comes is never drawn. */
function takeFrame(message: FrameMessage): void {
  const now = performance.now();
  state.lastFrame_ms = now;
  ++state.received;
  const { record, arrived, recording } = message.header;
  if (record.latency_ms !== null) latencies.add(now, record.latency_ms);
  frameRate.update(now, arrived ?? state.received);
  if (recording && !state.isAskingToRecord) state.recording = recording;
  if (state.isPaused && !state.isStepping) return;
  state.isStepping = false;
  history.add(message);
  state.newest = message;
}

function show(message: FrameMessage): void {
  images.take(message);
  state.header = message.header;
  range.follow(images.depth, message.header.depth_unit_mm);
  cloudView?.take(images, message.header, bones());
  state.imageChanged = state.cloudChanged = true;
  ++state.shown;
}

function bones(): [string, string][] {
  return state.info?.bones ?? noBones;
}

function drawImage(): void {
  if (!state.header) return;
  imageView.colour(images, state.header.depth_unit_mm, range);
  fitCanvas(element<HTMLCanvasElement>("image"));
  imageView.draw(state.header, bones());
}

function fitCanvas(canvas: HTMLCanvasElement): void {
  const ratio = Math.min(window.devicePixelRatio, 2);
  const width = Math.max(1, Math.round(canvas.clientWidth * ratio));
  const height = Math.max(1, Math.round(canvas.clientHeight * ratio));
  if (canvas.width === width && canvas.height === height) return;
  canvas.width = width;
  canvas.height = height;
}

let nextNumbers_ms = 0;
let nextChart_ms = 0;

function tick(): void {
  const now = performance.now();
  if (cloudView?.tick(now)) state.cloudChanged = true;
  if (state.newest) {
    show(state.newest);
    state.newest = null;
    pictureRate.update(now, state.shown);
  }
  if (state.imageChanged) drawImage();
  if (state.cloudChanged && state.header) cloudView?.draw(range);
  const hasDrawn = state.imageChanged;
  state.imageChanged = state.cloudChanged = false;
  if (hasDrawn) showRecord();
  if (now >= nextNumbers_ms) {
    nextNumbers_ms = now + 250;
    showNumbers(now);
  }
  if (now >= nextChart_ms) {
    nextChart_ms = now + (reducedMotion.matches ? 1000 : 125);
    showCharts(now);
  }
  requestAnimationFrame(tick);
}

// ---- What the page says ----

function showRecord(): void {
  const { header } = state;
  if (!header) return;
  const { record } = header;
  hands.show(record.hands, record.status);
  const placard = element("status");
  setText(placard, record.status);
  placard.hidden = record.status === "";
  const time = record.time_s === null ? "" : `  ${record.time_s.toFixed(3)} s`;
  const name = record.name && record.name !== String(record.frame) ? ` (${record.name})` : "";
  setText(element("frame"), `${record.frame}${name}${time}`);
  const { camera } = header;
  setText(element("camera"), `${header.width} x ${header.height}, ${camera.model}, f ${round(camera.fx)} ${camera.model === "projective" ? "px" : "px/mm"}`);
  showRange();
  const infrared = document.querySelector<HTMLInputElement>("#image-kind [value=infrared]")!;
  infrared.disabled = !header.infrared;
  if (!header.infrared && imageView.kind === "infrared") chooseImage("depth");
}

function round(value: number): string {
  return Math.abs(value) >= 10 ? value.toFixed(1) : value.toPrecision(3);
}

let shownTicks = "";

function showRange(): void {
  const { near_mm, far_mm } = range;
  if (range.isAutomatic) {
    element<HTMLInputElement>("range-near").value = String(Math.round(near_mm));
    element<HTMLInputElement>("range-far").value = String(Math.round(far_mm));
  }
  const key = `${near_mm.toFixed(0)} ${far_mm.toFixed(0)}`;
  if (key === shownTicks) return;
  shownTicks = key;
  element("scale").setAttribute("aria-label", `Colours of distances, from ${near_mm.toFixed(0)} to ${far_mm.toFixed(0)} mm`);
  const width = element("ticks").clientWidth;
  element("ticks").replaceChildren(...roundTicks(near_mm, far_mm, width < 260 ? 3 : 6).map((tick) => {
    const label = document.createElement("span");
    label.textContent = String(tick);
    label.style.left = `${Math.min(97, Math.max(3, (100 * (tick - near_mm)) / (far_mm - near_mm))).toFixed(2)}%`;
    return label;
  }));
}

function showStream(): void {
  const { info } = state;
  if (!info) return;
  setText(element("source"), info.source || "–");
  setText(element("pipeline"), info.pipeline.split("/").slice(-2).join("/") || "–");
  element("pipeline").title = info.pipeline;
  setText(element("version"), `Knuckle ${info.version}`);
  document.title = info.source ? `${info.source} – Knuckle live` : "Knuckle live";
  showRecording();
}

function showConnection(): void {
  const now = performance.now();
  const silence_ms = now - Math.max(state.lastFrame_ms, state.openedAt_ms);
  let shown: string = state.connection.is;
  let text = "Live";
  let notice: string | null = null;
  let silence: string | null = null;
  if (state.connection.is === "connecting") {
    text = "Connecting";
  } else if (state.connection.is === "lost") {
    const wait_s = Math.max(0, Math.ceil((state.connection.retry_ms - now) / 1000));
    text = "No connection";
    notice = `Connection lost: ${state.connection.reason}. The page tries again ${wait_s === 0 ? "now" : `in ${wait_s} s`}.`;
  } else if (silence_ms > kSilence_ms) {
    shown = "waiting";
    text = "No frames";
    const since = `${Math.floor(silence_ms / 1000)} s`;
    silence = state.received === 0 ? `Connected, but no frame has come for ${since}. Is the camera running?`
                                   : `No frames for ${since}. Has the recording ended, or is the camera unplugged?`;
  } else if (state.isPaused) {
    text = "Paused";
    shown = "waiting";
  }
  element("connection").dataset["state"] = shown;
  setText(element("connection-text"), text);
  if (state.connection.is !== "connecting") notices.set("connection", notice);
  notices.set("frames", silence);
}

function showRecording(): void {
  const button = element<HTMLButtonElement>("record");
  const { recording, info } = state;
  const isOn = recording !== null && recording.file !== null;
  button.disabled = state.isAskingToRecord || (!isOn && info !== null && !info.can_record);
  button.setAttribute("aria-pressed", String(isOn));
  setText(button.querySelector(".label")!, isOn ? "Stop recording" : "Record");
  button.title = isOn ? "Stop recording (R)" : "Record (R)";
  let text = "off";
  if (isOn) {
    text = `${recording.file}: ${recording.frames} frames`;
    if (recording.dropped > 0) text += `, ${recording.dropped} dropped because the disk is too slow`;
  } else if (info && !info.can_record) {
    text = "not possible here; start knuckle live with --record-folder DIR";
  } else if (recording && recording.frames > 0) {
    text = `off; ${recording.frames} frames written`;
  }
  setText(element("recording-text"), text);
  showRecordingFault(recording?.fault ?? "");
}

let shownFault = "";

function showRecordingFault(fault: string): void {
  if (fault === shownFault) return;
  shownFault = fault;
  notices.set("recording", fault === "" ? null : sentence(`The recording has ended: ${fault}`));
}

function showNumbers(now: number): void {
  showConnection();
  showRecording();
  if (state.malformed > 0 && now - state.lastMalformed_ms > kFaultShown_ms) notices.set("malformed", null);
  if (state.connection.is === "open") {
    const rate = frameRate.perSecond(now);
    const pictures = pictureRate.perSecond(now);
    if (rate !== null) rates.add(now, rate);
    if (pictures !== null) pictureRates.add(now, pictures);
    setText(element("rate"), rate === null ? "–" : `${rate.toFixed(1)} /s`);
    setText(element("pictures"), pictures === null ? "–" : `${pictures.toFixed(1)} /s`);
    const median = latencies.percentile(0.5, now - 2000);
    const high = latencies.percentile(0.99, now - 20_000);
    setText(element("latency"), median === null ? "–" : `${median.toFixed(1)} ms`);
    setText(element("latency-high"), high === null ? "" : `99 % below ${high.toFixed(1)} ms`);
  }
  const { header } = state;
  setText(element("passed-over"), header?.passed_over == null ? "–" : `${header.passed_over} of ${header.arrived ?? "?"} frames`);
  if (header) announcer.update(state.connection.is === "open" ? describeHands(header.record.hands, header.record.status) : "", now);
}

function showCharts(now: number): void {
  const style = getComputedStyle(document.documentElement);
  const colour = (name: string): string => resolved(style.getPropertyValue(name));
  const [line, soft] = [colour("--line"), colour("--soft")];
  drawChart(element<HTMLCanvasElement>("latency-chart"), now, [{ samples: latencies, colour: colour("--latency") }], line, soft, 10);
  drawChart(element<HTMLCanvasElement>("rate-chart"), now,
            [{ samples: rates, colour: soft }, { samples: pictureRates, colour: colour("--accent") }], line, soft, 30);
}

/** The half of "light-dark(a, b)" that holds now. */
function resolved(colour: string): string {
  const halves = /^light-dark\((.*?),(.*)\)$/.exec(colour.trim());
  if (!halves) return colour;
  const isDark = currentTheme() === "dark" || (currentTheme() === "auto" && matchMedia("(prefers-color-scheme: dark)").matches);
  return halves[isDark ? 2 : 1]!.trim();
}

// ---- What the user does ----

function setPaused(isPaused: boolean): void {
  state.isPaused = isPaused;
  state.isStepping = false;
  const button = element("pause");
  button.setAttribute("aria-pressed", String(isPaused));
  setText(button.querySelector(".label")!, isPaused ? "Play" : "Pause");
  button.title = isPaused ? "Play (space)" : "Pause (space)";
  showStepping();
  showConnection();
}

function showStepping(): void {
  element<HTMLButtonElement>("step").disabled = !state.isPaused;
  element<HTMLButtonElement>("back").disabled = !state.isPaused || !history.canGoBack();
}

/** One frame on: a later one that is remembered, or else the next that comes. One back: of those remembered. */
function step(by: -1 | 1): void {
  if (!state.isPaused) setPaused(true);
  const message = history.move(by);
  if (message) state.newest = message;
  else if (by === 1) state.isStepping = true;
  showStepping();
}

function sentence(text: string): string {
  return /[.!?]$/.test(text) ? text : `${text}.`;
}

async function toggleRecording(): Promise<void> {
  if (element<HTMLButtonElement>("record").disabled) return;
  const on = state.recording === null || state.recording.file === null;
  state.isAskingToRecord = true;
  showRecording();
  try {
    state.recording = await setRecording(on);
    notices.set("recording", null);
  } catch (error) {
    notices.set("recording", sentence(`The recording could not be ${on ? "started" : "stopped"}: ${(error as Error).message}`));
  }
  state.isAskingToRecord = false;
  showRecording();
}

async function takeScreenshot(): Promise<void> {
  if (!state.header) return;
  const { record } = state.header;
  drawImage();
  cloudView?.draw(range);
  const views = [element<HTMLCanvasElement>("image")];
  if (cloudView) views.push(element<HTMLCanvasElement>("cloud"));
  const time = record.time_s === null ? "" : `, ${record.time_s.toFixed(3)} s`;
  const said = describeHands(record.hands, record.status);
  const picture = composePicture(views, `Knuckle   ${state.info?.source ?? ""}   frame ${record.frame}${time}   ${said}`);
  await download(picture, `knuckle-${String(record.frame).padStart(6, "0")}.png`);
}

function chooseImage(kind: ImageKind): void {
  const choice = document.querySelector<HTMLInputElement>(`#image-kind [value=${kind}]`)!;
  if (choice.disabled && kind !== "depth") return;
  choice.checked = true;
  imageView.kind = kind;
  element("image").setAttribute("aria-label", `${kind === "depth" ? "Depth" : "Infrared"} image with the skeletons of the hands`);
  state.imageChanged = true;
}

function setSkeleton(isShown: boolean): void {
  element<HTMLInputElement>("show-skeleton").checked = isShown;
  imageView.showsSkeleton = isShown;
  if (cloudView) cloudView.showsSkeleton = isShown;
  state.imageChanged = state.cloudChanged = true;
}

function setInSpace(id: "show-cloud" | "show-surface", isShown: boolean): void {
  if (!cloudView) return;
  element<HTMLInputElement>(id).checked = isShown;
  if (id === "show-cloud") cloudView.showsCloud = isShown;
  else cloudView.showsSurface = isShown;
  state.cloudChanged = true;
}

function setRange(): void {
  const near = element<HTMLInputElement>("range-near");
  const far = element<HTMLInputElement>("range-far");
  const isAutomatic = element<HTMLInputElement>("range-auto").checked;
  near.disabled = far.disabled = isAutomatic;
  range.setAutomatic(isAutomatic);
  const isPossible = isAutomatic || range.fix(near.valueAsNumber, far.valueAsNumber);
  for (const field of [near, far]) field.setAttribute("aria-invalid", String(!isPossible));
  if (state.header) range.follow(images.depth, state.header.depth_unit_mm);
  state.imageChanged = state.cloudChanged = true;
}

function showTheme(): void {
  setText(element("theme-label"), `Theme: ${currentTheme()}`);
}

function openHelp(): void {
  element<HTMLDialogElement>("help-dialog").showModal();
}

function resetView(): void {
  cloudView?.reset(state.header, images);
}

function flip(id: string): void {
  const box = element<HTMLInputElement>(id);
  if (!box.disabled) box.click();
}

function listenToControls(): void {
  const click = (id: string, act: () => void): void => element(id).addEventListener("click", act);
  const change = (id: string, act: (isOn: boolean) => void): void => {
    element(id).addEventListener("change", (event) => act((event.target as HTMLInputElement).checked));
  };
  click("pause", () => setPaused(!state.isPaused));
  click("step", () => step(1));
  click("back", () => step(-1));
  click("record", () => void toggleRecording());
  click("screenshot", () => void takeScreenshot());
  click("theme", () => { nextTheme(); showTheme(); });
  click("help", openHelp);
  click("reset", resetView);
  click("zoom-in", () => cloudView?.zoom(kZoom));
  click("zoom-out", () => cloudView?.zoom(1 / kZoom));
  for (const button of document.querySelectorAll<HTMLButtonElement>("[data-look]")) {
    button.addEventListener("click", () => cloudView?.look(button.dataset["look"] as Viewpoint));
  }
  change("show-skeleton", setSkeleton);
  change("show-cloud", (isOn) => setInSpace("show-cloud", isOn));
  change("show-surface", (isOn) => setInSpace("show-surface", isOn));
  for (const id of ["range-auto", "range-near", "range-far"]) change(id, setRange);
  element("image-kind").addEventListener("change", (event) => chooseImage((event.target as HTMLInputElement).value as ImageKind));
  listenToProbe();
  const resizes = new ResizeObserver(() => { state.imageChanged = state.cloudChanged = true; shownTicks = ""; });
  for (const screen of document.querySelectorAll(".screen")) resizes.observe(screen);
}

/** Says the distance under the pointer. */
function listenToProbe(): void {
  const canvas = element<HTMLCanvasElement>("image");
  const probe = element("probe");
  canvas.addEventListener("pointermove", (event) => {
    const pixel = state.header && imageView.pixelAt(event.offsetX, event.offsetY);
    probe.hidden = !pixel;
    if (!pixel) return;
    const count = images.depth[pixel[1] * images.width + pixel[0]]!;
    setText(probe, `${pixel[0]}, ${pixel[1]}: ${count === 0 ? "not measured" : `${Math.round(count * state.header!.depth_unit_mm)} mm`}`);
  });
  canvas.addEventListener("pointerleave", () => { probe.hidden = true; });
}

function shortcuts(): Shortcut[] {
  const press = (id: string) => (): void => { if (!element<HTMLButtonElement>(id).disabled) element(id).click(); };
  return [
    { keys: [" "], shown: "Space", does: "pause, play", act: press("pause") },
    { keys: ["."], shown: ".", does: "pause, and one frame on", act: () => step(1), repeats: true },
    { keys: [","], shown: ",", does: "pause, and one frame back", act: () => step(-1), repeats: true },
    { keys: ["r", "R"], shown: "R", does: "start and stop a recording", act: press("record") },
    { keys: ["s", "S"], shown: "S", does: "save a screenshot (PNG)", act: press("screenshot") },
    { keys: ["i", "I"], shown: "I", does: "depth, infrared", act: () => chooseImage(imageView.kind === "depth" ? "infrared" : "depth") },
    { keys: ["k", "K"], shown: "K", does: "skeleton on and off", act: () => flip("show-skeleton") },
    { keys: ["p", "P"], shown: "P", does: "points on and off", act: () => flip("show-cloud") },
    { keys: ["f", "F"], shown: "F", does: "fitted surface on and off", act: () => flip("show-surface") },
    { keys: ["a", "A"], shown: "A", does: "range of colours automatic or fixed", act: () => flip("range-auto") },
    { keys: ["1"], shown: "1", does: "look from the camera", act: () => cloudView?.look("front") },
    { keys: ["2"], shown: "2", does: "look from the side", act: () => cloudView?.look("side") },
    { keys: ["3"], shown: "3", does: "look from above", act: () => cloudView?.look("top") },
    { keys: ["0"], shown: "0", does: "aim at the hand again", act: resetView },
    { keys: ["c", "C"], shown: "C", does: "try to connect now", act: () => connection.retry() },
    { keys: ["t", "T"], shown: "T", does: "theme: as the system, light, dark", act: press("theme") },
    { keys: ["?"], shown: "?", does: "this list", act: openHelp },
  ];
}

function listenToAllKeys(): void {
  const kKey = "knuckle.keys";
  const box = element<HTMLInputElement>("keys-on");
  box.checked = remembered(kKey) !== "off";
  box.addEventListener("change", () => remember(kKey, box.checked ? "on" : "off"));
  const list = shortcuts();
  listenToKeys(list, () => box.checked);
  listenToTurningKeys(element("cloud"), () => cloudView);
  listShortcuts(element("shortcuts"), [
    ...list,
    { shown: "← → ↑ ↓", does: `in the points: turn by ${kTurn_deg}°; with Shift: move` },
    { shown: "+ −", does: "in the points: zoom" },
  ]);
}

function drawScale(): void {
  const context = element<HTMLCanvasElement>("scale-bar").getContext("2d")!;
  context.putImageData(new ImageData(new Uint8ClampedArray(palette), 256, 1), 0, 0);
}

/** For tests, and for the curious in the browser's console. */
Object.assign(globalThis, {
  knuckle: {
    seenFrom: () => cloudView?.seenFrom() ?? null,
    frame: () => state.header?.record.frame ?? null,
    header: () => state.header,
    counts: () => ({ received: state.received, shown: state.shown, malformed: state.malformed }),
  },
});

restoreTheme();
showTheme();
drawScale();
listenToControls();
listenToAllKeys();
void connection.open();
requestAnimationFrame(tick);
