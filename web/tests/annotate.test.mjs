// SPDX-License-Identifier: Apache-2.0
// The page for labelling before the real `knuckle annotate`. $KNUCKLE_PROGRAM is the program.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { readFileSync, readdirSync, rmSync, mkdtempSync, existsSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, afterEach, before, test } from "node:test";
import { Annotate, correctFarthest, dragInPoints, dragTo, errorOf, normals, openFrame, quiet, runProgram, shown, toSpace, truthOf } from "./annotator.mjs";
import { launch, pictureOf } from "./browser.mjs";
import { colourAt, decodePng } from "./png.mjs";

const program = process.env.KNUCKLE_PROGRAM;
const skip = program ? false : "no $KNUCKLE_PROGRAM";
const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
const kFrames = 6;
let browser, folder, source, truth;
const opened = [];

before(async () => {
  if (!program) return;
  folder = mkdtempSync(join(tmpdir(), "knuckle-annotate-"));
  runProgram(program, ["render", "--manifest", "manifests/test_scenes.toml", "--count", String(kFrames), "--format", "folder", "--out", join(folder, "scenes")]);
  source = `folder:${join(folder, "scenes")}`;
  truth = truthOf(join(folder, "scenes"));
  browser = await launch();
});

afterEach(async () => {
  for (const one of opened.splice(0)) await one();
});

after(async () => {
  if (!program) return;
  await browser?.close();
  rmSync(folder, { recursive: true, force: true });
});

let sets = 0;

/** The program with labels of its own; `labels` goes on with some. `most_kB`: its files may grow no larger, as on a full disk. */
async function annotate({ labels = `labels${++sets}`, prelabel = true, more = [], most_kB = null } = {}) {
  const args = ["--source", source, "--labels", join(folder, labels), ...(prelabel ? ["--prelabel", "pipelines/default.toml"] : []), ...more];
  const knuckle = await Annotate.start(program, args, most_kB);
  opened.push(async () => { if (knuckle.process.exitCode === null && knuckle.process.signalCode === null) await knuckle.stop(); });
  return { ...knuckle, process: knuckle.process, stop: (signal) => knuckle.stop(signal), address: knuckle.address, file: join(folder, labels, "labels.jsonl") };
}

async function pageAt(address, options = {}) {
  const context = await browser.newContext({ viewport: { width: 1440, height: 900 }, ...options });
  const page = await context.newPage();
  page.faults = [];
  page.on("console", (message) => { if (message.type() === "error" && !/409/.test(message.text())) page.faults.push(message.text()); });
  page.on("pageerror", (error) => page.faults.push(String(error)));
  opened.unshift(() => context.close());
  await page.goto(address);
  await page.waitForFunction(() => globalThis.knuckle?.header() !== null, null, { timeout: 60_000 });
  await quiet(page);
  return page;
}

const linesOf = (file) => readFileSync(file, "utf8").trim().split("\n").slice(1).map((line) => JSON.parse(line));
const says = (page, selector, pattern) => page.waitForFunction(
  ([where, text]) => new RegExp(text).test(document.querySelector(where)?.textContent ?? ""), [selector, pattern.source], { timeout: 20_000 });

test("a landmark is dragged onto its pixel, and the file has it", { skip }, async () => {
  const { address, file } = await annotate();
  const page = await pageAt(address);
  const names = Object.keys((await shown(page)).hands[0].landmarks_px);
  const tip = names.indexOf("middle_tip");
  await dragTo(page, "middle_tip", truth[0][tip].slice(0, 2));
  const { hands, labels } = await shown(page);
  assert.equal(labels[0].landmarks.middle_tip.state, "corrected");
  assert.ok(Math.hypot(...hands[0].landmarks_px.middle_tip.map((value, i) => value - truth[0][tip][i])) < 0.6, "within a pixel of the screen");
  const last = linesOf(file).filter((line) => line.frame === 0).at(-1);
  assert.equal(last.act, "correct");
  assert.equal(last.landmarks.middle_tip[0], "corrected");
  assert.ok(last.seconds > 0);
  assert.deepEqual(page.faults, []);
});

