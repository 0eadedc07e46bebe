// SPDX-License-Identifier: Apache-2.0
// How the two views follow the hand that is labelled, and what is drawn over its image.
import type { AnnotateState } from "./annotate_state.ts";
import { aimAt } from "./image_aim.ts";
import { drawLabelMarks } from "./label_marks.ts";
import type { MaskTool } from "./mask_tool.ts";
import type { Point2 } from "./protocol.ts";
import { showRange } from "./view_controls.ts";
import type { Views } from "./views.ts";

const kRangeMargin_mm = 30;  // joints lie 10 to 20 mm below the skin; more, and fingers are hard to tell apart

/** Shows the hand large, or the whole image where there is none. */
export function aimImage(views: Views, state: AnnotateState): void {
  if (!state.header) return;
  const points = Object.values(state.hand?.landmarks_px ?? {}).filter((point): point is Point2 => point !== null);
  aimAt(views.image, points, state.header);
  state.imageChanged = true;
}

/** Colours tell the hand's own depths apart; without a hand, those of the image. */
export function followRange({ range }: Views, state: AnnotateState): void {
  if (!state.header || !range.isAutomatic) return;
  const depths = Object.values(state.hand?.landmarks_mm ?? {}).filter((point) => point !== null).map((point) => point[2]);
  if (depths.length > 2) {
    range.followPoints(depths, kRangeMargin_mm);
  } else {
    range.setAutomatic(true);
    range.follow(state.images.depth, state.header.depth_unit_mm);
  }
  showRange(range);
}

/** Draws masks and marks over the image, after it. */
export function drawLabels(views: Views, state: AnnotateState, mask: MaskTool): void {
  if (!state.header) return;
  mask.draw(views.imageCanvas, views.image, state.labels, state.side);
  if (views.image.showsSkeleton) drawLabelMarks(views.imageCanvas, views.image, state.header.record.hands, state.labels, state);
}
