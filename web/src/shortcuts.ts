// SPDX-License-Identifier: Apache-2.0
// What keys do. The help page is made of the same list.

export interface Shortcut {
  keys: string[];  // as KeyboardEvent.key says them
  shown: string;  // as the help page shows them
  does: string;
  act: () => void;
  repeats?: boolean;  // while the key is held
}

/** Calls the action of the key that is pressed, unless one writes into a field or `areOn` says no. */
export function listenToKeys(shortcuts: Shortcut[], areOn: () => boolean): void {
  document.addEventListener("keydown", (event) => {
    if (event.defaultPrevented || event.ctrlKey || event.metaKey || event.altKey) return;
    const target = event.target as HTMLElement;
    if (isWrittenInto(target) || document.querySelector("dialog[open]")) return;
    if (event.key === " " && target.closest("button, summary, select, input")) return;  // it presses them
    const shortcut = shortcuts.find(({ keys }) => keys.includes(event.key));
    if (!shortcut || (!areOn() && event.key !== "?")) return;
    event.preventDefault();
    if (!event.repeat || shortcut.repeats) shortcut.act();
  });
}

function isWrittenInto(target: HTMLElement): boolean {
  return target.isContentEditable || target instanceof HTMLSelectElement || target instanceof HTMLTextAreaElement ||
    (target instanceof HTMLInputElement && target.type !== "checkbox");
}

/** Keys that turn, zoom and move the view that has the focus. */
export interface Turning {
  turn(left_deg: number, up_deg: number): void;
  pan(right: number, down: number): void;
  zoom(factor: number): void;
}

export const kTurn_deg = 5;
export const kPan_px = 24;
export const kZoom = 1.15;

export function listenToTurningKeys(canvas: HTMLElement, view: () => Turning | null): void {
  const directions: Record<string, [number, number]> = { ArrowLeft: [1, 0], ArrowRight: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
  canvas.addEventListener("keydown", (event) => {
    const turning = view();
    if (!turning || event.ctrlKey || event.metaKey || event.altKey) return;
    const direction = directions[event.key];
    if (direction && event.shiftKey) turning.pan(kPan_px * direction[0], kPan_px * direction[1]);
    else if (direction) turning.turn(kTurn_deg * direction[0], kTurn_deg * direction[1]);
    else if (event.key === "+" || event.key === "=") turning.zoom(kZoom);
    else if (event.key === "-") turning.zoom(1 / kZoom);
    else return;
    event.preventDefault();
  });
}

/** Fills the table of the help page. */
export function listShortcuts(table: HTMLElement, rows: { shown: string; does: string }[]): void {
  for (const { shown, does } of rows) {
    const row = document.createElement("tr");
    const keys = document.createElement("th");
    keys.scope = "row";
    for (const key of shown.split(" ")) {
      const cap = document.createElement("kbd");
      cap.textContent = key;
      keys.append(cap, " ");
    }
    const meaning = document.createElement("td");
    meaning.textContent = does;
    row.append(keys, meaning);
    table.append(row);
  }
}
