// SPDX-License-Identifier: Apache-2.0
// The page before the real `knuckle live --view`, which plays a synthetic sequence. $KNUCKLE_PROGRAM is the program.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { mkdtempSync, readdirSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { after, before, test } from "node:test";
import { fileURLToPath } from "node:url";
import { imageAt, launch, left, pictureOf, right, seenAt } from "./browser.mjs";
import { colourAt } from "./png.mjs";

const project = join(dirname(fileURLToPath(import.meta.url)), "..", "..");
const program = process.env.KNUCKLE_PROGRAM;
let browser, folder, knuckle, address, page;
const faults = [];

before(async () => {
  if (!program) return;
  folder = mkdtempSync(join(tmpdir(), "knuckle-page-"));
  knuckle = spawn(program, ["live", "--source", "synthetic:manifests/demo.toml?rate=15&loop=1", "--view", "0", "--record-folder", folder], { cwd: project });
  address = await new Promise((done, fail) => {
    let said = "";
    knuckle.stderr.on("data", (text) => {
      said += text;
      const found = /view: (http:\S+)/.exec(said);
      if (found) done(found[1]);
    });
    knuckle.on("exit", (status) => fail(new Error(`knuckle ended with ${status}: ${said}`)));
  });
  browser = await launch();
  page = await browser.newPage({ viewport: { width: 1280, height: 800 } });
  page.on("console", (message) => { if (message.type() === "error") faults.push(message.text()); });
  page.on("pageerror", (error) => faults.push(String(error)));
  await page.goto(address);
});

after(async () => {
  if (!program) return;
  await browser?.close();
  knuckle.kill("SIGINT");
  if (knuckle.exitCode === null && knuckle.signalCode === null) await new Promise((done) => knuckle.on("exit", done));
  rmSync(folder, { recursive: true, force: true });
});

const skip = program ? false : "no $KNUCKLE_PROGRAM";

test("frames come, and the skeleton is where the record says", { skip }, async () => {
  const hasHand = () => Object.keys(globalThis.knuckle.header()?.record.hands[0]?.landmarks_px ?? {}).length === 22;
  await page.waitForFunction(() => globalThis.knuckle.header() !== null, null, { timeout: 60_000 });
  await page.keyboard.press(" ");
  for (let i = 0; i < 30 && !(await page.evaluate(hasHand)); ++i) {
    const before = await page.evaluate(() => globalThis.knuckle.frame());
    await page.keyboard.press(".");
    await page.waitForFunction((frame) => globalThis.knuckle.frame() !== frame, before);
  }
  await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
  const { record, camera } = await page.evaluate(() => globalThis.knuckle.header());
  const hand = record.hands[0];
  assert.ok(hand, "the frame that is paused has a hand");
  const tone = hand.side === "left" ? left : right;
  const away = (colour) => Math.hypot(...colour.map((value, i) => value - tone[i]));
  const from = await page.evaluate(() => globalThis.knuckle.seenFrom());
  const image = await pictureOf(page, "#image");
  const cloud = await pictureOf(page, "#cloud");
  await page.keyboard.press("k");
  const plainImage = await pictureOf(page, "#image");
  const plainCloud = await pictureOf(page, "#cloud");
  /** In how many places the skeleton brings a pixel nearer to the hand's colour: unsure landmarks are faint. */
  const tinted = (picture, plain, places) => places.filter((place) => away(colourAt(picture, ...place)) < away(colourAt(plain, ...place)) - 8).length;
  const inImage = Object.values(hand.landmarks_px).filter(Boolean).map((point) => imageAt(point, camera, image.width, image.height));
  const inSpace = Object.values(hand.landmarks_mm).filter(Boolean).map((point) => seenAt(point, from, cloud.width, cloud.height));
  assert.ok(hand.side === null || tinted(image, plainImage, inImage) >= 0.8 * inImage.length, `${tinted(image, plainImage, inImage)} in the image`);
  assert.ok(hand.side === null || tinted(cloud, plainCloud, inSpace) >= 0.8 * inSpace.length, `${tinted(cloud, plainCloud, inSpace)} in space`);
  await page.keyboard.press("k");
  await page.keyboard.press(" ");
});

test("a recording is begun and ended from the page", { skip }, async () => {
  await page.click("#record");
  await page.waitForFunction(() => /\.h5: [1-9]\d* frames/.test(document.getElementById("recording-text").textContent), null, { timeout: 30_000 });
  await page.click("#record");
  await page.waitForFunction(() => /^off/.test(document.getElementById("recording-text").textContent), null, { timeout: 30_000 });
  for (let i = 0; i < 100 && !readdirSync(folder).some((name) => name.endsWith(".h5")); ++i) await page.waitForTimeout(100);
  assert.equal(readdirSync(folder).filter((name) => name.endsWith(".h5")).length, 1);
});

test("the page says when knuckle has ended", { skip }, async () => {
  assert.deepEqual(faults, []);
  knuckle.kill("SIGINT");
  await page.waitForFunction(() => /Connection lost/.test(document.getElementById("notices").textContent), null, { timeout: 30_000 });
});
