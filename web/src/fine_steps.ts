// SPDX-License-Identifier: Apache-2.0
// Keys that move a landmark by little, unless the points have the focus: there they turn.
import type { Point3 } from "./protocol.ts";

export const kFine_px = 0.5;
export const kCoarse_px = 4;
export const kDepthStep_mm = 1;
const kCoarseDepth = 5;

const kSteps: Record<string, Point3> = {
  ArrowLeft: [-1, 0, 0], ArrowRight: [1, 0, 0], ArrowUp: [0, -1, 0], ArrowDown: [0, 1, 0], "+": [0, 0, 1], "=": [0, 0, 1], "-": [0, 0, -1],
  PageUp: [0, 0, 1], PageDown: [0, 0, -1],
};

/** `nudge` is told how far to move: to the right and down [px], away [mm]. */
export function listenToFineSteps(cloudCanvas: HTMLElement, areOn: () => boolean, nudge: (right: number, down: number, away_mm: number) => void): void {
  document.addEventListener("keydown", (event) => {
    const direction = kSteps[event.key];
    const target = event.target as HTMLElement;
    if (!direction || event.defaultPrevented || event.ctrlKey || event.metaKey || event.altKey || !areOn()) return;
    if (target === cloudCanvas || target instanceof HTMLInputElement || document.querySelector("dialog[open]")) return;
    event.preventDefault();
    const size = event.shiftKey ? kCoarse_px : kFine_px;
    nudge(direction[0] * size, direction[1] * size, direction[2] * (event.shiftKey ? kCoarseDepth : 1) * kDepthStep_mm);
  });
}
