// SPDX-License-Identifier: Apache-2.0
// The depth or infrared image with the skeletons over it, on a plain 2D canvas.
import { infraredWhite, type DepthRange } from "./depth_range.ts";
import { handColours, kPaletteSize } from "./palette.ts";
import type { FrameHeader, FrameImages, Hand, Point2 } from "./protocol.ts";
import { confidenceOf, opacityOf, sizeOf } from "./skeleton.ts";

export type ImageKind = "depth" | "infrared";

/** Where the image lies on the canvas [device px]. */
interface Placement {
  left: number;
  top: number;
  scale: number;
}

const kNotMeasured = 0xff201a16;  // ABGR: nearly the screen's own colour
const kOutline = "rgba(8, 12, 16, 0.75)";

export class ImageView {
  kind: ImageKind = "depth";
  showsSkeleton = true;
  namesHands = true;
  zoom = 1;  // against the whole image
  centre: Point2 | null = null;  // the pixel in the middle of the canvas; null: the image's own

  #canvas: HTMLCanvasElement;
  #context: CanvasRenderingContext2D;
  #palette: Uint32Array;
  #image = document.createElement("canvas");
  #imageContext: CanvasRenderingContext2D;
  #data = new ImageData(1, 1);
  #pixels = new Uint32Array(this.#data.data.buffer);

  constructor(canvas: HTMLCanvasElement, palette: Uint8Array) {
    this.#canvas = canvas;
    // The processor writes every pixel anyway: canvases that it keeps (willReadFrequently) spare moving them about.
    this.#context = canvas.getContext("2d", { alpha: false, willReadFrequently: true })!;
    this.#palette = new Uint32Array(palette.buffer);
    this.#imageContext = this.#image.getContext("2d", { willReadFrequently: true })!;
  }

  /** Colours the image of a new frame, or of another range. */
  colour(images: FrameImages, unit_mm: number, range: DepthRange): void {
    this.#resize(images.width, images.height);
    if (this.kind === "infrared" && images.hasInfrared) this.#colourInfrared(images.infrared);
    else this.#colourDepth(images.depth, range.near_mm / unit_mm, range.far_mm / unit_mm);
    this.#imageContext.putImageData(this.#data, 0, 0);
  }

