// SPDX-License-Identifier: Apache-2.0
// Both views show what the record says, where it says it: pixels are read back.
import assert from "node:assert/strict";
import { after, afterEach, before, test } from "node:test";
import { closePages, imageAt, launch, left, OpenPage, right, screen, seenAt } from "./browser.mjs";
import { colourAt, findColour, isLike, middleOf } from "./png.mjs";
import * as scene from "./scene.mjs";

let browser;
before(async () => { browser = await launch(); });
afterEach(closePages);
after(() => browser.close());

const sure = (hand) => ({ ...hand, confidence: Object.fromEntries(Object.keys(hand.landmarks_px).map((name) => [name, 1])) });

/** How many of the points lie on a colour. */
function hits(picture, points, colour, most = 30) {
  const near = [[0, 0], [-1, 0], [1, 0], [0, -1], [0, 1]];  // a neighbour's outline may cover the very middle
  return points.filter(([column, row]) => column >= 1 && row >= 1 && column < picture.width - 1 && row < picture.height - 1 &&
    near.some(([right, down]) => isLike(colourAt(picture, column + right, row + down), colour, most))).length;
}

async function openWith(hand, c = scene.camera, options = {}) {
  const open = await OpenPage.open(browser, options);
  await open.show(scene.makeHeader({ hands: [hand], c }), scene.depthOf([hand], c));
  return open;
}

test("the image shows each landmark where the record says", async () => {
  const hand = sure(scene.makeHand());
  const open = await openWith(hand);
  const picture = await open.picture("#image");
  const points = Object.values(hand.landmarks_px);
  const at = (move) => points.map((point) => imageAt(move(point), scene.camera, picture.width, picture.height));
  assert.equal(hits(picture, at((p) => p), right), points.length);
  const { width, height } = scene.camera;
  for (const [name, move] of Object.entries({
    mirrored: ([u, v]) => [width - 1 - u, v], upside_down: ([u, v]) => [u, height - 1 - v], transposed: ([u, v]) => [v, u],
  })) assert.ok(hits(picture, at(move), right) < points.length / 3, `a ${name} drawing would pass`);
  assert.deepEqual(open.faults, []);
});

test("the pixel origin moves landmarks by half a pixel", async () => {
  const small = { ...scene.camera, width: 32, height: 24, fx: 28, fy: 28, cx: 15.5, cy: 11.5 };
  for (const pixel_origin of ["centre", "corner"]) {
    const c = { ...small, pixel_origin };
    const hand = { id: 1, side: "right", score: 1, landmarks_mm: { palm: [0, 0, 500] }, landmarks_px: { palm: [9, 6] }, confidence: { palm: 1 } };
    const open = await OpenPage.open(browser);
    await open.show(scene.makeHeader({ hands: [hand], c, surface: [[]] }), new Uint16Array(32 * 24));
    const picture = await open.picture("#image");
    // The name below the disc has its colour too: only the disc's surroundings are looked at.
    const [column, row] = imageAt([9, 6], c, picture.width, picture.height);
    const around = { ...picture, height: Math.floor(row + 5) };  // half a pixel is 7 here
    const found = findColour(around, right);
    assert.ok(found.count > 8, `${found.count} pixels`);
    assert.ok(Math.abs(found.column - column) < 2 && Math.abs(found.row - row) < 2, `${pixel_origin}: ${found.column} ${found.row}, not ${column} ${row}`);
    }
});

