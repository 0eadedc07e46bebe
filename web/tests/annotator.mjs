// SPDX-License-Identifier: Apache-2.0
// A scripted annotator: it works in the page as a person would, who sees where each joint truly appears, and clicks with a tremble.
import { spawn, spawnSync } from "node:child_process";
import { readFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

export const project = join(dirname(fileURLToPath(import.meta.url)), "..", "..");

/** Runs the program to its end. */
export function runProgram(program, args) {
  const run = spawnSync(program, args, { cwd: project, encoding: "utf8" });
  if (run.status !== 0) throw new Error(`knuckle ${args.join(" ")}: ${run.stderr}`);
  return run.stdout;
}

/** `knuckle annotate` with these arguments, once it serves. `most_kB`: its files may grow no larger. */
export class Annotate {
  static async start(program, args, most_kB = null) {
    const one = new Annotate();
    const command = [program, "annotate", "--port", "0", ...args];
    const limited = ["bash", "-c", `ulimit -S -f ${most_kB}; exec "$@"`, "limited", ...command];
    const [first, ...others] = most_kB === null ? command : limited;
    one.process = spawn(first, others, { cwd: project });
    one.said = "";
    one.ended = new Promise((done) => one.process.on("exit", (status, signal) => done({ status, signal })));
    one.process.stdout.on("data", (text) => { one.said += text; });
    one.address = await new Promise((done, fail) => {
      one.process.stderr.on("data", (text) => {
        one.said += text;
        const found = /annotate: (http:\S+)/.exec(one.said);
        if (found) done(found[1]);
      });
      one.process.on("exit", (status) => fail(new Error(`knuckle ended with ${status}: ${one.said}`)));
    });
    return one;
  }

  async stop(signal = "SIGINT") {
    this.process.kill(signal);
    return this.ended;
  }
}

/** The joints of a folder set, by frame: [u, v, d] in the order of its convention; null where there is none. */
export function truthOf(folder) {
  return readFileSync(join(folder, "joints.txt"), "utf8").trim().split("\n").map((line) => {
    const numbers = line.trim().split(/\s+/).map(Number);
    return Array.from({ length: numbers.length / 3 }, (_, i) => numbers.slice(3 * i, 3 * i + 3)).map((joint) => (joint.some(Number.isNaN) ? null : joint));
  });
}

/** A reproducible normal distribution. */
export function normals(seed) {
  let state = seed >>> 0;
  const uniform = () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return (state + 0.5) / 4294967296;
  };
  return () => Math.sqrt(-2 * Math.log(uniform())) * Math.cos(2 * Math.PI * uniform());
}

export function toSpace([u, v, d], { fx, fy, cx, cy }) {
  return [((u - cx) / fx) * d, ((v - cy) / fy) * d, d];
}

const distance = (a, b) => Math.hypot(...a.map((value, i) => value - b[i]));

export async function quiet(page) {
  await page.waitForFunction(() => globalThis.knuckle?.isQuiet(), null, { timeout: 60_000 });
}

export async function openFrame(page, frame) {
  await page.evaluate((wanted) => { globalThis.knuckle.open(wanted); }, frame);
  await page.waitForFunction((wanted) => globalThis.knuckle.frame() === wanted && globalThis.knuckle.isQuiet(), frame, { timeout: 60_000 });
}

/** What the page shows of a frame: its labels in space, its camera and its landmarks. */
export function shown(page) {
  return page.evaluate(() => {
    const header = globalThis.knuckle.header();
    return { camera: header.camera, hands: header.record.hands, labels: globalThis.knuckle.labels() };
  });
}

/** Mean distance of the shown labels from the truth [mm]. */
export function errorOf({ camera, hands }, truth) {
  const points = Object.values(hands[0]?.landmarks_mm ?? {});
  let sum = 0;
  let count = 0;
  truth.forEach((joint, i) => {
    if (!joint) return;
    sum += points[i] ? distance(points[i], toSpace(joint, camera)) : 100;
    ++count;
  });
  return sum / count;
}

/** Which true landmarks are seen: nothing lies before them but their own flesh. */
function seenOf(page, truth) {
  return page.evaluate((joints) => joints.map((joint, i) => {
    if (!joint) return false;
    const depth = globalThis.knuckle.depth_mm(Math.round(joint[0]), Math.round(joint[1]));
    return depth > 0 && joint[2] - depth < (i < 3 ? 45 : 20);
  }), truth);
}

