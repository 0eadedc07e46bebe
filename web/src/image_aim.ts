// SPDX-License-Identifier: Apache-2.0
// What part of the image is shown: a hand large, or what the wheel points at.
import type { ImageView } from "./image_view.ts";
import type { Point2 } from "./protocol.ts";

const kMostZoom = 16;

interface Size {
  width: number;
  height: number;
}

/** Shows the points large, or the whole image where there are hardly any. */
export function aimAt(view: ImageView, points: Point2[], image: Size): void {
  view.zoom = 1;
  view.centre = null;
  if (points.length < 3) return;
  const [us, vs] = [points.map((point) => point[0]), points.map((point) => point[1])];
  const [left, right, top, bottom] = [Math.min(...us), Math.max(...us), Math.min(...vs), Math.max(...vs)];
  view.centre = [(left + right) / 2, (top + bottom) / 2];
  view.zoom = Math.min(kMostZoom, Math.max(1, Math.min(image.width / (1.35 * (right - left + 8)), image.height / (1.35 * (bottom - top + 8)))));
}

/** Zooms so that what is seen at a place of the canvas stays there. */
export function zoomAt(view: ImageView, factor: number, x: number, y: number, image: Size): void {
  const before = view.placeAt(x, y);
  view.centre ??= middleOf(image);
  view.zoom = Math.min(kMostZoom, Math.max(1, view.zoom * factor));
  const after = view.placeAt(x, y);
  view.centre = view.zoom === 1 ? null : [view.centre[0] + before[0] - after[0], view.centre[1] + before[1] - after[1]];
}

export function middleOf(image: Size): Point2 {
  return [(image.width - 1) / 2, (image.height - 1) / 2];
}
