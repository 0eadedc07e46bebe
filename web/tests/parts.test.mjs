// SPDX-License-Identifier: Apache-2.0
// Parts of the pages that need no browser: ranges, colours, history, rates, what changes of labels ask for.
import assert from "node:assert/strict";
import { test } from "node:test";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import * as esbuild from "esbuild";
import { encodeFrame } from "./mock_server.mjs";
import * as scene from "./scene.mjs";

/** A source of the page as a module of Node's. */
async function load(name) {
  const { outputFiles } = await esbuild.build({
    entryPoints: [join(dirname(fileURLToPath(import.meta.url)), "..", "src", `${name}.ts`)],
    bundle: true, write: false, format: "esm", logLevel: "silent",
  });
  return import(`data:text/javascript;base64,${Buffer.from(outputFiles[0].contents).toString("base64")}`);
}

const { AnnotateChanges } = await load("annotate_changes");
const { AnnotateState } = await load("annotate_state");
const { DepthRange, roundTicks } = await load("depth_range");
const { depthPalette, handColours, srgbOfOklch } = await load("palette");
const { History } = await load("history");
const { Rate, Samples } = await load("chart");
const { inSensor, pixelSeenAt } = await load("seen_pixel");
const { PointBudget } = await load("point_budget");
const { FrameImages, readFrame, readInfo, readRecording } = await load("protocol");

const bufferOf = (bytes) => bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength);

test("a message is read back as it was written, at even and odd places", () => {
  const hands = [scene.makeHand()];
  const depth = scene.depthOf(hands);
  const infrared = scene.makeInfrared(depth);
  for (const padding of [0, 1, 2, 3]) {
    const header = scene.makeHeader({ frame: 3, hands, infrared: true });
    const message = readFrame(bufferOf(encodeFrame(header, depth, infrared, padding)));
    assert.deepEqual(message.header.record.hands[0].landmarks_mm, hands[0].landmarks_mm);
    const images = new FrameImages();
    images.take(message);
    assert.deepEqual(images.depth, depth);
    assert.deepEqual(images.infrared, infrared);
  }
});

test("memory of images is kept from frame to frame", () => {
  const images = new FrameImages();
  const message = readFrame(bufferOf(encodeFrame(scene.makeHeader({}), scene.depthOf([]))));
  images.take(message);
  const before = images.depth;
  images.take(message);
  assert.equal(images.depth, before);
});

test("what may be missing in descriptions and states has a meaning", () => {
  assert.deepEqual(readInfo({ camera: null }).bones, []);
  assert.equal(readInfo({}).can_record, false);
  assert.equal(readRecording(null), null);
  assert.deepEqual(readRecording({ file: null }), { file: null, frames: 0, dropped: 0, fault: "" });
  assert.throws(() => readInfo([]), /not an object/);
});

test("the range of colours spans nearly all pixels, and follows slowly", () => {
  const range = new DepthRange();
  const depth = Uint16Array.from({ length: 70000 }, (_, i) => (i % 10 === 0 ? 0 : 500 + (i % 1000)));
  range.follow(depth, 2);
  assert.ok(Math.abs(range.near_mm - 1000) < 130 && Math.abs(range.far_mm - 2960) < 130, `${range.near_mm} ${range.far_mm}`);
  const { near_mm } = range;
  range.follow(depth.map((count) => 2 * count), 2);
  assert.ok(range.near_mm > near_mm && range.near_mm < near_mm + 200);
  const empty = new DepthRange();
  empty.follow(new Uint16Array(100), 1);
  assert.ok(empty.far_mm > empty.near_mm, "an image without depth changes nothing");
  assert.equal(range.fix(500, 400), false);
  assert.equal(range.fix(NaN, 400), false);
  assert.equal(range.fix(400, 500), true);
});

test("ticks are round, few and within the range", () => {
  for (const [near, far] of [[0, 1], [396, 1094], [300, 320], [0, 65535], [499.9, 10000]]) {
    const ticks = roundTicks(near, far);
    assert.ok(ticks.length >= 2 && ticks.length <= 7, `${near} ${far}: ${ticks}`);
    assert.ok(ticks.every((tick) => tick >= near && tick <= far));
  }
});

test("depth grows darker evenly from near to far", () => {
  const palette = depthPalette();
  const luminance = (i) => [0.2126, 0.7152, 0.0722].reduce((sum, weight, k) => sum + weight * (palette[4 * i + k] / 255) ** 2.2, 0);
  for (let i = 8; i < 256; ++i) assert.ok(luminance(i) < luminance(i - 8), `shade ${i}`);  // single steps are below what bytes tell
  assert.deepEqual(srgbOfOklch(1, 0, 0), [255, 255, 255]);
  assert.deepEqual(srgbOfOklch(0, 0, 0), [0, 0, 0]);
  assert.deepEqual(srgbOfOklch(0.6279554, 0.2576833, 29.2338805), [255, 0, 0]);  // red of sRGB
});

