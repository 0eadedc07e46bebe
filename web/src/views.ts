// SPDX-License-Identifier: Apache-2.0
// The image and the points of the frame that a page shows: opened, drawn when they have changed, and how they are to look.
import { CloudView } from "./cloud_view.ts";
import { DepthRange } from "./depth_range.ts";
import { fitCanvas } from "./fit_canvas.ts";
import { ImageView, type ImageKind } from "./image_view.ts";
import { element, setText } from "./panel.ts";
import type { FrameHeader, FrameImages } from "./protocol.ts";

/** The frame that is shown, and what of it has to be drawn again: part of a page's state. */
export interface Shown {
  readonly images: FrameImages;
  readonly bones: readonly [string, string][];
  header: FrameHeader | null;  // null: nothing is shown yet
  imageChanged: boolean;
  cloudChanged: boolean;
}

export class Views {
  readonly range = new DepthRange();
  readonly imageCanvas = element<HTMLCanvasElement>("image");
  readonly cloudCanvas = element<HTMLCanvasElement>("cloud");
  readonly image: ImageView;
  readonly cloud: CloudView | null;  // null: the browser has no WebGL 2, and the page says so

  #shown: Shown;

  constructor(shown: Shown, palette: Uint8Array) {
    this.#shown = shown;
    this.image = new ImageView(this.imageCanvas, palette);
    this.cloud = this.#openCloud(palette);
  }

  /** Says in place of the points why there are none. */
  missCloud(text: string): void {
    const placard = element("cloud-missing");
    setText(placard, text);
    placard.hidden = false;
  }

  /** Takes the frame that is shown now, or what is known of it now. */
  take(): void {
    const { images, header, bones } = this.#shown;
    if (header) this.cloud?.take(images, header, bones);
    this.redraw();
  }

  redraw(): void {
    this.#shown.imageChanged = this.#shown.cloudChanged = true;
  }

  /** Draws what has changed. True where that was the image. */
  draw(): boolean {
    const { imageChanged, cloudChanged } = this.#shown;
    if (imageChanged) this.drawImage();
    if (cloudChanged) this.drawCloud();
    this.#shown.imageChanged = this.#shown.cloudChanged = false;
    return imageChanged;
  }

  drawImage(): void {
    const { images, header, bones } = this.#shown;
    if (!header) return;
    this.image.colour(images, header.depth_unit_mm, this.range);
    fitCanvas(this.imageCanvas);
    this.image.draw(header, bones);
  }

  drawCloud(): void {
    if (this.#shown.header) this.cloud?.draw(this.range);
  }

  /** Aims the points at the hands. */
  aimCloud(): void {
    this.cloud?.reset(this.#shown.header, this.#shown.images);
  }

  /** The canvas' name, for a screen reader, begins with the kind that it shows. */
  setKind(kind: ImageKind): void {
    this.image.kind = kind;
    const name = this.imageCanvas.getAttribute("aria-label") ?? "";
    this.imageCanvas.setAttribute("aria-label", name.replace(/^\w+/, kind === "depth" ? "Depth" : "Infrared"));
    this.#shown.imageChanged = true;
  }

  setSkeleton(isShown: boolean): void {
    this.image.showsSkeleton = isShown;
    if (this.cloud) this.cloud.showsSkeleton = isShown;
    this.redraw();
  }

  setInSpace(what: "showsCloud" | "showsSurface" | "isCut", isOn: boolean): void {
    if (!this.cloud) return;
    this.cloud[what] = isOn;
    this.#shown.cloudChanged = true;
  }

  /** Pixel and distance under a point of the image's canvas [CSS px], in words; null outside of the image. */
  describePixel(x: number, y: number): string | null {
    const { images, header } = this.#shown;
    const pixel = header && this.image.pixelAt(x, y);
    if (!pixel) return null;
    const count = images.depth[pixel[1] * images.width + pixel[0]]!;
    return `${pixel[0]}, ${pixel[1]}: ${count === 0 ? "not measured" : `${Math.round(count * header.depth_unit_mm)} mm`}`;
  }

  #openCloud(palette: Uint8Array): CloudView | null {
    try {
      return new CloudView(this.cloudCanvas, palette, () => { this.#shown.cloudChanged = true; });
    } catch {
      this.cloudCanvas.hidden = true;
      this.missCloud("This browser has no WebGL 2, so points in space cannot be drawn. The image works without it.");
      return null;
    }
  }
}