test("the points' view shows each landmark where its place in space is seen, before and after turning", async () => {
  const hand = sure(scene.makeHand());
  const open = await openWith(hand);
  const points = Object.values(hand.landmarks_mm);
  const check = async (what) => {
    const picture = await open.picture("#cloud");
    const from = await open.page.evaluate(() => globalThis.knuckle.seenFrom());
    const places = points.map((point) => seenAt(point, from, picture.width, picture.height));
    assert.equal(hits(picture, places, right, 40), points.length, what);
    return from;
  };
  await check("as it begins");
  await open.page.keyboard.press("1");
  const front = await check("from the front");
  assert.ok(Math.abs(front.position[0] - front.target[0]) < 1e-6 && Math.abs(front.position[1] - front.target[1]) < 1e-6);
  assert.ok(front.position[2] < front.target[2], "it looks forward");
  await open.page.locator("#cloud").focus();
  for (let i = 0; i < 6; ++i) await open.page.keyboard.press("ArrowLeft");
  for (let i = 0; i < 3; ++i) await open.page.keyboard.press("ArrowUp");
  const turned = await check("after turning");
  const offset = turned.position.map((value, i) => value - turned.target[i]);
  const distance = Math.hypot(...offset);
  const turn_deg = (Math.atan2(offset[0], -offset[2]) * 180) / Math.PI;
  const rise_deg = (Math.asin(-offset[1] / distance) * 180) / Math.PI;
  assert.ok(Math.abs(turn_deg + 30) < 0.01, `turned by ${turn_deg}`);
  assert.ok(Math.abs(rise_deg - 15) < 0.01, `risen by ${rise_deg}`);
  await open.page.keyboard.press("+");
  await open.page.keyboard.press("Shift+ArrowRight");
  await check("after zooming and moving");
});

test("a hand that leaves the points' view is aimed at again, unless a person has moved the view", async () => {
  const at = (x) => sure(scene.makeHand({ wrist: [x, 75, 450] }));
  const show = (open, x) => open.show(scene.makeHeader({ hands: [at(x)], c: scene.camera }), scene.depthOf([at(x)], scene.camera));
  const target = (open) => open.page.evaluate(() => globalThis.knuckle.seenFrom().target);
  const open = await openWith(at(-90));
  const [x, y, z] = await target(open);
  await show(open, -60);
  assert.deepEqual(await target(open), [x, y, z], "a small move leaves the view alone");
  await show(open, 160);
  const followed = await target(open);
  assert.ok(Math.abs(followed[0] - (x + 250)) < 1 && Math.abs(followed[1] - y) < 1 && Math.abs(followed[2] - z) < 1, `${followed}`);
  await open.page.keyboard.press("1");
  await show(open, -90);
  assert.ok((await target(open)).every((value, i) => Math.abs(value - followed[i]) < 1e-6), "what a person chose stays");
});

/** OpenCV's rational distortion, forwards. */
function distort([x, y], [k1, k2, p1, p2, k3, k4, k5, k6]) {
  const r2 = x * x + y * y;
  const radial = (1 + r2 * (k1 + r2 * (k2 + r2 * k3))) / (1 + r2 * (k4 + r2 * (k5 + r2 * k6)));
  return [x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x), y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y];
}

const cameras = {
  projective: scene.camera,
  corner: { ...scene.camera, pixel_origin: "corner" },
  upward: { ...scene.camera, fy: -scene.camera.fy },
  orthographic: { ...scene.camera, model: "orthographic", fx: 0.72, fy: 0.7 },
  distorted: { ...scene.camera, distortion: [-0.22, 0.06, 0.004, -0.003, 0.01, 0, 0, 0] },
};

