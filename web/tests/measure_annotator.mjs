// SPDX-License-Identifier: Apache-2.0
// How far labels are from the truth after so many corrections, by the scripted annotator in a real browser; prints a table, no verdict:
//     node web/tests/measure_annotator.mjs PROGRAM FRAMES MOST_CORRECTIONS [raw] [verify] [turns] [guess] [large]
// `raw` switches the hand model off; with `verify` each frame is verified before the next, so that neighbours follow, and frames are taken as the
// program proposes them; `turns`: landmarks are also moved in the points, from the side and from above; `guess`: hidden ones are placed, too,
// with a deviation of 10 mm; `large`: frames of 640x480 in place of 320x240. bench/labelling.cpp does the same without a browser.
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { Annotate, correctFarthest, errorOf, normals, openFrame, project, quiet, runProgram, shown, truthOf } from "./annotator.mjs";
import { launch } from "./browser.mjs";

const [program, frames = "60", most = "4", ...words] = process.argv.slice(2);
const has = (word) => words.includes(word);
const how = { turns: has("turns"), guess_mm: has("guess") ? 10 : 0 };
const folder = mkdtempSync(join(tmpdir(), "knuckle-annotator-"));
const count = Number(frames);
const manifest = join(folder, "manifest.toml");
const large = { width: "640", height: "480", fx: "600.0", fy: "600.0", cx: "319.5", cy: "239.5" };
writeFileSync(manifest, readFileSync(join(project, "manifests", "test_scenes.toml"), "utf8")
  .replaceAll(/^(width|height|fx|fy|cx|cy) = .*$/gm, (line, key) => (has("large") ? `${key} = ${large[key]}` : line)));
runProgram(program, ["render", "--manifest", manifest, "--count", frames, "--format", "folder", "--out", join(folder, "scenes")]);
const truth = truthOf(join(folder, "scenes"));
const knuckle = await Annotate.start(program, ["--source", `folder:${join(folder, "scenes")}`, "--labels", join(folder, "labels"), "--prelabel", "pipelines/default.toml"]);
const browser = await launch();
const page = await browser.newPage({ viewport: { width: 1440, height: 900 } });
const answered = [];
const drawn = [];
const fits = [];
try {
  await page.goto(knuckle.address);
  await page.waitForFunction(() => globalThis.knuckle?.header() !== null, null, { timeout: 60_000 });
  await page.waitForFunction(() => !(globalThis.knuckle.standings()?.states ?? "-").includes("-"), null, { timeout: 300_000 });
  if (has("raw")) await page.keyboard.press("m");
  const normal = normals(11);
  const sums = Array.from({ length: Number(most) + 1 }, () => 0);
  const seen = [];
  let corrections = 0;
  for (let done = 0; done < count; ++done) {
    let frame = done;
    if (has("verify")) {
      frame = await page.evaluate(async (after) => (await (await fetch(`api/next?after=${after}`)).json()).frame, seen.at(-1) ?? 0);
      if (frame === null) break;
    }
    seen.push(frame);
    await openFrame(page, frame);
    let error = errorOf(await shown(page), truth[frame]);
    sums[0] += error;
    for (let i = 1; i <= Number(most); ++i) {
      const corrected = await correctFarthest(page, truth[frame], normal, how);
      if (corrected) {
        ++corrections;
        answered.push(await page.evaluate(() => globalThis.knuckle.answered_ms()));
        await page.waitForFunction(() => globalThis.knuckle.drawn_ms() !== null);
        drawn.push(await page.evaluate(() => globalThis.knuckle.drawn_ms()));
        fits.push(await page.evaluate(() => globalThis.knuckle.fit_ms()));
        error = errorOf(await shown(page), truth[frame]);
      }
      sums[i] += error;
    }
    if (has("verify")) {
      await page.keyboard.press("v");
      await quiet(page);
      await page.waitForTimeout(600);  // neighbours follow
    }
  }
  const percentile = (values, share) => values.toSorted((a, b) => a - b)[Math.floor(share * (values.length - 1))]?.toFixed(1);
  console.log(`${seen.length} frames${words.map((word) => `, ${word}`).join("")}: ${(corrections / seen.length).toFixed(2)} corrections per frame`);
  sums.forEach((sum, i) => console.log(`  after ${i} corrections: ${(sum / seen.length).toFixed(2)} mm`));
  if (has("verify")) {
    const scenes = `folder:${join(folder, "scenes")}`;
    for (const smooth of [0, 4]) {
      const poses = join(folder, `poses_${smooth}.txt`);
      runProgram(program, ["labels", "export", "--source", scenes, "--labels", join(folder, "labels"), "--format", "poses", "--smooth", `${smooth}`, "--out", poses]);
      runProgram(program, ["evaluate", "--truth", scenes, "--predictions", `labels=${poses}`, "--out", join(folder, `report_${smooth}`)]);
      const [method] = JSON.parse(readFileSync(join(folder, `report_${smooth}`, "metrics.json"), "utf8")).methods;
      console.log(`  exported with --smooth ${smooth}: ${method.mean_3d_mm.toFixed(2)} mm`);
    }
  }
  console.log(`  fit ${percentile(fits, 0.5)} ms, 95th percentile ${percentile(fits, 0.95)} ms; change to answer in the page ${percentile(answered, 0.5)} ms, ${percentile(answered, 0.95)} ms; until drawn ${percentile(drawn, 0.5)} ms, ${percentile(drawn, 0.95)} ms`);
} finally {
  await browser.close();
  await knuckle.stop();
  rmSync(folder, { recursive: true, force: true });
}
