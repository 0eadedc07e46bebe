// SPDX-License-Identifier: Apache-2.0
// The controls of the image and the points that both pages have, and their keys.
import type { Viewpoint } from "./cloud_view.ts";
import type { DepthRange } from "./depth_range.ts";
import type { ImageKind } from "./image_view.ts";
import { choiceOf, onChange, onClick, press } from "./page_controls.ts";
import { element, setText } from "./panel.ts";
import type { Shortcut } from "./shortcuts.ts";
import type { Views } from "./views.ts";

/** What pages do in their own ways. */
export interface ViewActions {
  /** Sets a range that is automatic, to what is shown. */
  followRange: () => void;
  /** Aims at the hands. */
  aim: () => void;
}

export function listenToViewControls(views: Views, { followRange, aim }: ViewActions): void {
  onChange("image-kind", (box) => chooseImage(views, box.value as ImageKind));
  onChange("show-skeleton", (box) => views.setSkeleton(box.checked));
  onChange("show-cloud", (box) => views.setInSpace("showsCloud", box.checked));
  onChange("show-surface", (box) => views.setInSpace("showsSurface", box.checked));
  for (const id of ["range-auto", "range-near", "range-far"]) {
    onChange(id, () => {
      setRange(views.range);
      followRange();
      views.redraw();
    });
  }
  for (const button of document.querySelectorAll<HTMLButtonElement>("[data-look]")) {
    button.addEventListener("click", () => views.cloud?.look(button.dataset["look"] as Viewpoint));
  }
  onClick("reset", aim);
  const resizes = new ResizeObserver(() => views.redraw());
  for (const screen of document.querySelectorAll(".screen")) resizes.observe(screen);
}

function setRange(range: DepthRange): void {
  const near = element<HTMLInputElement>("range-near");
  const far = element<HTMLInputElement>("range-far");
  const isAutomatic = element<HTMLInputElement>("range-auto").checked;
  near.disabled = far.disabled = isAutomatic;
  range.setAutomatic(isAutomatic);
  const isPossible = isAutomatic || range.fix(near.valueAsNumber, far.valueAsNumber);
  for (const field of [near, far]) field.setAttribute("aria-invalid", String(!isPossible));
}

/** Writes an automatic range into its fields; one that is set stands there already. */
export function showRange(range: DepthRange): void {
  if (!range.isAutomatic) return;
  element<HTMLInputElement>("range-near").value = String(Math.round(range.near_mm));
  element<HTMLInputElement>("range-far").value = String(Math.round(range.far_mm));
}

function chooseImage(views: Views, kind: ImageKind): void {
  const choice = choiceOf("image-kind", kind);
  if (choice.disabled && kind !== "depth") return;
  choice.checked = true;
  views.setKind(kind);
}

/** Without infrared, depth is shown. */
export function allowInfrared(views: Views, isThere: boolean): void {
  choiceOf("image-kind", "infrared").disabled = !isThere;
  if (!isThere && views.image.kind === "infrared") chooseImage(views, "depth");
}

/** Says the distance under the pointer. */
export function showProbe(views: Views, event: PointerEvent): void {
  const probe = element("probe");
  const said = views.describePixel(event.offsetX, event.offsetY);
  probe.hidden = said === null;
  if (said !== null) setText(probe, said);
}

export function showingShortcuts(views: Views): Shortcut[] {
  return [
    { keys: ["i", "I"], shown: "I", does: "depth, infrared", act: () => chooseImage(views, views.image.kind === "depth" ? "infrared" : "depth") },
    { keys: ["k", "K"], shown: "K", does: "skeleton on and off", act: () => press("show-skeleton") },
    { keys: ["p", "P"], shown: "P", does: "points on and off", act: () => press("show-cloud") },
    { keys: ["f", "F"], shown: "F", does: "fitted surface on and off", act: () => press("show-surface") },
  ];
}

export function lookingShortcuts(views: Views): Shortcut[] {
  return [
    { keys: ["1"], shown: "1", does: "look from the camera", act: () => views.cloud?.look("front") },
    { keys: ["2"], shown: "2", does: "look from the side", act: () => views.cloud?.look("side") },
    { keys: ["3"], shown: "3", does: "look from above", act: () => views.cloud?.look("top") },
  ];
}
