// SPDX-License-Identifier: Apache-2.0
// The page in a real Chromium, which draws WebGL in software, before a server that a test controls.
import assert from "node:assert/strict";
import { chromium } from "playwright-core";
import { MockServer, encodeFrame } from "./mock_server.mjs";
import { decodePng } from "./png.mjs";
import * as scene from "./scene.mjs";

export const right = [0xff, 0x5a, 0x2e];  // colours of the first hand of each side
export const left = [0xc8, 0x6b, 0xff];
export const screen = [0x11, 0x16, 0x1c];

const drawnInSoftware = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader"];

/** A browser; `args` in place of those that draw WebGL in software. */
export function launch(args = drawnInSoftware) {
  const sandbox = process.getuid?.() === 0 ? ["--no-sandbox"] : [];
  return chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args: [...args, ...sandbox] });
}

const opened = new Set();

/** Ends all pages and their servers: after each test, however it went. */
export async function closePages() {
  await Promise.all([...opened].map((open) => open.close()));
}

/** One page and its server. */
export class OpenPage {
  faults = [];  // what the console says of errors, and requests to elsewhere
  elsewhere = [];

  static async open(browser, { info = scene.info, query = "", waits = true, prepare = null, ...options } = {}) {
    const open = new OpenPage();
    opened.add(open);
    open.server = new MockServer(structuredClone(info));
    await open.server.start();
    prepare?.(open.server);
    open.context = await browser.newContext({ viewport: { width: 1280, height: 800 }, acceptDownloads: true, ...options });
    open.page = await open.context.newPage();
    open.page.on("console", (message) => { if (["error", "warning"].includes(message.type())) open.faults.push(message.text()); });
    open.page.on("pageerror", (error) => open.faults.push(String(error)));
    open.page.on("request", (request) => {
      if (!/^(blob|data):/.test(request.url()) && !request.url().startsWith(open.server.address)) open.elsewhere.push(request.url());
    });
    await open.page.goto(open.server.address + query);
    if (waits) await open.server.viewer();
    return open;
  }

  async close() {
    opened.delete(this);
    await this.context?.close();
    await this.server.stop();
  }

  /** Sends a frame of these hands and waits until it is drawn. Returns its header. */
  async show(header, depth, infrared = null) {
    this.send(header, depth, infrared);
    await this.shown(header.record.frame);
    return header;
  }

  send(header, depth, infrared = null) {
    this.server.send(encodeFrame(header, depth, infrared));
  }

  /** Waits until a frame is shown and all is drawn. */
  async shown(frame) {
    await this.page.waitForFunction((wanted) => globalThis.knuckle.frame() === wanted, frame);
    await this.drawn();
  }

  /** Waits until what was asked for is drawn: two pictures later. */
  drawn() {
    return this.page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
  }

  picture(selector) {
    return pictureOf(this.page, selector);
  }

  /** Waits until an element does not say something any more. */
  async saysNo(selector, pattern) {
    await this.page.waitForFunction(([where, source]) => !new RegExp(source).test(document.querySelector(where)?.textContent ?? ""), [selector, pattern.source]);
  }

  text(selector) {
    return this.page.locator(selector).innerText();
  }

  /** Waits until an element says something. */
  async says(selector, pattern) {
    try {
      await this.page.waitForFunction(([where, source]) => new RegExp(source).test(document.querySelector(where)?.textContent ?? ""),
                                      [selector, pattern.source], { timeout: 20_000 });
    } catch {
      assert.fail(`${selector} says "${await this.page.locator(selector).textContent()}", expected ${pattern}`);
    }
  }

  /** Waits until an element says something while a frame comes again and again: after two seconds without one, which is soon
      over on a machine that is busy, the page speaks of that alone. */
  async saysOfFrames(header, depth, selector, pattern) {
    const frames = setInterval(() => this.send(header, depth), 200);
    try {
      await this.says(selector, pattern);
    } finally {
      clearInterval(frames);
    }
  }
}

/** An element as it is seen once it changes no more: a machine that is busy shows late what it has drawn. */
export async function pictureOf(page, selector) {
  let before = null;
  for (let i = 0; i < 20; ++i) {
    await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
    await page.waitForTimeout(100);
    const file = await page.locator(selector).screenshot();
    if (before?.equals(file)) break;
    before = file;
  }
  return decodePng(before);
}

/** Where a camera that stands at `position` and looks at `target` sees a point: column and row of a picture. Sensor coordinates: y points down. */
export function seenAt([x, y, z], { position, target, field_of_view_deg }, width, height) {
  const minus = (a, b) => a.map((value, i) => value - b[i]);
  const dot = (a, b) => a.reduce((sum, value, i) => sum + value * b[i], 0);
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const unit = (a) => a.map((value) => value / Math.sqrt(dot(a, a)));
  const forward = unit(minus(target, position));
  const toRight = unit(cross([0, 1, 0], forward));
  const down = cross(forward, toRight);
  const seen = minus([x, y, z], position);
  const focal = height / 2 / Math.tan((field_of_view_deg * Math.PI) / 360);
  return [width / 2 + (focal * dot(seen, toRight)) / dot(seen, forward), height / 2 + (focal * dot(seen, down)) / dot(seen, forward)];
}

/** Where a pixel of the image lies on its canvas: it is as large as fits, in the middle. */
export function imageAt([u, v], camera, width, height) {
  const scale = Math.min(width / camera.width, height / camera.height);
  const shift = camera.pixel_origin === "corner" ? 0 : 0.5;
  return [width / 2 + (u + shift - camera.width / 2) * scale, height / 2 + (v + shift - camera.height / 2) * scale];
}
