// SPDX-License-Identifier: Apache-2.0
// What the server of `knuckle annotate` says. All of it is checked before it is used.
import {
  fail, list, number, numberOrNull, object, readBones, readNames, readRecord, readSurface, text, type Capsule, type FrameRecord, type Point2,
  type Point3, type Side,
} from "./protocol.ts";

export type LabelState = "estimated" | "propagated" | "corrected" | "verified";

export const kStates: LabelState[] = ["estimated", "propagated", "corrected", "verified"];

/** What is known of one landmark beside its place. */
export interface LandmarkLabel {
  state: LabelState;
  visible: boolean;
}

/** The labels of one hand beside their places, which are in the record. */
export interface HandLabels {
  side: Side;
  revision: number;
  state: LabelState;
  seconds: number;
  author: string;
  rms_mm: number | null;
  gap_mm: number | null;
  mask: number[] | null;  // width, height, runs
  landmarks: Record<string, LandmarkLabel | null>;
}

/** A frame's labels as they stand: hands of record, surface and labels are in the same order. */
export interface Labelled {
  record: FrameRecord;
  surface: Capsule[][];
  labels: HandLabels[];
}

/** What came of a change. */
export interface LabelAnswer extends Labelled {
  refused: boolean;
  remark: string;
  fit_ms: number | null;
  fault: string;
  waiting: number;
}

export interface LabelInfo {
  version: string;
  source: string;
  frames: number;
  convention: string;
  landmarks: string[];
  bones: [string, string][];
  file: string;
  author: string;
  pipeline: string;
}

/** How all frames stand: a letter each, - nothing, e estimated, p propagated, c corrected, v verified. */
export interface Standings {
  states: string;
  doubts: number[];
  verified: number;
  median_s: number | null;
}

/** What the page asks to change. */
export interface LabelRequest {
  act: "place" | "move" | "look" | "free" | "verify" | "undo" | "redo" | "brush" | "outline";
  frame?: number;
  side?: Side;
  revision?: number;
  landmark?: string;
  pixel?: Point2;
  point_mm?: Point3;
  visible?: boolean;
  points?: Point2[];
  radius_px?: number;
  erases?: boolean;
  preview?: boolean;
  model?: boolean;
  seconds?: number;
}

const kMostFrames = 10_000_000;

function stateFrom(value: unknown, name: string): LabelState {
  return kStates.find((state) => state === value) ?? fail(`${name} is no state of a label`);
}

function readLandmarks(value: unknown): Record<string, LandmarkLabel | null> {
  const landmarks: Record<string, LandmarkLabel | null> = {};
  for (const [name, one] of Object.entries(object(value, "landmarks")).slice(0, 1024)) {
    if (one === null) {
      landmarks[name] = null;
      continue;
    }
    const label = object(one, name);
    landmarks[name] = { state: stateFrom(label["state"], name), visible: label["visible"] !== false };
  }
  return landmarks;
}

const kMostRuns = 100_000;
const kMostSide = 16_384;

/** Runs that fill an image exactly, or null. */
function readMask(value: unknown): number[] | null {
  if (value === null || value === undefined) return null;
  const mask = list(value, "mask", 2 + kMostRuns).map((one) => number(one, "mask"));
  const [width = 0, height = 0, ...runs] = mask;
  const isWhole = mask.every((one) => Number.isInteger(one) && one >= 0);
  if (!isWhole || width < 1 || height < 1 || width > kMostSide || height > kMostSide) fail("mask is no list of runs");
  if (runs.reduce((sum, run) => sum + run, 0) !== width * height) fail("the mask's runs do not fill its image");
  return mask;
}

function readHandLabels(value: unknown): HandLabels {
  const hand = object(value, "labels");
  const side = hand["side"];
  if (side !== "right" && side !== "left") fail("labels.side is neither right nor left");
  return {
    side,
    revision: number(hand["revision"], "labels.revision"),
    state: stateFrom(hand["state"], "labels.state"),
    seconds: numberOrNull(hand["seconds"], "labels.seconds") ?? 0,
    author: text(hand["author"] ?? "", "labels.author"),
    rms_mm: numberOrNull(hand["rms_mm"], "labels.rms_mm"),
    gap_mm: numberOrNull(hand["gap_mm"], "labels.gap_mm"),
    mask: readMask(hand["mask"]),
    landmarks: readLandmarks(hand["landmarks"]),
  };
}

/** Reads labels, of a frame's header or of an answer. Throws a MessageError. */
export function readLabelled(value: unknown): Labelled {
  const said = object(value, "the answer");
  const labelled = {
    record: readRecord(said["record"]),
    surface: readSurface(said["surface"]),
    labels: list(said["labels"], "labels", 64).map(readHandLabels),
  };
  const { hands } = labelled.record;
  if (hands.length !== labelled.labels.length || hands.some((hand, i) => hand.side !== labelled.labels[i]!.side)) fail("its hands are not those of its labels");
  return labelled;
}

export function readLabelAnswer(value: unknown): LabelAnswer {
  const said = object(value, "the answer");
  return {
    ...readLabelled(said),
    refused: said["refused"] === true,
    remark: text(said["remark"] ?? "", "remark"),
    fit_ms: numberOrNull(said["fit_ms"], "fit_ms"),
    fault: text(said["fault"] ?? "", "fault"),
    waiting: number(said["waiting"] ?? 0, "waiting"),
  };
}

export function readLabelInfo(value: unknown): LabelInfo {
  const info = object(value, "the answer");
  const frames = number(info["frames"], "frames");
  if (!Number.isInteger(frames) || frames < 1 || frames > kMostFrames) fail(`frames is ${frames}; expected 1 to ${kMostFrames}`);
  return {
    version: text(info["version"] ?? "", "version"),
    source: text(info["source"] ?? "", "source"),
    frames,
    convention: text(info["convention"] ?? "", "convention"),
    landmarks: readNames(info["landmarks"]),
    bones: readBones(info["bones"]),
    file: text(info["file"] ?? "", "file"),
    author: text(info["author"] ?? "", "author"),
    pipeline: text(info["pipeline"] ?? "", "pipeline"),
  };
}

export function readStandings(value: unknown): Standings {
  const said = object(value, "the answer");
  const states = said["states"];
  if (typeof states !== "string" || states.length > kMostFrames || !/^[-epcv]*$/.test(states)) fail("states are no letters of states");
  return {
    states,
    doubts: list(said["doubts"], "doubts", states.length).map((one) => numberOrNull(one, "doubts") ?? 0),
    verified: number(said["verified"] ?? 0, "verified"),
    median_s: numberOrNull(said["median_s"], "median_s"),
  };
}
