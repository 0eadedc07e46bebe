// SPDX-License-Identifier: Apache-2.0
// Every control works, by pointer and by keyboard.
import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { after, afterEach, before, test } from "node:test";
import { closePages, imageAt, launch, OpenPage, right, screen, seenAt } from "./browser.mjs";
import { colourAt, decodePng, findColour, isLike } from "./png.mjs";
import * as scene from "./scene.mjs";

let browser;
before(async () => { browser = await launch(); });
afterEach(closePages);
after(() => browser.close());

const hand = scene.makeHand();
hand.confidence = Object.fromEntries(scene.landmarks.map((name) => [name, 1]));
const depth = scene.depthOf([hand]);
const header = (frame, more = {}) => ({ ...scene.makeHeader({ frame, hands: [hand] }), ...more });

async function openShown(options = {}) {
  const open = await OpenPage.open(browser, options);
  await open.show(header(0), depth);
  return open;
}

const frameOf = (open) => open.page.evaluate(() => globalThis.knuckle.frame());
const seenFrom = (open) => open.page.evaluate(() => globalThis.knuckle.seenFrom());

for (const [way, act] of Object.entries({
  buttons: { pause: (page) => page.click("#pause"), step: (page) => page.click("#step"), back: (page) => page.click("#back") },
  keys: { pause: (page) => page.keyboard.press(" "), step: (page) => page.keyboard.press("."), back: (page) => page.keyboard.press(",") },
})) {
  test(`pause, step and back by ${way}`, async () => {
    const open = await openShown();
    const { page } = open;
    assert.ok(await page.locator("#step").isDisabled() && await page.locator("#back").isDisabled());
    await open.show(header(1), depth);
    await open.show(header(2), depth);
    await act.pause(page);
    assert.equal(await page.getAttribute("#pause", "aria-pressed"), "true");
    open.send(header(3), depth);
    await page.waitForFunction(() => globalThis.knuckle.counts().received === 4);
    await open.drawn();
    assert.equal(await frameOf(open), 2, "a picture that is paused stays");
    await act.back(page);
    await open.shown(1);
    await act.back(page);
    await open.shown(0);
    assert.ok(await page.locator("#back").isDisabled(), "nothing before the first");
    await act.step(page);
    await open.shown(1);
    await act.step(page);
    await open.shown(2);
    await act.step(page);  // nothing later is remembered: the next one that comes
    await open.show(header(7), depth);
    open.send(header(8), depth);
    await page.waitForFunction(() => globalThis.knuckle.counts().received === 6);
    await open.drawn();
    assert.equal(await frameOf(open), 7, "one step is one frame");
    await open.saysOfFrames(header(8), depth, "#connection-text", /^Paused$/);
    assert.equal(await frameOf(open), 7);
    await act.pause(page);
    await open.show(header(9), depth);
    assert.equal(await page.getAttribute("#pause", "aria-pressed"), "false");
  });
}

test("what is shown is turned on and off, by pointer and by key", async () => {
  const open = await openShown();
  const { page } = open;
  const isSkeletonIn = async (view) => findColour(await open.picture(view), right, 30).count > 60;
  for (const [id, key, check] of [
    ["#show-skeleton", "k", async () => await isSkeletonIn("#image") && await isSkeletonIn("#cloud")],
    ["#show-cloud", "p", async () => {
      const picture = await open.picture("#cloud");
      return findColour(picture, screen, 4).count < 0.8 * picture.width * picture.height;
    }],
  ]) {
    for (const toggle of [() => page.click(id), () => page.keyboard.press(key)]) {
      assert.ok(await check(), id);
      await toggle();
      assert.ok(!(await page.isChecked(id)));
      assert.ok(!(await check()), `${id} is off`);
      await toggle();
    }
  }
  const withSurface = await open.picture("#cloud");
  await page.keyboard.press("f");
  assert.ok(!(await page.isChecked("#show-surface")));
  assert.notDeepEqual((await open.picture("#cloud")).pixels, withSurface.pixels);
});

