// SPDX-License-Identifier: Apache-2.0
// What the server says: the answer of /api/info, and the messages of /api/frames. All of it is checked before it is used.

export type Side = "right" | "left";
export type Point2 = [number, number];
export type Point3 = [number, number, number];

export interface Hand {
  id: number;
  side: Side | null;
  score: number | null;  // 0 to 1
  landmarks_mm: Record<string, Point3 | null>;  // camera coordinates: x right, y down, z forward
  landmarks_px: Record<string, Point2 | null>;  // in the source's pixel origin
  confidence: Record<string, number | null>;  // 0 to 1; empty where the method gives none
}

export interface FrameRecord {
  frame: number;
  name: string;
  time_s: number | null;
  status: string;
  hands: Hand[];
  latency_ms: number | null;
}

export interface Camera {
  model: "projective" | "orthographic";
  width: number;
  height: number;
  fx: number;
  fy: number;
  cx: number;
  cy: number;
  distortion: number[];  // OpenCV's k1, k2, p1, p2, k3, k4, k5, k6; empty: none
  pixel_origin: "centre" | "corner";
}

export interface Recording {
  file: string | null;
  frames: number;
  dropped: number;
  fault: string;  // why it ended; empty where all is well
}

/** Two spheres and the cone that touches both: x, y, z, radius of one end and of the other [mm]. */
export type Capsule = number[];

export interface FrameHeader {
  record: FrameRecord;
  camera: Camera;
  width: number;
  height: number;
  depth_unit_mm: number;
  infrared: boolean;
  surface: Capsule[][];  // one list per hand
  recording: Recording | null;
  arrived: number | null;  // frames that came from the camera so far
  passed_over: number | null;  // of those, how many there was no time for
}

/** A message whose header is read and whose pixels still lie in its buffer. */
export interface FrameMessage {
  header: FrameHeader;
  said: unknown;  // the header as it came, with what only some pages read
  buffer: ArrayBuffer;
  pixels: number;  // where the depth begins [bytes]
}

export interface Info {
  version: string;
  source: string;
  convention: string;
  landmarks: string[];
  bones: [string, string][];
  pipeline: string;
  recording: Recording | null;
  can_record: boolean;
}

/** Says in plain words what is wrong with a message. */
export class MessageError extends Error {}

const kMostHeaderBytes = 16 << 20;
const kMostSide = 16384;
const kMostHands = 64;
const kMostNames = 1024;

export type Json = { [key: string]: unknown };

export function fail(text: string): never {
  throw new MessageError(text);
}

export function object(value: unknown, name: string): Json {
  if (typeof value !== "object" || value === null || Array.isArray(value)) fail(`${name} is not an object`);
  return value as Json;
}

export function list(value: unknown, name: string, most: number): unknown[] {
  if (!Array.isArray(value)) fail(`${name} is not a list`);
  if (value.length > most) fail(`${name} has ${value.length} entries; at most ${most} are expected`);
  return value;
}

export function number(value: unknown, name: string): number {
  if (typeof value !== "number" || !Number.isFinite(value)) fail(`${name} is not a number`);
  return value;
}

export function numberOrNull(value: unknown, name: string): number | null {
  return value === null || value === undefined ? null : number(value, name);
}

export function text(value: unknown, name: string): string {
  if (typeof value !== "string") fail(`${name} is not text`);
  return value.slice(0, 4096);
}

function imageSide(value: unknown, name: string): number {
  const side = number(value, name);
  if (!Number.isInteger(side) || side < 1 || side > kMostSide) fail(`${name} is ${side}; expected 1 to ${kMostSide}`);
  return side;
}

/** An object whose every entry passes `check`, which says that it is a T. */
export function named<T>(value: unknown, name: string, check: (value: unknown, name: string) => void): Record<string, T> {
  const entries = Object.entries(object(value ?? {}, name));
  if (entries.length > kMostNames) fail(`${name} has ${entries.length} entries; at most ${kMostNames} are expected`);
  for (const [key, one] of entries) check(one, `${name}.${key}`);
  return (value ?? {}) as Record<string, T>;
}

