// SPDX-License-Identifier: Apache-2.0
// A PNG of both views side by side, with a line that says what it shows.

const kGap = 8;
const kCaption = 28;

/** Puts canvases of one height side by side. They must have been drawn in this very task: WebGL keeps its picture no longer. */
export function composePicture(views: HTMLCanvasElement[], caption: string): HTMLCanvasElement {
  const height = Math.max(...views.map((view) => view.height));
  const picture = document.createElement("canvas");
  picture.width = views.reduce((sum, view) => sum + view.width + kGap, -kGap);
  picture.height = height + kCaption;
  const context = picture.getContext("2d")!;
  context.fillStyle = "#0b0f13";
  context.fillRect(0, 0, picture.width, picture.height);
  let left = 0;
  for (const view of views) {
    context.drawImage(view, left, (height - view.height) / 2);
    left += view.width + kGap;
  }
  context.fillStyle = "#c9d1d9";
  context.font = "13px system-ui, sans-serif";
  context.textBaseline = "middle";
  context.fillText(caption, 10, height + kCaption / 2, picture.width - 20);
  return picture;
}

/** Hands a picture to the browser as a download. */
export async function download(picture: HTMLCanvasElement, name: string): Promise<void> {
  const blob = await new Promise<Blob | null>((done) => picture.toBlob(done, "image/png"));
  if (!blob) throw new Error("this browser makes no PNG of a picture of this size");
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}