test("corrections with a tremble bring the hand nearer to the truth", { skip }, async (t) => {
  const { address } = await annotate();
  const page = await pageAt(address);
  const normal = normals(7);
  let before = 0, after = 0;
  for (let frame = 0; frame < 3; ++frame) {
    await openFrame(page, frame);
    before += errorOf(await shown(page), truth[frame]) / 3;
    for (let i = 0; i < 4 && (await correctFarthest(page, truth[frame], normal)); ++i);
    after += errorOf(await shown(page), truth[frame]) / 3;
  }
  t.diagnostic(`${before.toFixed(2)} mm before, ${after.toFixed(2)} mm after`);
  assert.ok(after < before, `${before} mm before, ${after} mm after`);
});

test("a landmark is moved in the points, seen from the side: its depth is corrected", { skip }, async () => {
  const { address } = await annotate();
  const page = await pageAt(address);
  const { camera } = await shown(page);
  const at = async () => (await shown(page)).hands[0].landmarks_mm.wrist;
  const before = await at();
  const goal = toSpace(truth[0][0], camera).map((value, i) => value + (i === 2 ? 25 : 0));
  await dragInPoints(page, "wrist", "side", goal);
  const after = await at();
  assert.ok(Math.abs(after[2] - goal[2]) < 4, `${before} moved to ${after}, meant ${goal}`);
  assert.ok(Math.abs(after[0] - before[0]) < 8, "what the view does not show stays");
  assert.deepEqual(page.faults, []);
});

test("keys: fine steps, visibility, undo and redo without end, verify and go on", { skip }, async () => {
  const { address, file } = await annotate();
  const page = await pageAt(address);
  const px = async () => (await shown(page)).hands[0].landmarks_px.wrist;
  const before = await px();
  for (let i = 0; i < 4; ++i) await page.keyboard.press("ArrowRight");
  await page.keyboard.press("+");
  await quiet(page);
  const moved = await px();
  assert.ok(Math.abs(moved[0] - before[0] - 2) < 0.05 && Math.abs(moved[1] - before[1]) < 0.05, `${before} to ${moved}`);
  const revisions = linesOf(file).filter((line) => line.frame === 0).length;
  assert.equal(revisions, 6);
  const was = (await shown(page)).labels[0].landmarks.wrist.visible;
  await page.keyboard.press("h");
  await quiet(page);
  assert.equal((await shown(page)).labels[0].landmarks.wrist.visible, !was);
  for (let i = 0; i < 6; ++i) await page.keyboard.press("z");
  await quiet(page);
  assert.deepEqual(await px(), before);
  await page.keyboard.press("z");
  await says(page, "#notices", /nothing to undo/);
  for (let i = 0; i < 6; ++i) await page.keyboard.press("y");
  await quiet(page);
  assert.deepEqual(await px(), moved);
  await page.keyboard.press("Enter");
  await page.waitForFunction(() => globalThis.knuckle.frame() === 1);
  assert.equal(linesOf(file).filter((line) => line.frame === 0).at(-1).act, "verify");
  await page.keyboard.press(",");
  await page.waitForFunction(() => globalThis.knuckle.frame() === 0 && globalThis.knuckle.labels()[0].state === "verified");
  await says(page, "#progress", /^1 of 6 frames/);
});

test("a landmark is dragged in the points, in the screen's plane", { skip }, async () => {
  const { address } = await annotate();
  const page = await pageAt(address);
  await page.click("[data-look=side]");
  const before = (await shown(page)).hands[0].landmarks_mm.thumb_tip;
  await page.locator("#landmarks button", { hasText: /^thumb tip$/ }).click();
  const box = await page.locator("#cloud").boundingBox();
  const at = await page.evaluate(() => globalThis.knuckle.cloudAt(globalThis.knuckle.header().record.hands[0].landmarks_mm.thumb_tip));
  await page.mouse.move(box.x + at[0], box.y + at[1]);
  await page.mouse.down();
  await page.mouse.move(box.x + at[0] + 30, box.y + at[1], { steps: 3 });
  await page.mouse.up();
  await quiet(page);
  const { hands, labels } = await shown(page);
  const moved = hands[0].landmarks_mm.thumb_tip.map((value, i) => value - before[i]);
  assert.equal(labels[0].landmarks.thumb_tip.state, "corrected");
  assert.ok(Math.abs(moved[2]) > 3 * Math.abs(moved[1]) && Math.abs(moved[2]) > 1.5 * Math.abs(moved[0]), `seen from the side it moves in depth: ${moved}`);
});