for (const [name, c] of Object.entries(cameras)) {
  test(`points lie where a ${name} camera saw them`, async () => {
    const unit_mm = 0.25;
    const depth = new Uint16Array(c.width * c.height);  // nothing but a patch around each place
    const places = [[-120, -70, 500], [90, -60, 620], [-60, 80, 740], [150, 50, 860], [60, 120, 980]].map(([x, y, z]) => {
      const plane = c.model === "orthographic" ? [x, y] : distort([x / z, y / z], c.distortion ?? [0, 0, 0, 0, 0, 0, 0, 0]);
      const shift = c.pixel_origin === "corner" ? 0.5 : 0;
      const exact = [c.fx * plane[0] + c.cx - shift, c.fy * plane[1] + c.cy - shift];
      const [u, v] = exact.map(Math.round);
      for (let row = v - 3; row <= v + 3; ++row) depth.fill(z / unit_mm, row * c.width + u - 3, row * c.width + u + 4);
      const scale = c.model === "orthographic" ? 1 : z;
      return [x + ((u - exact[0]) / c.fx) * scale, y + ((v - exact[1]) / c.fy) * scale, z];  // the middle of the patch
    });
    const open = await OpenPage.open(browser);
    await open.page.uncheck("#range-auto");
    await open.page.fill("#range-near", "400");
    await open.page.fill("#range-far", "1100");
    await open.page.locator("#range-far").blur();
    await open.show({ ...scene.makeHeader({ c }), depth_unit_mm: unit_mm }, depth);
    await open.page.keyboard.press("1");
    await open.page.locator("#cloud").focus();
    for (let i = 0; i < 4; ++i) await open.page.keyboard.press("ArrowRight");
    for (let i = 0; i < 2; ++i) await open.page.keyboard.press("ArrowUp");
    const picture = await open.picture("#cloud");
    const from = await open.page.evaluate(() => globalThis.knuckle.seenFrom());
    const points = places.map((place) => seenAt(place, from, picture.width, picture.height));
    const isPoint = ([column, row]) => !isLike(colourAt(picture, column, row), screen, 12);
    assert.equal(points.filter(isPoint).length, places.length);
    assert.equal(new Set(points.map(([column, row]) => String(colourAt(picture, column, row)))).size, places.length, "each distance has its colour");
    const covered = picture.width * picture.height - findColour(picture, screen, 12).count;
    assert.ok(covered < 0.06 * picture.width * picture.height, `the rest stays empty: ${covered} pixels are not`);
    // The middle of the patch is where the point is: as much of it to all sides.
    const [column, row] = points[4];
    const around = crop(picture, column - 14, row - 14, 29, 29);
    const all = middleOf(around, (colour) => !isLike(colour, screen, 12));  // the last points of a patch are shaded otherwise
    const [off_right, off_down] = [all.column - 14 - (column % 1), all.row - 14 - (row % 1)];
    assert.ok(Math.hypot(off_right, off_down) < 0.6, `${off_right} ${off_down}: half a pixel of the camera either way is 0.94 here`);
    assert.deepEqual(open.faults, []);
    });
}

function crop(picture, column, row, width, height) {
  const pixels = new Uint8Array(4 * width * height);
  for (let y = 0; y < height; ++y) {
    for (let x = 0; x < width; ++x) pixels.set(colourAt(picture, column + x, row + y), 4 * (y * width + x));
  }
  return { width, height, pixels };
}

/** Mean place of all that is not the screen's colour. */
function emptiness(picture) {
  let [count, columns, rows] = [0, 0, 0];
  for (let row = 0; row < picture.height; ++row) {
    for (let column = 0; column < picture.width; ++column) {
      if (isLike(colourAt(picture, column, row), screen, 12)) continue;
      ++count;
      columns += column + 0.5;
      rows += row + 0.5;
    }
  }
  return { count, column: columns / count, row: rows / count };
}

test("the fitted surface is drawn around the bones, as wide as its radii", async () => {
  const hand = sure(scene.makeHand());
  const capsule = [-40, 10, 500, 30, 60, -20, 500, 12];
  const open = await OpenPage.open(browser);
  await open.show(scene.makeHeader({ hands: [hand], surface: [[capsule]] }), scene.depthOf([hand]));
  for (const id of ["#show-cloud", "#show-skeleton"]) await open.page.uncheck(id);
  await open.page.keyboard.press("1");
  const picture = await open.picture("#cloud");
  const from = await open.page.evaluate(() => globalThis.knuckle.seenFrom());
  const isFlesh = (x, y) => {
    const [column, row] = seenAt([x, y, 500], from, picture.width, picture.height);
    return !isLike(colourAt(picture, column, row), screen, 12);
  };
  const along = [100 / Math.hypot(100, 30), -30 / Math.hypot(100, 30)];  // from the thick end to the thin one
  const across = [-along[1], along[0]];
  const flesh = (t, off) => isFlesh(-40 + t * 100 + off * across[0], 10 - t * 30 + off * across[1]);
  for (const [t, radius] of [[0, 30], [0.5, 21], [1, 12]]) {
    for (const side of [-1, 1]) {
      assert.ok(flesh(t, side * (radius - 3)), `inside at ${t}`);
      assert.ok(!flesh(t, side * (radius + 5)), `outside at ${t}`);
    }
  }
  assert.ok(isFlesh(-40 - 26 * along[0], 10 - 26 * along[1]) && !isFlesh(-40 - 35 * along[0], 10 - 35 * along[1]), "round at its end");
  await open.page.uncheck("#show-surface");
  const without = await open.picture("#cloud");
  assert.ok(findColour(without, screen, 4).count > 0.98 * without.width * without.height);  // but for the border
});

