// SPDX-License-Identifier: Apache-2.0
// What goes wrong between server and page is said in plain words, and the page goes on.
import assert from "node:assert/strict";
import { after, afterEach, before, test } from "node:test";
import { closePages, launch, OpenPage } from "./browser.mjs";
import { encodeFrame } from "./mock_server.mjs";
import * as scene from "./scene.mjs";

let browser;
before(async () => { browser = await launch(); });
afterEach(closePages);
after(() => browser.close());

const hand = scene.makeHand();
const depth = scene.depthOf([hand]);
const header = (frame) => scene.makeHeader({ frame, hands: [hand] });

test("a token of the page's address goes with all requests", async () => {
  const open = await OpenPage.open(browser, { query: "?token=a%2Bb" });
  await open.show(header(0), depth);
  await open.page.click("#record");
  await open.says("#recording-text", /hand\.h5/);
  const asked = open.server.requests.filter((request) => request.includes("/api/"));
  assert.equal(asked.length, 3);
  for (const request of asked) assert.match(request, /\?token=a%2Bb$/);
});

test("a lost connection is said, and found again", async () => {
  const open = await OpenPage.open(browser);
  await open.saysOfFrames(header(0), depth, "#connection-text", /^Live$/);
  await open.server.stop();
  await open.says("#notices", /Connection lost: .*tries again/);
  await open.says("#connection-text", /^No connection$/);
  await open.server.start();
  await open.page.keyboard.press("c");
  await open.server.viewer();
  await open.show(header(1), depth);
  await open.saysNo("#notices", /Connection lost/);
});

test("a page that is opened too early waits for its server", async () => {
  const open = await OpenPage.open(browser, { waits: false, prepare: (server) => { server.refusesInfo = 500; } });
  await open.says("#notices", /Connection lost: the server answered with status 500\. The page tries again/);
  open.server.refusesInfo = 403;
  await open.says("#notices", /the server refused this page; open it with the address that knuckle printed, with its token/);
  open.server.refusesInfo = 0;
  await open.server.viewer();
  await open.show(header(0), depth);
});