const maskOf = (page) => page.evaluate(() => globalThis.knuckle.labels()[0].mask);

/** 1 where a pixel is hand, row by row. */
function pixelsOf([width, height, ...runs]) {
  const pixels = new Uint8Array(width * height);
  let at = 0;
  runs.forEach((run, i) => { pixels.fill(i % 2, at, at += run); });
  assert.equal(at, width * height);
  return pixels;
}

/** Paints from one pixel to another with what is chosen. */
async function strokeOver(page, from, to) {
  const box = await page.locator("#image").boundingBox();
  const ends = await page.evaluate((two) => two.map((at) => globalThis.knuckle.imageAt(at)), [from, to]);
  await page.mouse.move(box.x + ends[0][0], box.y + ends[0][1]);
  await page.mouse.down();
  await page.mouse.move(box.x + ends[1][0], box.y + ends[1][1], { steps: 4 });
  await page.mouse.up();
  await quiet(page);
}

/** The mask of frame 0 in an exported folder set. */
function writtenMask(set) {
  const [file] = readdirSync(join(set, "mask")).sort();
  const { pixels } = decodePng(readFileSync(join(set, "mask", file)));
  return Uint8Array.from({ length: pixels.length / 4 }, (_, i) => (pixels[4 * i] > 0 ? 1 : 0));
}

test("a mask is begun with the model, painted, erased, undone; a kill loses no stroke, and exports have it to the pixel", { skip }, async () => {
  const { address, file, stop } = await annotate({ labels: "masks" });
  const page = await pageAt(address);
  assert.equal(await maskOf(page), null);
  await page.keyboard.press("g");
  await quiet(page);
  const outline = pixelsOf(await maskOf(page));
  const { width } = await page.evaluate(() => globalThis.knuckle.header());
  const at = ([column, row]) => row * width + column;
  assert.ok(outline.reduce((sum, pixel) => sum + pixel, 0) > 200);
  const corner = await page.evaluate(() => globalThis.knuckle.placeAt(30, 75).map(Math.round));
  assert.equal(outline[at(corner)], 0, "beside the hand");

  const before = await pictureOf(page, "#image");
  await page.keyboard.press("b");
  await page.keyboard.press("{");
  assert.equal(await page.evaluate(() => globalThis.knuckle.brush_px()), 3);
  const end = [corner[0] + 12, corner[1]];
  await strokeOver(page, corner, end);
  const painted = await maskOf(page);
  assert.equal(pixelsOf(painted)[at([corner[0] + 6, corner[1] + 2])], 1);
  assert.equal(pixelsOf(painted)[at([corner[0] + 6, corner[1] + 5])], 0);
  const seen = (await page.evaluate((pixel) => globalThis.knuckle.imageAt(pixel), [corner[0] + 6, corner[1]])).map(Math.round);
  const after = await pictureOf(page, "#image");
  assert.ok(colourAt(after, ...seen)[0] > colourAt(before, ...seen)[0] + 30, "it is seen");

  await page.keyboard.press("e");
  await strokeOver(page, corner, corner);
  const erased = await maskOf(page);
  assert.equal(pixelsOf(erased)[at(corner)], 0);
  assert.equal(pixelsOf(erased)[at([corner[0] + 10, corner[1]])], 1);
  await page.keyboard.press("z");
  await quiet(page);
  assert.deepEqual(await maskOf(page), painted);
  await page.keyboard.press("y");
  await quiet(page);
  assert.deepEqual(await maskOf(page), erased);
  assert.equal((await shown(page)).labels[0].landmarks.wrist.state, "estimated", "the brush places no landmark");
  await page.keyboard.press("l");
  await page.keyboard.press("v");
  await quiet(page);
  assert.deepEqual(page.faults, []);
  assert.ok(linesOf(file).some(({ act, mask }) => act === "brush" && mask.length > 2));
  await stop("SIGKILL");

  const again = await pageAt((await annotate({ labels: "masks" })).address);
  assert.deepEqual(await maskOf(again), erased);
  const labels = join(folder, "masks");
  const [set, h5, back] = ["masks_set", "masks.h5", "masks_back"].map((name) => join(folder, name));
  runProgram(program, ["labels", "export", "--source", source, "--labels", labels, "--out", set]);
  assert.deepEqual(writtenMask(set), pixelsOf(erased));
  runProgram(program, ["labels", "export", "--source", source, "--labels", labels, "--format", "h5", "--out", h5]);
  runProgram(program, ["labels", "import", "--source", `h5:${h5}`, "--labels", join(folder, "masks_of_h5")]);
  runProgram(program, ["labels", "export", "--source", `h5:${h5}`, "--labels", join(folder, "masks_of_h5"), "--out", back]);
  assert.deepEqual(writtenMask(back), pixelsOf(erased));
});