test("hands are told apart by colour, side and number", async () => {
  const hands = [sure(scene.makeHand({ id: 4, wrist: [70, 75, 450] })), sure(scene.makeHand({ id: 9, side: "left", wrist: [-70, 60, 500], score: 0.4 }))];
  const open = await OpenPage.open(browser);
  await open.show(scene.makeHeader({ hands }), scene.depthOf(hands));
  const picture = await open.picture("#image");
  for (const [hand, colour] of [[hands[0], right], [hands[1], left]]) {
    const points = Object.values(hand.landmarks_px).map((point) => imageAt(point, scene.camera, picture.width, picture.height));
    assert.equal(hits(picture, points, colour), points.length);
  }
  const said = await open.page.locator("#hands li").allInnerTexts();
  assert.match(said[0], /Right 4[\s\S]*score 82 %[\s\S]*confidence 100 %/);
  assert.match(said[1], /Left 9[\s\S]*score 40 %/);
  const swatches = await open.page.locator("#hands .swatch").evaluateAll((all) => all.map((one) => getComputedStyle(one).backgroundColor));
  assert.deepEqual(swatches, [`rgb(${right.join(", ")})`, `rgb(${left.join(", ")})`]);
  await open.says("#announcer", /^2 hands: right, left$/);
  await open.show(scene.makeHeader({ frame: 1, status: "no hand: the nearest thing is a table" }), scene.depthOf([]));
  assert.equal(await open.text("#no-hands"), "no hand: the nearest thing is a table");
  assert.equal(await open.text("#status"), "no hand: the nearest thing is a table");
  assert.equal(await open.page.locator("#hands li:visible").count(), 0);
});

test("an unsure landmark is smaller and fainter, a missing one is not drawn", async () => {
  const landmarks_px = { wrist: [60, 120], palm: [160, 120], thumb_tip: [260, 120], index_tip: null };
  const landmarks_mm = { wrist: [-80, 0, 500], palm: [0, 0, 500], thumb_tip: [80, 0, 500], index_tip: null };
  const hand = { id: 1, side: "right", score: null, landmarks_mm, landmarks_px, confidence: { wrist: 1, palm: 0.1, thumb_tip: null } };
  const open = await OpenPage.open(browser);
  await open.show(scene.makeHeader({ hands: [hand], surface: [[]] }), new Uint16Array(scene.camera.width * scene.camera.height));
  const picture = await open.picture("#image");
  const around = (point) => {
    const [column, row] = imageAt(point, scene.camera, picture.width, picture.height);
    return crop(picture, column - 12, row - 12, 25, 18);
  };
  const [sureOne, unsure, unsaid] = ["wrist", "palm", "thumb_tip"].map((name) => around(landmarks_px[name]));
  const redness = (view) => colourAt(view, 12, 12)[0];
  assert.ok(redness(sureOne) > 240 && redness(unsure) < 140 && redness(unsure) > 50, `${redness(sureOne)} ${redness(unsure)}`);
  const count = (view) => emptiness(view).count;
  assert.ok(count(unsure) < 0.75 * count(sureOne));
  assert.ok(redness(unsaid) > 240, "nothing is said of it, so nothing is hidden");
  assert.deepEqual(open.faults, []);
});