test("an answer that is no description is refused in words", async () => {
  const open = await OpenPage.open(browser, { waits: false, info: { ...scene.info, bones: [["wrist", 7]] } });
  await open.says("#notices", /the server's answer cannot be read: bones is not text/);
});

test("the page says when no frames come", async () => {
  const open = await OpenPage.open(browser);
  await open.says("#notices", /Connected, but no frame has come for \d+ s\. Is the camera running\?/);
  await open.show(header(0), depth);
  await open.saysNo("#notices", /no frame has come/);
  await open.says("#notices", /No frames for \d+ s\. Has the recording ended, or is the camera unplugged\?/);
  assert.equal(await open.text("#connection-text"), "No frames");
});

const broken = (change) => { const copy = structuredClone(header(5)); change(copy); return encodeFrame(copy, depth); };
const messages = {
  "nothing": [Buffer.alloc(0), /it has 0 bytes/],
  "a header longer than the message": [Buffer.from([255, 255, 255, 127, 1, 2]), /longer than the message/],
  "no JSON": [Buffer.from([2, 0, 0, 0, 0x7b, 0x7b]), /its header is not JSON/],
  "bytes that are no text": [Buffer.from([2, 0, 0, 0, 0xff, 0xfe]), /its header is not JSON/],
  "a list as its header": [Buffer.from([2, 0, 0, 0, 0x5b, 0x5d]), /the header is not an object/],
  "too few pixels": [encodeFrame(header(5), depth.subarray(1)), /holds 153598 bytes of pixels; 320 x 240 needs 153600/],
  "too many pixels": [encodeFrame(header(5), depth, depth), /holds 307200 bytes of pixels/],
  "infrared that is missing": [broken((h) => { h.infrared = true; }), /320 x 240 with infrared needs 307200/],
  "a size that is none": [broken((h) => { h.width = -1; }), /width is -1; expected 1 to 16384/],
  "a size beyond all memory": [broken((h) => { h.width = 1e9; h.height = 1e9; }), /width is 1000000000/],
  "no unit": [broken((h) => { h.depth_unit_mm = 0; }), /depth_unit_mm is 0/],
  "no camera": [broken((h) => { delete h.camera; }), /camera is not an object/],
  "a camera without focal length": [broken((h) => { h.camera.fx = 0; }), /camera\.fx or camera\.fy is 0/],
  "a landmark of text": [broken((h) => { h.record.hands[0].landmarks_px.wrist = ["a", "b"]; }), /landmarks_px\.wrist is not a number/],
  "a landmark in the plane": [broken((h) => { h.record.hands[0].landmarks_mm.wrist = [1, 2]; }), /landmarks_mm\.wrist has not 3 coordinates/],
  "a side that is none": [broken((h) => { h.record.hands[0].side = "upper"; }), /neither right nor left/],
  "hands without end": [broken((h) => { h.record.hands = Array(65).fill(h.record.hands[0]); }), /record\.hands has 65 entries/],
  "a piece of surface with seven numbers": [broken((h) => { h.surface = [[[1, 2, 3, 4, 5, 6, 7]]]; }), /a capsule of surface has not 8 numbers/],
};

test("malformed messages are ignored and said, and the next frame is shown", async () => {
  const open = await OpenPage.open(browser);
  await open.show(header(0), depth);
  for (const [name, [bytes, said]] of Object.entries(messages)) {
    open.server.send(bytes);
    await open.says("#notices", said).catch((error) => assert.fail(`${name}: ${error.message}`));
  }
  open.server.sendText("{}");
  await open.says("#notices", /it is text, where bytes were expected/);
  const count = Object.keys(messages).length + 1;
  await open.says("#notices", new RegExp(`${count} messages from the server could not be read and were ignored`));
  await open.show(header(6), depth);
  assert.deepEqual(await open.page.evaluate(() => globalThis.knuckle.counts()), { received: 2, shown: 2, malformed: count });
  assert.deepEqual(open.faults, []);
});

test("text from the server is text, never markup", async () => {
  const evil = `<img src="/evil.png"><b id="evil">`;
  const open = await OpenPage.open(browser, { info: { ...scene.info, source: evil, pipeline: evil } });
  const said = scene.makeHeader({ status: evil });
  said.record.name = evil;
  await open.show(said, depth);
  assert.equal(await open.page.locator("#evil").count(), 0);
  assert.equal(await open.text("#source"), evil);
  assert.equal(await open.text("#status"), evil);
  assert.ok(!open.server.requests.some((request) => request.includes("evil.png")));
});

test("a frame whose pixels begin at an odd byte is read as well", async () => {
  const open = await OpenPage.open(browser);
  for (const padding of [0, 1]) {
    open.server.send(encodeFrame(header(padding), depth, null, padding));
    await open.shown(padding);
  }
  assert.deepEqual(open.faults, []);
});

test("without WebGL 2 the image is shown, and why there is no more", async () => {
  const plain = await launch(["--disable-gpu", "--disable-3d-apis"]);
  try {
    const open = await OpenPage.open(plain);
    await open.show(header(0), depth);
    assert.match(await open.text("#cloud-missing"), /no WebGL 2/);
    assert.ok(await open.page.locator("#show-cloud").isDisabled());
    assert.match((await open.page.locator("#hands li").allInnerTexts())[0], /Right 1/);
    for (const key of ["1", "0", "p", "k"]) await open.page.keyboard.press(key);
    const [download] = await Promise.all([open.page.waitForEvent("download"), open.page.click("#screenshot")]);
    assert.match(download.suggestedFilename(), /\.png$/);
    assert.deepEqual(open.faults.filter((fault) => !/WebGL/.test(fault)), []);
  } finally {
    await closePages();
    await plain.close();
  }
});