test("both hands of a frame are exported, each in a poses file", { skip }, () => {
  const labels = join(folder, "both");
  for (const side of ["right", "left"]) runProgram(program, ["labels", "import", "--source", source, "--labels", labels, "--side", side]);
  const poses = (name, more = []) => {
    runProgram(program, ["labels", "export", "--source", source, "--labels", labels, "--format", "poses", "--out", join(folder, `${name}.txt`), ...more]);
    return [`${name}.txt`, `${name}.hand2.txt`].map((file) => (existsSync(join(folder, file)) ? readFileSync(join(folder, file), "utf8") : null));
  };
  const [first, second] = poses("both");
  assert.equal(first.trim().split("\n").length, kFrames + 1);
  assert.equal(second, first, "the same joints were imported for both sides");
  assert.equal(poses("one", ["--side", "left"])[1], null);
});

test("two pages on the same frame: the second is told", { skip }, async () => {
  const { address, file } = await annotate();
  const first = await pageAt(address);
  const second = await pageAt(address);
  await first.keyboard.press("ArrowRight");
  await quiet(first);
  await says(second, "#notices", /changed elsewhere/);
  await second.waitForFunction(() => globalThis.knuckle.labels()[0].revision === 2);
  // Both at once: one is accepted, the other is told and sees how it stands.
  await Promise.all([first.keyboard.press("v"), second.keyboard.press("ArrowDown")]);
  await Promise.all([quiet(first), quiet(second)]);
  await first.waitForTimeout(500);
  const revision = (page) => page.evaluate(() => globalThis.knuckle.labels()[0].revision);
  assert.equal(await revision(first), await revision(second));
  const revisions = linesOf(file).filter((line) => line.frame === 0).map((line) => line.revision);
  assert.deepEqual(revisions, revisions.map((_, i) => i + 1));
});

test("a hand is labelled from nothing, by clicks", { skip }, async () => {
  const { address } = await annotate({ prelabel: false });
  const page = await pageAt(address);
  await says(page, "#empty", /No right hand is labelled/);
  const names = await page.locator("#landmarks button").allInnerTexts();
  assert.equal(names.length, 22);
  for (const name of ["wrist", "index_mcp", "little_mcp", "middle_tip"]) {
    await dragTo(page, name, truth[0][names.indexOf(name.replaceAll("_", " "))].slice(0, 2));
  }
  const { hands, labels } = await shown(page);
  assert.equal(Object.values(hands[0].landmarks_px).filter(Boolean).length, 22, "the model gives the others");
  assert.equal(Object.values(labels[0].landmarks).filter((one) => one.state === "corrected").length, 4);
  assert.deepEqual(page.faults, []);
});

