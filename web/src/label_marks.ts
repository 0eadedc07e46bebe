// SPDX-License-Identifier: Apache-2.0
// What labels look like over the image: a square around what a person answers for, a ring around what is chosen; hidden ones are crossed.
import type { ImageView } from "./image_view.ts";
import type { HandLabels } from "./label_protocol.ts";
import type { Hand, Side } from "./protocol.ts";

/** `hands` and `labels`: one another's, in order. */
export function drawLabelMarks(canvas: HTMLCanvasElement, view: ImageView, hands: Hand[], labels: HandLabels[], chosen: { side: Side; landmark: string }): void {
  const context = canvas.getContext("2d")!;
  const ratio = canvas.width / Math.max(1, canvas.clientWidth);
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  hands.forEach((hand, i) => {
    const ofHand = labels[i]!;
    for (const [name, label] of Object.entries(ofHand.landmarks)) {
      const at = hand.landmarks_px[name];
      if (!at || !label) continue;
      const [x, y] = view.canvasAt(at);
      const isChosen = ofHand.side === chosen.side && name === chosen.landmark;
      const marks: [number, string][] = [[4, "#0b0f13"], [2, isChosen ? "#ffffff" : label.state === "verified" ? "#58c98a" : "#f5c469"]];
      for (const [width, colour] of marks) {
        context.lineWidth = width;
        context.strokeStyle = colour;
        context.beginPath();
        if (label.state === "corrected" || label.state === "verified") context.rect(x - 7, y - 7, 14, 14);
        context.moveTo(x + 11, y);
        if (isChosen) context.arc(x, y, 11, 0, 2 * Math.PI);
        if (!label.visible) {
          context.moveTo(x - 5, y - 5);
          context.lineTo(x + 5, y + 5);
        }
        context.stroke();
      }
    }
  });
  context.setTransform(1, 0, 0, 1, 0, 0);
}
