// SPDX-License-Identifier: Apache-2.0
// Films the page of a running `knuckle live --view`: both views, a picture per frame, while the view in space swings to and fro.
//   node capture.mjs ADDRESS FRAMES OUT.webp
import { writeFile } from "node:fs/promises";
import { launch } from "./browser.mjs";

const [address, frames, out] = [process.argv[2], Number(process.argv[3]), process.argv[4]];
const kSwing_px = 30;
const kWidth = 880;
const kQuality = 0.55;
const kDuration_ms = 80;

const browser = await launch();
const page = await browser.newPage({ viewport: { width: 1280, height: 800 }, colorScheme: "dark" });
await page.goto(address);
await page.waitForFunction(() => globalThis.knuckle.header()?.record.hands.length > 0);
const encoder = await browser.newPage();  // the browser makes the WebP pictures, too
await page.bringToFront();
await page.keyboard.press("0");
await page.waitForTimeout(1500);  // all texts are there, nothing moves any more
const views = await page.evaluate(() => {
  const [a, b] = ["image-panel", "cloud-panel"].map((id) => document.getElementById(id).getBoundingClientRect());
  return { x: a.left - 8, y: a.top - 8, width: b.right - a.left + 16, height: a.height + 16 };
});
const cloud = await page.locator("#cloud").boundingBox();
const [x, y] = [cloud.x + cloud.width / 2, cloud.y + cloud.height / 2];
await page.mouse.move(x, y);
await page.mouse.down();
const pictures = [];
for (let i = 0, before = -1; i < frames; ++i) {
  await page.waitForFunction((last) => globalThis.knuckle.frame() !== last, before);
  before = await page.evaluate(() => globalThis.knuckle.frame());
  await page.mouse.move(x + kSwing_px * Math.sin((2 * Math.PI * i) / frames), y);
  await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
  pictures.push(await encode(await page.screenshot({ clip: views })));
}
await browser.close();
await writeFile(out, animation(pictures));

/** A PNG as a smaller WebP: { width, height, data }, where data is its chunk "VP8 ". */
async function encode(png) {
  const made = await encoder.evaluate(async ([base64, width, quality]) => {
    const image = await createImageBitmap(await (await fetch(`data:image/png;base64,${base64}`)).blob());
    const canvas = document.createElement("canvas");
    canvas.width = width;
    canvas.height = Math.round((image.height * width) / image.width);
    const context = canvas.getContext("2d", { alpha: false });
    context.imageSmoothingQuality = "high";
    context.drawImage(image, 0, 0, canvas.width, canvas.height);
    const [, webp] = canvas.toDataURL("image/webp", quality).split(",");
    return { width: canvas.width, height: canvas.height, webp };
  }, [png.toString("base64"), kWidth, kQuality]);
  const file = Buffer.from(made.webp, "base64");
  for (let at = 12; at < file.length;) {
    const length = file.readUInt32LE(at + 4);
    if (file.toString("latin1", at, at + 4) === "VP8 ") return { ...made, data: file.subarray(at, at + 8 + length + (length & 1)) };
    at += 8 + length + (length & 1);
  }
  throw new Error("the browser made no lossy WebP");
}

/** Pictures as one animated WebP file that begins again for ever (the container's specification: "WebP Container Specification"). */
function animation(all) {
  const { width, height } = all[0];
  const moves = 2;  // of the flags: it is an animation
  const parts = [chunk("VP8X", bytes([moves, 4], [width - 1, 3], [height - 1, 3])), chunk("ANIM", bytes([0, 4], [0, 2]))];
  for (const picture of all) {
    const place = bytes([0, 3], [0, 3], [width - 1, 3], [height - 1, 3], [kDuration_ms, 3], [0, 1]);
    parts.push(chunk("ANMF", Buffer.concat([place, picture.data])));
  }
  const body = Buffer.concat([Buffer.from("WEBP"), ...parts]);
  return Buffer.concat([Buffer.from("RIFF"), bytes([body.length, 4]), body]);
}

function chunk(name, body) {
  return Buffer.concat([Buffer.from(name), bytes([body.length, 4]), body, Buffer.alloc(body.length & 1)]);
}

/** Numbers, each in so many bytes, the lowest first. */
function bytes(...numbers) {
  return Buffer.concat(numbers.map(([value, count]) => {
    const one = Buffer.alloc(count);
    one.writeUIntLE(value, 0, count);
    return one;
  }));
}