test("the view in space obeys buttons, keys, pointer and wheel", async () => {
  const open = await openShown();
  const { page } = open;
  const offset = async () => { const { position, target } = await seenFrom(open); return position.map((value, i) => value - target[i]); };
  const close = (a, b, most = 1) => a.every((value, i) => Math.abs(value - b[i]) < most);
  for (const [button, key, isRight] of [
    ["Front", "1", ([x, y, z]) => Math.abs(x) < 1 && Math.abs(y) < 1 && z < 0],
    ["Side", "2", ([x, , z]) => x > 4 * Math.abs(z)],
    ["Top", "3", ([, y, z]) => y < -4 * Math.abs(z)],
    ["Reset", "0", ([x, y, z]) => x < -50 && y < -50 && z < 0],
  ]) {
    await page.getByRole("button", { name: button, exact: true }).click();
    const byButton = await offset();
    assert.ok(isRight(byButton), `${button}: ${byButton}`);
    await page.keyboard.press(button === "Front" ? "2" : "1");
    await page.keyboard.press(key);
    assert.ok(close(await offset(), byButton), `key ${key}`);
  }
  await page.keyboard.press("1");
  const far = Math.hypot(...await offset());
  await page.click("#zoom-in");
  const near = Math.hypot(...await offset());
  assert.ok(near < 0.9 * far);
  await page.click("#zoom-out");
  assert.ok(Math.abs(Math.hypot(...await offset()) - far) < 1);
  const box = await page.locator("#cloud").boundingBox();
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  await page.mouse.move(x, y);
  await page.mouse.wheel(0, -240);
  await open.drawn();
  assert.ok(Math.hypot(...await offset()) < far - 10, "the wheel zooms");
  await page.keyboard.press("1");
  await page.mouse.down();
  await page.mouse.move(x + 80, y + 40, { steps: 4 });
  await page.mouse.up();
  const turned = await offset();
  assert.ok(turned[0] < -30 && turned[1] < -10, `what is dragged to the right is seen from the left: ${turned}`);
  const before = (await seenFrom(open)).target;
  await page.mouse.down({ button: "right" });
  await page.mouse.move(x + 140, y + 40, { steps: 4 });
  await page.mouse.up({ button: "right" });
  assert.ok(!close((await seenFrom(open)).target, before, 5), "the right button moves");
  const moved = await seenFrom(open);
  await open.show(header(1), depth);
  assert.deepEqual(await seenFrom(open), moved, "frames that come leave the view alone");
});

test("the screenshot is a PNG of both views with the skeleton", async () => {
  const open = await openShown();
  const { page } = open;
  for (const act of [() => page.click("#screenshot"), () => page.keyboard.press("s")]) {
    const [download] = await Promise.all([page.waitForEvent("download"), act()]);
    assert.equal(download.suggestedFilename(), "knuckle-000000.png");
    const picture = decodePng(await readFile(await download.path()));
    const [image, cloud] = await page.evaluate(() => ["image", "cloud"].map((id) => {
      const canvas = document.getElementById(id);
      return [canvas.width, canvas.height];
    }));
    assert.equal(picture.width, image[0] + 8 + cloud[0]);
    const down = (height) => (Math.max(image[1], cloud[1]) - height) / 2;
    const from = await seenFrom(open);
    for (const name of scene.landmarks) {
      const [u, v] = imageAt(hand.landmarks_px[name], scene.camera, ...image);
      assert.ok(isLike(colourAt(picture, u, v + down(image[1])), right, 30), `${name} in the image`);
      const [x, y] = seenAt(hand.landmarks_mm[name], from, ...cloud);
      assert.ok(isLike(colourAt(picture, image[0] + 8 + x, y + down(cloud[1])), right, 40), `${name} in space`);
    }
  }
});

test("recording is started and stopped, and its state and faults are said", async () => {
  const open = await openShown();
  const { page, server } = open;
  await page.click("#record");
  await open.says("#recording-text", /^hand\.h5: 0 frames$/);
  assert.equal(await page.getAttribute("#record", "aria-pressed"), "true");
  await open.show(header(1, { recording: { file: "hand.h5", frames: 41, dropped: 2, fault: "" } }), depth);
  await open.says("#recording-text", /^hand\.h5: 41 frames, 2 dropped because the disk is too slow$/);
  await page.keyboard.press("r");
  await open.says("#recording-text", /^off/);
  assert.deepEqual(server.posted, [{ on: true }, { on: false }]);
  server.recordingFault = "hand.h5: cannot be written; is the disk full?";
  await page.click("#record");
  await open.says("#notices", /The recording could not be started: hand\.h5: cannot be written; is the disk full\?$/);
  assert.equal(await page.getAttribute("#record", "aria-pressed"), "false");
  server.recordingFault = null;
  await page.click("#record");
  await open.says("#recording-text", /^hand\.h5/);
  await open.saysNo("#notices", /could not be started/);
  await open.show(header(2, { recording: { file: null, frames: 50, dropped: 0, fault: "the disk is full" } }), depth);
  await open.says("#notices", /The recording has ended: the disk is full\.$/);
});