/** Pixels of the hand that are seen in the points as well, spread over it: those that a click there finds. */
function seenInPoints(page, joints) {
  return page.evaluate((pixels) => pixels.map((pixel) => {
    const { camera } = globalThis.knuckle.header();
    const depth_mm = globalThis.knuckle.depth_mm(...pixel);
    const at = depth_mm > 0 ? [((pixel[0] - camera.cx) / camera.fx) * depth_mm, ((pixel[1] - camera.cy) / camera.fy) * depth_mm, depth_mm] : null;
    return { pixel, depth_mm, at: at && globalThis.knuckle.cloudAt(at) };
  }).filter(({ at }) => at !== null), joints.map((joint) => joint.slice(0, 2).map(Math.round)));
}

test("a click on a measured point places the landmark that is chosen, labelled or not; a drag there turns", { skip }, async () => {
  const { address, file } = await annotate({ prelabel: false });
  const page = await pageAt(address);
  await page.keyboard.press("1");
  await quiet(page);
  const { pixel, depth_mm, at } = (await seenInPoints(page, truth[0].filter(Boolean)))[0];
  const box = await page.locator("#cloud").boundingBox();
  await page.mouse.click(box.x + at[0], box.y + at[1]);
  await quiet(page);
  const { labels, hands } = await shown(page);
  assert.equal(labels[0].landmarks.wrist.state, "corrected", "it was not labelled before");
  const placed = hands[0].landmarks_px.wrist;
  assert.ok(Math.hypot(placed[0] - pixel[0], placed[1] - pixel[1]) < 3, `${placed}, clicked on ${pixel}`);
  const below_mm = hands[0].landmarks_mm.wrist[2] - depth_mm;
  assert.ok(below_mm > 2 && below_mm < 60, `${below_mm} mm below the skin`);
  assert.equal(linesOf(file).at(-1).act, "correct");
  const lines = linesOf(file).length;
  await page.mouse.move(box.x + 12, box.y + 12);
  await page.mouse.down();
  await page.mouse.move(box.x + 60, box.y + 12, { steps: 4 });
  await page.mouse.up();
  await page.keyboard.press("b");
  await page.mouse.click(box.x + at[0], box.y + at[1]);
  await quiet(page);
  assert.equal(linesOf(file).length, lines, "neither turning, nor a click with the brush");
  assert.deepEqual(page.faults, []);
});

test("on a full disk the page says so, and that all is well once there is room", { skip }, async () => {
  const { address, file, process: knuckle } = await annotate({ prelabel: false, most_kB: 6 });
  const page = await pageAt(address);
  await dragTo(page, "wrist", truth[0][0].slice(0, 2));
  assert.equal(await page.locator("#notices").isVisible(), false);
  let changes = 1;
  for (; changes < 40 && !/cannot be written/.test(await page.locator("#notices").textContent()); ++changes) {
    await page.keyboard.press("ArrowRight");
    await quiet(page);
  }
  await says(page, "#notices", /The labels cannot be written: .*labels\.jsonl.* 1 changes wait/);
  const written = linesOf(file).length;
  assert.equal(written, changes - 1);
  execFileSync("prlimit", ["--pid", String(knuckle.pid), "--fsize=unlimited"]);
  await page.keyboard.press("ArrowLeft");
  await quiet(page);
  await page.waitForFunction(() => !/cannot be written/.test(document.querySelector("#notices").textContent));
  assert.equal(linesOf(file).length, changes + 1, "what waited is written, in its order");
  assert.deepEqual(linesOf(file).map(({ revision }) => revision), Array.from({ length: changes + 1 }, (_, i) => i + 1));
});

/** What a pressed key is called in the list of keys. */
function listedAs({ key, ctrlKey }) {
  const names = { ArrowLeft: "←", ArrowRight: "→", ArrowUp: "↑", ArrowDown: "↓", "-": "−", "=": "+" };
  return `${ctrlKey ? "Ctrl+" : ""}${names[key] ?? (key.length === 1 ? key.toUpperCase() : key)}`;
}