/** The view in which something is seen to move farthest: the image, or the points from the side or from above. */
function bestView([x, y, z]) {
  const [front, side, top] = [Math.hypot(x, y), Math.hypot(y, z), Math.hypot(x, z)];
  if (front >= side && front >= top) return "image";
  return side >= top ? "side" : "top";
}

/**
 * Corrects the landmark that lies farthest from where the true one appears, with the pointer. Returns its name; null where none is off.
 * `turns`: also in the points, turned to where the error is seen best. `guess_mm`: a hidden landmark that lies twice as far off is said to be
 * hidden and placed by what is known of hands, with this deviation; 0: hidden ones are left.
 */
export async function correctFarthest(page, truth, normal, { deviation_mm = 2, least_mm = 4, turns = false, guess_mm = 0 } = {}) {
  const { camera, hands, labels } = await shown(page);
  if (hands.length === 0) return null;
  const names = Object.keys(hands[0].landmarks_px);
  const seen = await seenOf(page, truth);
  let farthest = null;
  let most = 0;
  truth.forEach((joint, i) => {
    const at = hands[0].landmarks_mm[names[i]];
    const label = labels[0].landmarks[names[i]];
    const isDone = label?.state === "corrected" && !(turns && seen[i]);
    if (!joint || !at || isDone || (!seen[i] && guess_mm === 0)) return;
    const away = distance(at, toSpace(joint, camera));
    if (away > most && away > (seen[i] ? least_mm : 2 * guess_mm)) [farthest, most] = [i, away];
  });
  if (farthest === null) return null;
  const name = names[farthest];
  const tremble_mm = seen[farthest] ? deviation_mm : guess_mm;
  const goal = toSpace(truth[farthest], camera);
  const view = turns ? bestView(goal.map((value, i) => value - hands[0].landmarks_mm[name][i])) : "image";
  if (!seen[farthest] && labels[0].landmarks[name].visible) {
    await choose(page, name);
    await page.keyboard.press("h");
    await quiet(page);
  }
  if (view === "image") {
    const tremble = () => (normal() * tremble_mm * camera.fx) / truth[farthest][2];
    await dragTo(page, name, [truth[farthest][0] + tremble(), truth[farthest][1] + tremble()]);
  } else {
    await dragInPoints(page, name, view, goal.map((value) => value + normal() * tremble_mm));
  }
  return name;
}

function choose(page, name) {
  return page.locator("#landmarks button", { hasText: new RegExp(`^${name.replaceAll("_", " ")}$`) }).click();
}

/** Turns the points to the side or to above, and drags a landmark to where a point in space is seen there. */
export async function dragInPoints(page, name, view, point) {
  await choose(page, name);
  await page.keyboard.press("0");
  await page.keyboard.press(view === "side" ? "2" : "3");
  await quiet(page);
  const box = await page.locator("#cloud").boundingBox();
  const [from, to] = await page.evaluate(([wanted, target]) => {
    const hand = globalThis.knuckle.header().record.hands.find((one) => one.landmarks_mm[wanted]);
    return [globalThis.knuckle.cloudAt(hand.landmarks_mm[wanted]), globalThis.knuckle.cloudAt(target)];
  }, [name, point]);
  await page.mouse.move(box.x + from[0], box.y + from[1]);
  await page.mouse.down();
  await page.mouse.move(box.x + to[0], box.y + to[1], { steps: 3 });
  await page.mouse.up();
  await quiet(page);
}

/** Chooses a landmark in the list and drags it onto a pixel: in the list, because several may lie on each other. */
export async function dragTo(page, name, pixel) {
  await choose(page, name);
  const box = await page.locator("#image").boundingBox();
  const [from, to] = await page.evaluate(([wanted, target]) => {
    const header = globalThis.knuckle.header();
    const hand = header.record.hands.find((one) => one.landmarks_px[wanted]);
    return [hand ? globalThis.knuckle.imageAt(hand.landmarks_px[wanted]) : null, globalThis.knuckle.imageAt(target)];
  }, [name, pixel]);
  await page.mouse.move(box.x + (from ?? to)[0], box.y + (from ?? to)[1]);
  await page.mouse.down();
  await page.mouse.move(box.x + to[0], box.y + to[1], { steps: 3 });
  await page.mouse.up();
  await quiet(page);
}