test("hands of one side have shades of their own, whatever their order", () => {
  const hands = [{ id: 7, side: "right" }, { id: 2, side: "right" }, { id: 3, side: "left" }, { id: 5, side: null }];
  const colours = handColours(hands);
  assert.equal(new Set(colours).size, 4);
  assert.deepEqual(handColours([...hands].reverse()), [...colours].reverse());
});

test("history is bounded in number and memory, and one walks in it", () => {
  const message = (frame, bytes) => ({ frame, buffer: new ArrayBuffer(bytes) });
  const history = new History();
  for (let frame = 0; frame < 500; ++frame) history.add(message(frame, 10));
  let steps = 0;
  for (let shown = history.move(-1); shown; shown = history.move(-1)) assert.equal(shown.frame, 498 - steps++);
  assert.equal(steps, 89);
  assert.equal(history.canGoBack(), false);
  assert.equal(history.move(1).frame, 411);
  const large = new History();
  for (let frame = 0; frame < 5; ++frame) large.add(message(frame, 20 << 20));
  assert.equal(large.move(-1).frame, 3);
  assert.equal(large.move(-1), null);
});

test("a rate is that of the last two seconds, and forgets another stream's count", () => {
  const rate = new Rate();
  assert.equal(rate.perSecond(0), null);
  for (let i = 0; i <= 90; ++i) rate.update(i * 20, i);
  assert.ok(Math.abs(rate.perSecond(1800) - 50) < 0.5);
  rate.update(1820, 0);
  assert.equal(rate.perSecond(1820), null);
  const samples = new Samples();
  for (let i = 0; i < 5000; ++i) samples.add(i, i);
  assert.equal(samples.percentile(0.5, 4000), 4500);
  assert.equal(samples.percentile(0.5, 6000), null);
});

test("points become fewer where pictures come too slowly, and more where there is time", () => {
  let now_ms = 5000;
  const after = (budget, seconds, perSecond) => {
    for (let i = 0; i < seconds * perSecond; ++i) budget.tick(now_ms += 1000 / perSecond);
    return budget.points;
  };
  const budget = new PointBudget(80_000);
  assert.equal(after(budget, 5, 60), 80_000, "never more than at the start");
  assert.equal(after(budget, 5, 30), 80_000, "fast enough");
  assert.equal(after(budget, 1.2, 10), 40_000);
  assert.equal(after(budget, 20, 10), 8_000, "never fewer");
  assert.equal(after(budget, 20, 30), 8_000, "not more at once: with more it would be too slow");
  assert.equal(after(budget, 1.2, 60), 16_000);
  assert.equal(after(budget, 10, 60), 80_000);
  now_ms += 3_600_000;  // the page was in the background
  assert.equal(after(budget, 0.9, 60), 80_000);
  for (let i = 0; i < 10; ++i) assert.equal(budget.tick(now_ms += 2000), false, "one picture in two seconds is no picture at all");
});

test("a changed budget is said once", () => {
  const budget = new PointBudget(80_000);
  let changes = 0;
  for (let i = 0; i < 24; ++i) changes += budget.tick(100 * i) ? 1 : 0;
  assert.deepEqual([changes, budget.points], [2, 20_000]);
});

/** A right hand with a wrist at [30, -40, 500] mm and its labels, and changes that wait until they are made by hand. */
function makeLabelled(camera = { model: "projective", fx: 400, fy: 500 }) {
  const state = new AnnotateState();
  const wrist = { state: "estimated", visible: true };
  state.frame = 7;
  state.header = { camera, record: { frame: 7, hands: [{ side: "right", landmarks_mm: { wrist: [30, -40, 500] } }] } };
  state.labels = [{ side: "right", revision: 3, landmarks: { wrist } }];
  const waiting = [];
  const changes = new AnnotateChanges({ state, queue: { add: (make) => waiting.push(make) } });
  return { state, changes, turn: () => waiting.shift()() };
}

test("a change is made on the labels as they stand when its turn comes", () => {
  const { state, changes, turn } = makeLabelled();
  changes.free();
  changes.toggleVisible();
  state.labels[0].revision = 4;
  state.labels[0].landmarks.wrist.visible = false;
  assert.deepEqual(turn(), { act: "free", frame: 7, side: "right", landmark: "wrist", revision: 4, model: true });
  assert.deepEqual(turn(), { act: "look", frame: 7, side: "right", landmark: "wrist", revision: 4, model: true, visible: true });
});