test("depth is coloured from near to far, and the legend says what colours stand for", async () => {
  const c = { ...scene.camera, width: 64, height: 48 };
  const depth = new Uint16Array(64 * 48).map((_, i) => (i % 64 < 8 ? 0 : 500 + 10 * ((i % 64) - 8)));
  const open = await OpenPage.open(browser);
  await open.page.uncheck("#range-auto");
  await open.page.fill("#range-near", "500");
  await open.page.fill("#range-far", "1050");
  await open.page.locator("#range-far").blur();
  await open.show(scene.makeHeader({ c }), depth);
  const [picture, bar] = [await open.picture("#image"), await open.picture("#scale-bar")];
  for (const column of [10, 22, 36, 50, 62]) {
    const [x, y] = imageAt([column, 20], c, picture.width, picture.height);
    const share = (10 * (column - 8)) / 550;
    const legend = colourAt(bar, Math.min(bar.width - 1, share * bar.width), bar.height / 2);
    assert.ok(isLike(colourAt(picture, x, y), legend, 10), `column ${column}`);
  }
  assert.ok(isLike(colourAt(picture, ...imageAt([3, 20], c, picture.width, picture.height)), [0x16, 0x1a, 0x20], 3), "not measured");
  assert.match(await open.page.locator("#scale").getAttribute("aria-label"), /from 500 to 1050 mm/);
  assert.deepEqual(await open.page.locator("#ticks span").allInnerTexts(), ["500", "600", "700", "800", "900", "1000"]);
  const box = await open.page.locator("#image").boundingBox();
  const [x, y] = imageAt([22, 20], c, box.width, box.height);
  await open.page.locator("#image").hover({ position: { x, y } });
  assert.equal(await open.text("#probe"), "22, 20: 640 mm");
});

test("frames may change their size, camera and unit", async () => {
  const hand = sure(scene.makeHand());
  const open = await openWith(hand);
  const small = { ...scene.camera, width: 160, height: 120, fx: 140, fy: 142, cx: 78, cy: 60.9 };
  const smaller = sure(scene.makeHand({ wrist: [-40, 60, 480], camera: small }));
  await open.show(scene.makeHeader({ frame: 1, hands: [smaller], c: small }), scene.depthOf([smaller], small));
  const picture = await open.picture("#image");
  const points = Object.values(smaller.landmarks_px).map((point) => imageAt(point, small, picture.width, picture.height));
  assert.equal(hits(picture, points, right), points.length);
  const cloud = await open.picture("#cloud");
  const from = await open.page.evaluate(() => globalThis.knuckle.seenFrom());
  const places = Object.values(smaller.landmarks_mm).map((point) => seenAt(point, from, cloud.width, cloud.height));
  assert.equal(hits(cloud, places, right, 40), places.length);
  assert.deepEqual(open.faults, []);
});

test("infrared is shown where there is one", async () => {
  const hand = sure(scene.makeHand());
  const depth = scene.depthOf([hand]);
  const open = await openWith(hand);
  assert.ok(await open.page.locator("[value=infrared]").isDisabled());
  await open.show(scene.makeHeader({ frame: 1, hands: [hand], infrared: true }), depth, scene.makeInfrared(depth));
  await open.page.locator("#image-kind label", { hasText: "Infrared" }).click();
  const picture = await open.picture("#image");
  const [r, g, b] = colourAt(picture, ...imageAt([300, 200], scene.camera, picture.width, picture.height));
  assert.ok(r === g && g === b && r > 30, `grey, not ${r} ${g} ${b}`);
  const points = Object.values(hand.landmarks_px).map((point) => imageAt(point, scene.camera, picture.width, picture.height));
  assert.equal(hits(picture, points, right), points.length);
  await open.show(scene.makeHeader({ frame: 2, hands: [hand] }), depth);
  assert.ok(await open.page.locator("[value=depth]").isChecked(), "back to depth where the infrared ends");
});
