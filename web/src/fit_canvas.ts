// SPDX-License-Identifier: Apache-2.0
// A canvas has as many pixels as the screen shows of it.

/** Gives the canvas the size at which it is seen, which clears it where it had another one. Returns device pixels per CSS pixel, at most 2. */
export function fitCanvas(canvas: HTMLCanvasElement): number {
  const ratio = Math.min(window.devicePixelRatio, 2);
  const width = Math.max(1, Math.round(canvas.clientWidth * ratio));
  const height = Math.max(1, Math.round(canvas.clientHeight * ratio));
  if (canvas.width !== width || canvas.height !== height) {
    canvas.width = width;
    canvas.height = height;
  }
  return ratio;
}
