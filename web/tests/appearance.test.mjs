// SPDX-License-Identifier: Apache-2.0
// Wide and narrow, light and dark: nothing overlaps the edge, axe-core finds nothing serious, nothing is loaded from elsewhere.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { after, afterEach, before, test } from "node:test";
import { closePages, launch, OpenPage } from "./browser.mjs";
import { encodeFrame } from "./mock_server.mjs";
import * as scene from "./scene.mjs";

const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
let browser;
before(async () => { browser = await launch(); });
afterEach(closePages);
after(() => browser.close());

const hands = [scene.makeHand({ wrist: [70, 75, 450] }), scene.makeHand({ id: 2, side: "left", wrist: [-70, 60, 500] })];
const depth = scene.depthOf(hands);

/** What axe-core finds that hinders people seriously. */
async function seriousFaults(page) {
  await page.evaluate(axe);  // not as a script of the page, which its own rules forbid
  const { violations } = await page.evaluate(() => globalThis.axe.run(document, { resultTypes: ["violations"] }));
  return violations.filter(({ impact }) => ["serious", "critical"].includes(impact))
    .map(({ id, nodes }) => `${id}: ${nodes.map((node) => node.html).join(" ")}`);
}

for (const [width, height] of [[1440, 900], [1024, 700], [360, 740]]) {
  for (const colorScheme of ["light", "dark"]) {
    test(`${width} px wide, ${colorScheme}`, async () => {
      const open = await OpenPage.open(browser, { viewport: { width, height }, colorScheme, reducedMotion: "reduce" });
      const { page } = open;
      await open.show(scene.makeHeader({ hands, status: "unsure" }), depth);
      assert.deepEqual(await seriousFaults(page), []);
      const overflow = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
      assert.ok(overflow <= 0, `${overflow} px stick out to the right`);
      const lost = await page.evaluate(() => [...document.querySelectorAll("button, input:not([type=radio]), canvas")]
        .filter((one) => !one.closest("dialog") && one.getBoundingClientRect().width > 0)
        .filter((one) => { const box = one.getBoundingClientRect(); return box.left < 0 || box.right > innerWidth + 0.5; }).map((one) => one.id));
      assert.deepEqual(lost, []);
      await page.keyboard.press("?");
      assert.deepEqual(await seriousFaults(page), []);
      await page.keyboard.press("Escape");
      open.server.send(Buffer.alloc(1));
      await open.says("#notices", /could not be read/);
      assert.deepEqual(await seriousFaults(page), []);
      assert.deepEqual(open.elsewhere, []);
      assert.deepEqual(open.faults, []);
    });
  }
}

test("the two views do not jump when hands come and go, when numbers grow, nor when something is said", async () => {
  const open = await OpenPage.open(browser);
  const boxes = () => Promise.all(["#image", "#cloud"].map((id) => open.page.locator(id).boundingBox()));
  await open.show(scene.makeHeader({}), depth);
  const before = await boxes();
  await open.show(scene.makeHeader({ frame: 1, hands }), depth);
  assert.deepEqual(await boxes(), before);
  for (let frame = 2; frame < 10; ++frame) await open.show(scene.makeHeader({ frame, hands, latency_ms: 123456.7 }), depth);
  await open.says("#latency-high", /12\d{4}\.\d ms/);
  await open.drawn();
  assert.deepEqual(await boxes(), before);
  open.server.send(Buffer.alloc(1));
  await open.says("#notices", /could not be read/);
  await open.drawn();
  assert.deepEqual(await boxes(), before);
});

test("a screen reader is told of hands, but not thirty times a second", async () => {
  const open = await OpenPage.open(browser);
  await open.page.evaluate(() => {
    globalThis.told = 0;
    new MutationObserver((changes) => { globalThis.told += changes.length; })
      .observe(document.getElementById("announcer"), { childList: true, characterData: true, subtree: true });
  });
  for (let frame = 0; frame < 40; ++frame) {
    open.send(scene.makeHeader({ frame, hands: frame % 2 ? hands : [] , status: frame % 2 ? "" : "no hand" }), depth);
    await open.page.waitForTimeout(30);
  }
  await open.shown(39);
  assert.ok(await open.page.evaluate(() => globalThis.told) <= 2);
  await open.says("#announcer", /^2 hands/);
});

test("640 x 480 at 30 frames per second: how many are shown (a number, no verdict)", async (t) => {
  const c = { ...scene.camera, width: 640, height: 480, fx: 560, fy: 568, cx: 313.5, cy: 245 };
  const frames = [0, 1, 2, 3].map((i) => {
    const moved = [scene.makeHand({ wrist: [40 + 12 * i, 75, 450], camera: c })];
    return [moved, scene.depthOf(moved, c)];
  });
  const open = await OpenPage.open(browser);
  let frame = 0;
  const timer = setInterval(() => {
    if (open.server.backlog() > 2e6) return;  // as the server does: who is slow gets fewer
    const [moved, image] = frames[frame % frames.length];
    open.server.send(encodeFrame(scene.makeHeader({ frame: frame++, hands: moved, c }), image));
  }, 1000 / 30);
  t.after(() => clearInterval(timer));
  const count = () => open.page.evaluate(() => [performance.now(), globalThis.knuckle.counts().shown]);
  await open.page.waitForTimeout(1500);
  const [begin, shownBefore] = await count();
  await open.page.waitForTimeout(3000);
  const [end, shownAfter] = await count();
  await open.says("#pictures", /^\d+\.\d \/s$/);
  await open.says("#rate", /^\d+\.\d \/s$/);
  await open.says("#latency", /^7\.5 ms$/);
  const rate = (1000 * (shownAfter - shownBefore)) / (end - begin);
  t.diagnostic(`${rate.toFixed(1)} pictures per second, WebGL drawn in software`);
  assert.ok(shownAfter > shownBefore, "pictures go on");
  assert.deepEqual(open.faults, []);
});