test("a change of a landmark is of the one that was chosen then, and of none that the hand lacks", () => {
  const { state, changes, turn } = makeLabelled();
  changes.nudge(1, 0, 0);
  state.choose("thumb_tip");
  state.chooseSide("left");
  changes.nudge(1, 0, 0);
  changes.toggleVisible();
  const { landmark, side } = turn();
  assert.deepEqual([landmark, side], ["wrist", "right"]);
  assert.equal(turn(), null);
  assert.equal(turn(), null);
  assert.equal(state.hand, null);
  assert.equal(state.revision, 0, "the left hand has no labels yet");
});

test("a fine step moves by pixels across the image, and along the line of sight without leaving its pixel", () => {
  const { changes, turn } = makeLabelled();
  const pixel = ([x, y, z]) => [(400 * x) / z, (500 * y) / z];
  const near = (found, wanted) => wanted.forEach((value, i) => assert.ok(Math.abs(found[i] - value) < 1e-9, `${found} is not ${wanted}`));
  changes.nudge(0.5, -4, 0);
  changes.nudge(0, 0, 5);
  const across = turn().point_mm;
  near(pixel(across), [24 + 0.5, -40 - 4]);
  assert.equal(across[2], 500);
  const away = turn().point_mm;
  near(pixel(away), [24, -40]);
  assert.equal(away[2], 505);
  const flat = makeLabelled({ model: "orthographic", fx: 2, fy: 4 });
  flat.changes.nudge(1, 1, 5);
  near(flat.turn().point_mm, [30.5, -39.75, 505]);
});

test("a click on the points means the pixel that is seen there: of the nearest surface, the nearest to the pointer", () => {
  const width = 60, height = 40;
  const camera = { model: "projective", fx: 50, fy: 50, cx: 30, cy: 20, distortion: [], pixel_origin: "centre" };
  const depth = new Uint16Array(width * height).fill(900);
  for (let row = 10; row < 30; ++row) depth.fill(500, row * width + 20, row * width + 35);
  depth[20 * width + 25] = 0;
  // Seen by the sensor itself, ten times as large: pixel (u, v) lies at (10 u, 10 v).
  const scale = 10, canvas = { width: 600, height: 400 };
  const toClip = ([x, y, z]) => [(2 * (camera.fx * x + camera.cx * z)) / width - z, z - (2 * (camera.fy * y + camera.cy * z)) / height, 0, z];
  const columns = [[1, 0, 0], [0, 1, 0], [0, 0, 1]].map(toClip);
  canvas.clipFromSensor = [...columns.flat(), 0, 0, 0, 0];
  const points = { depth, width, height, unit_mm: 1, camera, isDrawn: () => true };
  for (const pixel of [[3, 4], [30, 12], [34, 29]]) {
    assert.deepEqual(pixelSeenAt([scale * pixel[0] + 2, scale * pixel[1] - 3], points, canvas), pixel);
  }
  assert.equal(pixelSeenAt([250, 200], points, canvas), null, "nothing was measured there");
  assert.deepEqual(pixelSeenAt([346, 200], points, canvas), [34, 20], "the hand lies before the wall beside it");
  assert.equal(pixelSeenAt([300, 120], { ...points, isDrawn: (depth_mm) => depth_mm > 600 }, canvas), null, "points that are cut are not there");
  const behind = { ...canvas, clipFromSensor: canvas.clipFromSensor.map((value) => -value) };
  assert.equal(pixelSeenAt([300, 120], points, behind), null);
});

test("pixels are unprojected as cameras see them", () => {
  const camera = { model: "projective", fx: 100, fy: 110, cx: 30.5, cy: 20.5, distortion: [0.1, -0.05, 0.01, 0.02, 0.01], pixel_origin: "corner" };
  const [x, y, z] = inSensor(70, 45, 500, camera);
  const [a, b] = [x / z, y / z];
  const r2 = a * a + b * b;
  const radial = 1 + 0.1 * r2 - 0.05 * r2 ** 2 + 0.01 * r2 ** 3;
  const seen = [100 * (a * radial + 2 * 0.01 * a * b + 0.02 * (r2 + 2 * a * a)) + 30, 110 * (b * radial + 0.01 * (r2 + 2 * b * b) + 2 * 0.02 * a * b) + 20];
  assert.ok(Math.hypot(seen[0] - 70, seen[1] - 45) < 1e-4, `${seen}`);
  assert.deepEqual(inSensor(40, 20, 500, { ...camera, model: "orthographic", fx: 2, fy: 2, cx: 30, pixel_origin: "centre", cy: 10 }), [5, 5, 500]);
});

test("the landmark beside the last is the first", () => {
  const { state } = makeLabelled();
  state.chooseBeside(1);
  assert.equal(state.landmark, "wrist", "as long as no names are known");
  state.info = { landmarks: ["wrist", "palm", "thumb_tip"] };
  const passed = [-1, 1, 1].map((by) => {
    state.chooseBeside(by);
    return state.landmark;
  });
  assert.deepEqual(passed, ["thumb_tip", "wrist", "palm"]);
});
