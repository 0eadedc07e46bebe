// SPDX-License-Identifier: Apache-2.0
// Masks of hands: the brush, and what they look like over the image.
import type { ImageView } from "./image_view.ts";
import type { HandLabels } from "./label_protocol.ts";
import type { Point2, Side } from "./protocol.ts";

export type Tool = "landmarks" | "brush" | "eraser";

const kMostPoints = 250;  // of one message; a longer stroke is sent in pieces
const kSizes_px = [0.5, 1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 100];
const kColours: Record<Side, [number, number, number]> = { right: [255, 214, 64], left: [120, 220, 255] };
const kOpacity = 110;  // of 255

/** Width, height, then lengths of runs, row by row: first of pixels that are not hand. */
export type MaskRuns = number[];

/** Calls `visit` with the first and the last pixel's number, exclusive, of each run that is hand. */
function forEachRun(mask: MaskRuns, visit: (first: number, end: number) => void): void {
  let at = 0;
  for (let i = 2; i < mask.length; ++i) {
    const end = at + mask[i]!;
    if (i % 2 === 1) visit(at, end);
    at = end;
  }
}

export function pixelsIn(mask: MaskRuns | null): number {
  let count = 0;
  if (mask) forEachRun(mask, (first, end) => { count += end - first; });
  return count;
}

export class MaskTool {
  tool: Tool = "landmarks";
  radius_px = 4;
  stroke: Point2[] | null = null;  // being painted
  pointer: Point2 | null = null;  // over the image [px]

  #layer = document.createElement("canvas");
  #context = this.#layer.getContext("2d")!;

  resize(by: 1 | -1): void {
    const at = kSizes_px.indexOf(this.radius_px);
    this.radius_px = kSizes_px[Math.min(kSizes_px.length - 1, Math.max(0, at + by))]!;
  }

  begin(at: Point2): void {
    this.stroke = [at];
  }

  /** Goes on with the stroke; places that are hardly apart are left out. */
  move(at: Point2): void {
    this.pointer = at;
    const last = this.stroke?.at(-1);
    if (last && Math.hypot(at[0] - last[0], at[1] - last[1]) >= Math.max(0.5, 0.2 * this.radius_px)) this.stroke!.push(at);
  }

  /** The stroke in pieces that hang together, each short enough for a message; empty where there is none. */
  end(): Point2[][] {
    const stroke = this.stroke ?? [];
    this.stroke = null;
    const pieces: Point2[][] = [];
    for (let first = 0; first < stroke.length; first += kMostPoints - 1) {
      if (first === 0 || first < stroke.length - 1) pieces.push(stroke.slice(first, first + kMostPoints));
    }
    return pieces;
  }

  drop(): void {
    this.stroke = null;
  }

  draw(canvas: HTMLCanvasElement, view: ImageView, labels: HandLabels[], side: Side): void {
    const context = canvas.getContext("2d")!;
    const ratio = canvas.width / Math.max(1, canvas.clientWidth);
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    for (const hand of labels) if (hand.mask) this.#drawMask(context, view, hand.mask, kColours[hand.side]);
    if (this.tool !== "landmarks") this.#drawBrush(context, view, kColours[side]);
    context.setTransform(1, 0, 0, 1, 0, 0);
  }

  #drawMask(context: CanvasRenderingContext2D, view: ImageView, mask: MaskRuns, colour: [number, number, number]): void {
    const [width, height] = [mask[0]!, mask[1]!];
    const data = new ImageData(width, height);
    const pixels = new Uint32Array(data.data.buffer);
    const abgr = ((kOpacity << 24) | (colour[2] << 16) | (colour[1] << 8) | colour[0]) >>> 0;
    forEachRun(mask, (first, end) => pixels.fill(abgr, first, end));
    this.#layer.width = width;
    this.#layer.height = height;
    this.#context.putImageData(data, 0, 0);
    const [left, top] = view.canvasAt([-0.5, -0.5]);
    const [right, bottom] = view.canvasAt([width - 0.5, height - 0.5]);
    context.imageSmoothingEnabled = false;
    context.drawImage(this.#layer, left, top, right - left, bottom - top);
  }

  #drawBrush(context: CanvasRenderingContext2D, view: ImageView, colour: [number, number, number]): void {
    const radius = view.canvasAt([this.radius_px, 0])[0] - view.canvasAt([0, 0])[0];
    if (this.stroke) {
      context.beginPath();
      this.stroke.forEach((at, i) => (i === 0 ? context.moveTo(...view.canvasAt(at)) : context.lineTo(...view.canvasAt(at))));
      context.lineTo(...view.canvasAt(this.stroke.at(-1)!));
      context.lineCap = context.lineJoin = "round";
      context.lineWidth = 2 * radius;
      context.strokeStyle = this.tool === "eraser" ? "rgba(17, 22, 28, 0.6)" : `rgba(${colour.join(", ")}, 0.45)`;
      context.stroke();
    }
    if (!this.pointer) return;
    for (const [width, shade] of [[3, "#0b0f13"], [1.2, "#ffffff"]] as const) {
      context.beginPath();
      context.arc(...view.canvasAt(this.pointer), radius, 0, 2 * Math.PI);
      context.lineWidth = width;
      context.strokeStyle = shade;
      context.stroke();
    }
  }
}