test("the list of keys has every key that does anything, and no other", { skip }, async () => {
  const { address } = await annotate();
  const page = await pageAt(address);
  const printable = Array.from({ length: 95 }, (_, i) => String.fromCharCode(32 + i));
  const named = ["ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown", "PageUp", "PageDown", "Home", "End", "Enter", "Escape", "Tab", "Backspace", "Delete", "Insert",
    ...Array.from({ length: 12 }, (_, i) => `F${i + 1}`)];
  const presses = [...printable, ...named].flatMap((key) => [{ key, ctrlKey: false }, { key, ctrlKey: true }]);
  const handled = await page.evaluate((all) => all.filter((press) => {
    const isHandled = ["#image", "#cloud"].map((where) => !document.querySelector(where)
      .dispatchEvent(new KeyboardEvent("keydown", { ...press, bubbles: true, cancelable: true }))).some(Boolean);
    document.querySelector("dialog[open]")?.close();
    return isHandled;
  }), presses);
  const listed = (await page.locator("#shortcuts kbd").allTextContents()).map((cap) => cap.replace("\u00a0", " "));
  const ofPointer = ["click", "drag", "wheel", "right button"];
  assert.deepEqual([...new Set(handled.map(listedAs))].sort(), listed.filter((cap) => !ofPointer.includes(cap)).sort());
  for (const cap of ofPointer) assert.ok(listed.includes(cap), cap);
});

test("killed at random while labels change: no accepted change is lost", { skip }, async () => {
  const labels = "killed";
  let accepted = 0;
  for (let round = 0; round < 3; ++round) {
    const { address, process: knuckle, stop, file } = await annotate({ labels });
    let isAlive = true;
    const ended = new Promise((done) => knuckle.on("exit", () => { isAlive = false; done(); }));
    const post = (body) => fetch(`${address}api/labels`, { method: "POST", body: JSON.stringify(body) });
    await fetch(`${address}api/frame?index=0`);
    let revision = linesOf(file).filter((line) => line.frame === 0).length;
    assert.ok(revision >= accepted, `${revision} in the file, ${accepted} were accepted`);
    setTimeout(() => void stop("SIGKILL"), 200 + 150 * round);
    while (isAlive) {
      try {
        const answer = await post({ act: "place", frame: 0, side: truthSide(file), revision, landmark: "wrist", pixel: [100 + (revision % 50), 100] });
        if (answer.status === 200) revision = (await answer.json()).labels[0].revision;
        accepted = Math.max(accepted, revision);
      } catch {
        // it is dead
      }
    }
    await ended;
  }
  assert.ok(accepted > 3);
  runProgram(program, ["labels", "export", "--source", source, "--labels", join(folder, labels), "--state", "corrected", "--format", "poses", "--out", join(folder, "killed.txt")]);
  assert.ok(existsSync(join(folder, "killed.txt")));
});

function truthSide(file) {
  return linesOf(file).find((line) => line.frame === 0).side;
}

for (const [width, height] of [[1440, 900], [1024, 700], [360, 740]]) {
  for (const colorScheme of ["light", "dark"]) {
    test(`${width} px wide, ${colorScheme}`, { skip }, async () => {
      const { address } = await annotate();
      const page = await pageAt(address, { viewport: { width, height }, colorScheme, reducedMotion: "reduce" });
      const seriousFaults = async () => {
        await page.evaluate(axe);
        const { violations } = await page.evaluate(() => globalThis.axe.run(document, { resultTypes: ["violations"] }));
        return violations.filter(({ impact }) => ["serious", "critical"].includes(impact)).map(({ id, nodes }) => `${id}: ${nodes.map((node) => node.html).join(" ")}`);
      };
      assert.deepEqual(await seriousFaults(), []);
      const overflow = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
      assert.ok(overflow <= 0, `${overflow} px stick out to the right`);
      await page.keyboard.press("?");
      assert.deepEqual(await seriousFaults(), []);
      await page.keyboard.press("Escape");
      assert.deepEqual(page.faults, []);
    });
  }
}