function coordinates(size: number) {
  return (value: unknown, name: string): void => {
    if (value === null) return;
    if (list(value, name, size).length !== size) fail(`${name} has not ${size} coordinates`);
    for (const one of value as unknown[]) number(one, name);
  };
}

function readHand(value: unknown, name: string): Hand {
  const hand = object(value, name);
  const side = hand["side"] ?? null;
  if (side !== null && side !== "right" && side !== "left") fail(`${name}.side is neither right nor left`);
  return {
    id: number(hand["id"], `${name}.id`),
    side,
    score: numberOrNull(hand["score"], `${name}.score`),
    landmarks_mm: named<Point3 | null>(hand["landmarks_mm"], `${name}.landmarks_mm`, coordinates(3)),
    landmarks_px: named<Point2 | null>(hand["landmarks_px"], `${name}.landmarks_px`, coordinates(2)),
    confidence: named<number | null>(hand["confidence"], `${name}.confidence`, numberOrNull),
  };
}

export function readRecord(value: unknown): FrameRecord {
  const record = object(value, "record");
  return {
    frame: number(record["frame"], "record.frame"),
    name: text(record["name"] ?? "", "record.name"),
    time_s: numberOrNull(record["time_s"], "record.time_s"),
    status: text(record["status"] ?? "", "record.status"),
    hands: list(record["hands"], "record.hands", kMostHands).map((hand, i) => readHand(hand, `record.hands[${i}]`)),
    latency_ms: numberOrNull(record["latency_ms"], "record.latency_ms"),
  };
}

function readCamera(value: unknown): Camera {
  const camera = object(value, "camera");
  const model = camera["model"] ?? "projective";
  if (model !== "projective" && model !== "orthographic") fail("camera.model is neither projective nor orthographic");
  const origin = camera["pixel_origin"] ?? "centre";
  if (origin !== "centre" && origin !== "corner") fail("camera.pixel_origin is neither centre nor corner");
  const fx = number(camera["fx"], "camera.fx");
  const fy = number(camera["fy"], "camera.fy");
  if (fx === 0 || fy === 0) fail("camera.fx or camera.fy is 0");
  return {
    model,
    width: imageSide(camera["width"], "camera.width"),
    height: imageSide(camera["height"], "camera.height"),
    fx, fy,
    cx: number(camera["cx"], "camera.cx"),
    cy: number(camera["cy"], "camera.cy"),
    distortion: list(camera["distortion"] ?? [], "camera.distortion", 8).map((k) => number(k, "camera.distortion")),
    pixel_origin: origin,
  };
}

export function readRecording(value: unknown): Recording | null {
  if (value === null || value === undefined) return null;
  const recording = object(value, "recording");
  const file = recording["file"] ?? null;
  return {
    file: file === null ? null : text(file, "recording.file"),
    frames: number(recording["frames"] ?? 0, "recording.frames"),
    dropped: number(recording["dropped"] ?? 0, "recording.dropped"),
    fault: text(recording["fault"] ?? "", "recording.fault"),
  };
}

export function readSurface(value: unknown): Capsule[][] {
  return list(value ?? [], "surface", kMostHands).map((hand) => list(hand ?? [], "surface", kMostNames).map((capsule) => {
    if (list(capsule, "surface", 8).length !== 8) fail("a capsule of surface has not 8 numbers");
    return (capsule as unknown[]).map((one) => number(one, "surface"));
  }));
}

