// SPDX-License-Identifier: Apache-2.0
// How long a set takes to open in the page for labelling: `measure_opening.mjs PROGRAM SOURCE LABELS [RUNS]`. Labels that are there are gone on with.
import { loadavg } from "node:os";
import { Annotate } from "./annotator.mjs";
import { launch } from "./browser.mjs";

const [program, source, labels, runs = "3"] = process.argv.slice(2);
const browser = await launch();
for (let run = 0; run < Number(runs); ++run) {
  const began_ms = performance.now();
  const knuckle = await Annotate.start(program, ["--source", source, "--labels", labels]);
  const serves_ms = performance.now() - began_ms;
  const page = await browser.newPage();
  const opened_ms = performance.now();
  await page.goto(knuckle.address);
  await page.waitForFunction(() => globalThis.knuckle?.header() !== null && globalThis.knuckle.standings() !== null && globalThis.knuckle.isQuiet(), null, { timeout: 120_000 });
  const seconds = (ms) => (ms / 1000).toFixed(2);
  const load = loadavg()[0].toFixed(0);
  console.log(`the program serves after ${seconds(serves_ms)} s, the page has drawn the frame and knows all ${seconds(performance.now() - opened_ms)} s later; load ${load}`);
  await page.close();
  await knuckle.stop();
}
await browser.close();
