// SPDX-License-Identifier: Apache-2.0
// What every page has beside its subject: the theme, the list of keys, and whether keys act; and how controls are listened to.
import { element, setText } from "./panel.ts";
import type { Shortcut } from "./shortcuts.ts";
import { currentTheme, nextTheme, remember, remembered, restoreTheme } from "./theme.ts";

export function onClick(id: string, act: () => void): void {
  element(id).addEventListener("click", act);
}

/** `act` gets the box, or the one of a group, that was changed. */
export function onChange(id: string, act: (box: HTMLInputElement) => void): void {
  element(id).addEventListener("change", (event) => act(event.target as HTMLInputElement));
}

/** Clicks, as the pointer would: what is disabled stays as it is. */
export function press(id: string): void {
  const control = element<HTMLButtonElement | HTMLInputElement>(id);
  if (!control.disabled) control.click();
}

/** Chooses one of a group of radio buttons, without an event. */
export function checkChoice(group: string, value: string): void {
  choiceOf(group, value).checked = true;
}

export function choiceOf(group: string, value: string): HTMLInputElement {
  return document.querySelector<HTMLInputElement>(`#${group} [value=${value}]`)!;
}

/** The theme as it was left, its button, and the button of the list of keys. */
export function listenToPageControls(): void {
  restoreTheme();
  showTheme();
  onClick("theme", () => {
    nextTheme();
    showTheme();
  });
  onClick("help", () => element<HTMLDialogElement>("help-dialog").showModal());
}

function showTheme(): void {
  setText(element("theme-label"), `Theme: ${currentTheme()}`);
}

/** The box that lets keys act on the whole page, as it was left. Returns what says whether they do. */
export function listenToKeySwitch(): () => boolean {
  const kKey = "knuckle.keys";
  const box = element<HTMLInputElement>("keys-on");
  box.checked = remembered(kKey) !== "off";
  box.addEventListener("change", () => remember(kKey, box.checked ? "on" : "off"));
  return () => box.checked;
}

export function pageShortcuts(): Shortcut[] {
  return [
    { keys: ["t", "T"], shown: "T", does: "theme: as the system, light, dark", act: () => press("theme") },
    { keys: ["?"], shown: "?", does: "this list", act: () => press("help") },
  ];
}
