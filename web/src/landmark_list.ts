// SPDX-License-Identifier: Apache-2.0
// The landmarks of a hand as a list of buttons: how each stands, and which is chosen.
import type { HandLabels } from "./label_protocol.ts";

export function inWords(landmark: string): string {
  return landmark.replaceAll("_", " ");
}

export class LandmarkList {
  #buttons = new Map<string, HTMLButtonElement>();
  #root: HTMLElement;
  #choose: (landmark: string) => void;

  constructor(root: HTMLElement, choose: (landmark: string) => void) {
    this.#root = root;
    this.#choose = choose;
  }

  make(names: string[]): void {
    for (const name of names) {
      const item = document.createElement("li");
      const button = document.createElement("button");
      button.type = "button";
      const mark = document.createElement("span");
      mark.className = "mark";
      mark.setAttribute("aria-hidden", "true");
      const caption = document.createElement("span");
      caption.textContent = inWords(name);
      button.append(mark, caption);
      button.addEventListener("click", () => this.#choose(name));
      item.append(button);
      this.#root.append(item);
      this.#buttons.set(name, button);
    }
  }

  /** `labels`: null where the hand has none. */
  show(labels: HandLabels | null, chosen: string): void {
    for (const [name, button] of this.#buttons) {
      const label = labels?.landmarks[name] ?? null;
      button.setAttribute("aria-pressed", String(name === chosen));
      button.dataset["state"] = label?.state ?? "none";
      button.dataset["hidden"] = String(label !== null && !label.visible);
      button.title = label ? `${inWords(name)}: ${label.state}, ${label.visible ? "visible" : "hidden"}` : `${inWords(name)}: not labelled`;
    }
  }
}