test("where the server cannot record, the button says so", async () => {
  const open = await openShown({ info: { ...scene.info, can_record: false } });
  assert.ok(await open.page.locator("#record").isDisabled());
  await open.says("#recording-text", /not possible here/);
  await open.page.keyboard.press("r");
  assert.deepEqual(open.server.posted, []);
});

test("the range of colours is automatic or as set; an impossible one is refused", async () => {
  const open = await openShown();
  const { page } = open;
  const label = () => page.getAttribute("#scale", "aria-label");
  const automatic = await label();
  await page.keyboard.press("a");
  await page.fill("#range-near", "420");
  await page.fill("#range-far", "700");
  await page.keyboard.press("Enter");
  await open.drawn();
  assert.match(await label(), /from 420 to 700 mm/);
  await page.fill("#range-far", "100");
  await page.keyboard.press("Enter");
  await open.drawn();
  assert.match(await label(), /from 420 to 700 mm/);
  assert.equal(await page.getAttribute("#range-far", "aria-invalid"), "true");
  await page.check("#range-auto");
  await open.drawn();
  assert.equal(await label(), automatic);
});

test("the theme goes round and is remembered", async () => {
  const open = await openShown({ colorScheme: "light" });
  const { page } = open;
  const brightness = () => page.evaluate(() => Number(/\d+/.exec(getComputedStyle(document.body).backgroundColor)[0]));
  assert.ok(await brightness() > 200);
  await page.click("#theme");
  assert.ok(await brightness() > 200, "light");
  await page.keyboard.press("t");
  assert.ok(await brightness() < 60, "dark");
  await page.reload();
  assert.ok(await brightness() < 60, "still dark");
  assert.equal(await open.text("#theme-label"), "Theme: dark");
});

test("the list of keys opens, closes, and can turn them off", async () => {
  const open = await openShown();
  const { page } = open;
  await page.keyboard.press("?");
  assert.ok(await page.locator("#help-dialog").isVisible());
  const listed = await page.locator("#shortcuts kbd").allInnerTexts();
  for (const key of ["Space", ".", ",", "R", "S", "I", "K", "P", "F", "A", "1", "2", "3", "0", "T", "?"]) assert.ok(listed.includes(key), key);
  await page.keyboard.press(" ");  // the button that has the focus
  assert.ok(!(await page.locator("#help-dialog").isVisible()));
  await page.click("#help");
  await page.uncheck("#keys-on");
  await page.keyboard.press("Escape");
  await page.keyboard.press("k");
  assert.ok(await page.isChecked("#show-skeleton"), "keys are off");
  await page.keyboard.press("?");
  await page.check("#keys-on");
  await page.keyboard.press("Escape");
  await page.keyboard.press("k");
  assert.ok(!(await page.isChecked("#show-skeleton")));
});

test("depth and infrared by key", async () => {
  const open = await openShown();
  await open.page.keyboard.press("i");
  assert.ok(await open.page.isChecked("[value=depth]"), "there is no infrared");
  open.send({ ...header(1), infrared: true }, depth, scene.makeInfrared(depth));
  await open.shown(1);
  await open.page.keyboard.press("i");
  assert.ok(await open.page.isChecked("[value=infrared]"));
  assert.match(await open.page.getAttribute("#image", "aria-label"), /^Infrared/);
});

test("every control is reached with the Tab key and shows that it has the focus", async () => {
  const open = await openShown();
  const { page } = open;
  const reached = new Set();
  for (let i = 0; i < 40; ++i) {
    await page.keyboard.press("Tab");
    const [name, outlined] = await page.evaluate(() => {
      const active = document.activeElement;
      const shown = active.closest(".choice") ? active.nextElementSibling : active;
      return [active.id || active.dataset.look || active.value || active.tagName, getComputedStyle(shown).outlineStyle !== "none"];
    });
    if (name === "BODY") break;
    reached.add(name);
    assert.ok(outlined, `${name} shows no focus`);
  }
  for (const name of ["pause", "record", "screenshot", "theme", "help", "depth", "show-skeleton", "range-auto", "show-cloud", "show-surface", "cloud",
                      "front", "side", "top", "reset", "zoom-in", "zoom-out"]) assert.ok(reached.has(name), `${name} is not reached`);
});