  /** Draws the coloured image and the hands of its record. */
  draw(header: FrameHeader, bones: readonly [string, string][]): void {
    const place = this.#placement();
    const context = this.#context;
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.fillStyle = "#11161c";
    context.fillRect(0, 0, this.#canvas.width, this.#canvas.height);
    context.imageSmoothingEnabled = place.scale < 1;
    context.drawImage(this.#image, place.left, place.top, this.#image.width * place.scale, this.#image.height * place.scale);
    if (!this.showsSkeleton) return;
    const colours = handColours(header.record.hands);
    const shift = header.camera.pixel_origin === "centre" ? 0.5 : 0;  // the canvas counts from the pixel's corner
    context.setTransform(place.scale, 0, 0, place.scale, place.left + shift * place.scale, place.top + shift * place.scale);
    const unit = Math.max((this.#image.width * place.scale) / this.zoom, 480) / 640 / place.scale;  // strokes keep their width on screen
    header.record.hands.forEach((hand, i) => this.#drawHand(hand, bones, colours[i]!, unit));
    context.globalAlpha = 1;
  }

  /** Where the centre of a pixel, or a place between, lies on the canvas [CSS px]. */
  canvasAt([u, v]: Point2): Point2 {
    const ratio = this.#canvas.width / Math.max(1, this.#canvas.clientWidth);
    const place = this.#placement();
    return [(place.left + (u + 0.5) * place.scale) / ratio, (place.top + (v + 0.5) * place.scale) / ratio];
  }

  /** The place in the image under a point of the canvas [CSS px], in pixel-centre coordinates; also outside of the image. */
  placeAt(x: number, y: number): Point2 {
    const ratio = this.#canvas.width / Math.max(1, this.#canvas.clientWidth);
    const place = this.#placement();
    return [(x * ratio - place.left) / place.scale - 0.5, (y * ratio - place.top) / place.scale - 0.5];
  }

  /** Column and row under a point of the canvas [CSS px], or null outside of the image. */
  pixelAt(x: number, y: number): Point2 | null {
    const [column, row] = this.placeAt(x, y).map(Math.round) as Point2;
    const isInside = column >= 0 && row >= 0 && column < this.#image.width && row < this.#image.height;
    return isInside ? [column, row] : null;
  }

  #resize(width: number, height: number): void {
    if (this.#data.width === width && this.#data.height === height) return;
    this.#image.width = width;
    this.#image.height = height;
    this.#data = new ImageData(width, height);
    this.#pixels = new Uint32Array(this.#data.data.buffer);
  }

  #colourDepth(depth: Uint16Array, near: number, far: number): void {
    const pixels = this.#pixels;
    const palette = this.#palette;
    const scale = (kPaletteSize - 1) / (far - near);
    for (let i = 0; i < depth.length; ++i) {
      const count = depth[i]!;
      let shade = ((count - near) * scale) | 0;
      if (shade < 0) shade = 0;
      else if (shade >= kPaletteSize) shade = kPaletteSize - 1;
      pixels[i] = count === 0 ? kNotMeasured : palette[shade]!;
    }
  }

  #colourInfrared(infrared: Uint16Array): void {
    const pixels = this.#pixels;
    const scale = 255 * 255 / infraredWhite(infrared);
    for (let i = 0; i < infrared.length; ++i) {
      const grey = Math.min(255, Math.sqrt(infrared[i]! * scale)) | 0;  // a gamma of 2: dark skin is to be seen
      pixels[i] = 0xff000000 | (grey << 16) | (grey << 8) | grey;
    }
  }

  #placement(): Placement {
    const scale = this.zoom * Math.min(this.#canvas.width / this.#image.width, this.#canvas.height / this.#image.height);
    const [u, v] = this.centre ?? [(this.#image.width - 1) / 2, (this.#image.height - 1) / 2];
    return {
      left: this.#canvas.width / 2 - (u + 0.5) * scale,
      top: this.#canvas.height / 2 - (v + 0.5) * scale,
      scale,
    };
  }

  #drawHand(hand: Hand, bones: readonly [string, string][], colour: string, unit: number): void {
    for (const [from, to] of bones) this.#drawBone(hand, from, to, colour, unit);
    for (const name in hand.landmarks_px) this.#drawLandmark(hand, name, colour, unit);
    if (this.namesHands) this.#drawName(hand, colour, unit);
  }

  #drawBone(hand: Hand, from: string, to: string, colour: string, unit: number): void {
    const a = hand.landmarks_px[from];
    const b = hand.landmarks_px[to];
    if (!a || !b) return;
    const context = this.#context;
    context.globalAlpha = opacityOf(Math.min(confidenceOf(hand, from), confidenceOf(hand, to)));
    context.lineCap = "round";
    context.beginPath();
    context.moveTo(a[0], a[1]);
    context.lineTo(b[0], b[1]);
    context.lineWidth = 5 * unit;
    context.strokeStyle = kOutline;
    context.stroke();
    context.lineWidth = 2.6 * unit;
    context.strokeStyle = colour;
    context.stroke();
  }

  /** A disc; a diamond for left hands, so that sides are told apart without colour. */
  #drawLandmark(hand: Hand, name: string, colour: string, unit: number): void {
    const at = hand.landmarks_px[name];
    if (!at) return;
    const confidence = confidenceOf(hand, name);
    const radius = 4.6 * unit * sizeOf(confidence);
    const context = this.#context;
    context.globalAlpha = opacityOf(confidence);
    context.beginPath();
    if (hand.side === "left") {
      const reach = 1.25 * radius;
      context.moveTo(at[0] - reach, at[1]);
      context.lineTo(at[0], at[1] - reach);
      context.lineTo(at[0] + reach, at[1]);
      context.lineTo(at[0], at[1] + reach);
      context.closePath();
    } else {
      context.arc(at[0], at[1], radius, 0, 2 * Math.PI);
    }
    context.fillStyle = colour;
    context.fill();
    context.lineWidth = 1.2 * unit;
    context.strokeStyle = kOutline;
    context.stroke();
  }

  /** "R 1" below the hand's lowest landmark. */
  #drawName(hand: Hand, colour: string, unit: number): void {
    const points = Object.values(hand.landmarks_px).filter((point): point is Point2 => point !== null);
    if (points.length === 0) return;
    const lowest = points.reduce((a, b) => (b[1] > a[1] ? b : a));
    const context = this.#context;
    context.globalAlpha = 1;
    context.font = `600 ${13 * unit}px system-ui, sans-serif`;
    context.textAlign = "center";
    context.textBaseline = "top";
    context.lineJoin = "round";
    context.lineWidth = 4 * unit;
    context.strokeStyle = kOutline;
    const name = handName(hand);
    context.strokeText(name, lowest[0], lowest[1] + 9 * unit);
    context.fillStyle = colour;
    context.fillText(name, lowest[0], lowest[1] + 9 * unit);
  }
}

/** "R 1": side and number of a hand. */
export function handName(hand: Hand): string {
  return `${hand.side === null ? "?" : hand.side === "right" ? "R" : "L"} ${hand.id}`;
}