function readHeader(value: unknown): FrameHeader {
  const header = object(value, "the header");
  const unit = number(header["depth_unit_mm"], "depth_unit_mm");
  if (unit <= 0) fail(`depth_unit_mm is ${unit}; expected more than 0`);
  return {
    record: readRecord(header["record"]),
    camera: readCamera(header["camera"]),
    width: imageSide(header["width"], "width"),
    height: imageSide(header["height"], "height"),
    depth_unit_mm: unit,
    infrared: header["infrared"] === true,
    surface: readSurface(header["surface"]),
    recording: readRecording(header["recording"]),
    arrived: numberOrNull(header["arrived"], "arrived"),
    passed_over: numberOrNull(header["passed_over"], "passed_over"),
  };
}

function parseJson(bytes: Uint8Array): unknown {
  try {
    return JSON.parse(new TextDecoder("utf-8", { fatal: true }).decode(bytes));
  } catch {
    fail("its header is not JSON");
  }
}

/** Reads a message of /api/frames; its pixels stay where they are. Throws a MessageError. */
export function readFrame(data: unknown): FrameMessage {
  if (!(data instanceof ArrayBuffer)) fail("it is text, where bytes were expected");
  if (data.byteLength < 4) fail(`it has ${data.byteLength} bytes; a frame begins with the length of its header`);
  const length = new DataView(data).getUint32(0, true);
  if (length > kMostHeaderBytes || length > data.byteLength - 4) fail(`its header of ${length} bytes is longer than the message`);
  const said = parseJson(new Uint8Array(data, 4, length));
  const header = readHeader(said);
  const pixels = 4 + length;
  const expected = header.width * header.height * (header.infrared ? 4 : 2);
  const found = data.byteLength - pixels;
  if (found !== expected) {
    fail(`it holds ${found} bytes of pixels; ${header.width} x ${header.height}` +
         `${header.infrared ? " with infrared" : ""} needs ${expected}`);
  }
  return { header, said, buffer: data, pixels };
}

/** Pairs of landmarks that a bone joins. */
export function readBones(value: unknown): [string, string][] {
  return list(value ?? [], "bones", kMostNames).map((bone): [string, string] => {
    const ends = list(bone, "bones", 2);
    return [text(ends[0], "bones"), text(ends[1], "bones")];
  });
}

export function readNames(value: unknown): string[] {
  return list(value ?? [], "landmarks", kMostNames).map((name) => text(name, "landmarks"));
}

/** Reads the answer of /api/info. Throws a MessageError. */
export function readInfo(value: unknown): Info {
  const info = object(value, "the answer");
  return {
    version: text(info["version"] ?? "", "version"),
    source: text(info["source"] ?? "", "source"),
    convention: text(info["convention"] ?? "", "convention"),
    landmarks: readNames(info["landmarks"]),
    bones: readBones(info["bones"]),
    pipeline: text(info["pipeline"] ?? "", "pipeline"),
    recording: readRecording(info["recording"]),
    can_record: info["can_record"] === true,
  };
}

/** Images of one frame, in memory that is kept from frame to frame. */
export class FrameImages {
  width = 0;
  height = 0;
  hasInfrared = false;
  depth = new Uint16Array(0);  // rows x columns, in counts of depth_unit_mm; 0: not measured
  infrared = new Uint16Array(0);

  /** Copies the pixels out of a message. Pixels are little-endian, as all machines are that browsers run on today. */
  take(message: FrameMessage): void {
    const { width, height, infrared } = message.header;
    const count = width * height;
    if (this.depth.length !== count) this.depth = new Uint16Array(count);
    if (infrared && this.infrared.length !== count) this.infrared = new Uint16Array(count);
    this.width = width;
    this.height = height;
    this.hasInfrared = infrared;
    copyBytes(message.buffer, message.pixels, this.depth);
    if (infrared) copyBytes(message.buffer, message.pixels + 2 * count, this.infrared);
  }
}

function copyBytes(from: ArrayBuffer, offset: number, to: Uint16Array): void {
  new Uint8Array(to.buffer, to.byteOffset, to.byteLength).set(new Uint8Array(from, offset, to.byteLength));
}
