// SPDX-License-Identifier: Apache-2.0
// Opens the page of `knuckle live --view ADDRESS` in Chromium until standard input ends; then prints as JSON how many
// pictures per second it showed (its own numbers, one a second).
import { createRequire } from "node:module";
const { chromium } = createRequire(new URL("../web/package.json", import.meta.url))("playwright-core");

const sandbox = process.getuid?.() === 0 ? ["--no-sandbox"] : [];
const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  args: ["--use-angle=swiftshader", "--enable-unsafe-swiftshader", ...sandbox],
});
const page = await browser.newPage({ viewport: { width: 1280, height: 800 } });
await page.goto(process.argv[2]);
const rates = [];
let ended = false;
process.stdin.on("end", () => { ended = true; }).resume();
while (!ended) {
  await page.waitForTimeout(1000);
  const rate = parseFloat(await page.textContent("#pictures"));
  if (Number.isFinite(rate)) rates.push(rate);
}
rates.sort((a, b) => a - b);
console.log(JSON.stringify({ pictures_per_second: { median: rates[rates.length >> 1] ?? null, least: rates[0] ?? null } }));
await browser.close();
