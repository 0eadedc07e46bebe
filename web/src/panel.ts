// SPDX-License-Identifier: Apache-2.0
// The texts of the page: hands, numbers, notices. All text goes in as text, never as markup.
import { handColours } from "./palette.ts";
import type { Hand } from "./protocol.ts";
import { meanConfidence } from "./skeleton.ts";

export function element<T extends HTMLElement = HTMLElement>(id: string): T {
  const found = document.getElementById(id);
  if (!found) throw new Error(`the page has no #${id}`);
  return found as T;
}

/** Sets a text only where it changes: less to lay out, and nothing for a screen reader to repeat. */
export function setText(target: HTMLElement, text: string): void {
  if (target.textContent !== text) target.textContent = text;
}

export function percent(share: number | null): string {
  return share === null ? "–" : `${Math.round(100 * Math.min(1, Math.max(0, share)))} %`;
}

/** "1 hand: right", "2 hands: right, left", or why there is none. */
export function describeHands(hands: Hand[], status: string): string {
  if (hands.length === 0) return status || "no hand";
  const sides = hands.map((hand) => hand.side ?? "side unknown").join(", ");
  const said = `${hands.length} ${hands.length === 1 ? "hand" : "hands"}: ${sides}`;
  return status ? `${said} (${status})` : said;
}

interface Card {
  root: HTMLElement;
  swatch: HTMLElement;
  name: HTMLElement;
  score: HTMLElement;
  confidence: HTMLElement;
  meter: HTMLElement;
}

/** The legend of hands: colour, side, number, score and confidence of each. Cards are kept from frame to frame. */
export class HandList {
  #list: HTMLElement;
  #empty: HTMLElement;
  #cards: Card[] = [];

  constructor(list: HTMLElement, empty: HTMLElement) {
    this.#list = list;
    this.#empty = empty;
  }

  show(hands: Hand[], status: string): void {
    const colours = handColours(hands);
    while (this.#cards.length < hands.length) this.#cards.push(this.#makeCard());
    this.#cards.forEach((card, i) => {
      const hand = hands[i];
      card.root.hidden = !hand;
      if (hand) fillCard(card, hand, colours[i]!);
    });
    this.#empty.hidden = hands.length > 0;
    if (hands.length === 0) setText(this.#empty, status || "No hand.");
  }

  #makeCard(): Card {
    const part = (tag: string, name: string): HTMLElement => {
      const made = document.createElement(tag);
      made.className = name;
      return made;
    };
    const card: Card = {
      root: part("li", "hand"), swatch: part("span", "swatch"), name: part("strong", "hand-name"),
      score: part("span", "hand-number"), confidence: part("span", "hand-number"), meter: part("span", "meter"),
    };
    card.swatch.setAttribute("aria-hidden", "true");
    const bar = part("span", "meter-track");
    bar.setAttribute("aria-hidden", "true");
    bar.append(card.meter);
    card.root.append(card.swatch, card.name, card.score, card.confidence, bar);
    this.#list.append(card.root);
    return card;
  }
}

function fillCard(card: Card, hand: Hand, colour: string): void {
  const confidence = meanConfidence(hand);
  const shown = confidence ?? hand.score ?? 0;
  card.swatch.style.backgroundColor = colour;
  card.swatch.dataset["side"] = hand.side ?? "unknown";
  card.meter.style.backgroundColor = colour;
  card.meter.style.transform = `scaleX(${Math.min(1, Math.max(0, shown)).toFixed(3)})`;
  const side = hand.side === null ? "Hand" : hand.side === "right" ? "Right" : "Left";
  setText(card.name, `${side} ${hand.id}`);
  setText(card.score, `score ${percent(hand.score)}`);
  setText(card.confidence, confidence === null ? "" : `confidence ${percent(confidence)}`);
}

export type NoticeKind = "connection" | "disk" | "remark" | "frames" | "malformed" | "recording" | "webgl";

/** What is wrong at the moment, one line each. */
export class Notices {
  #root: HTMLElement;
  #texts = new Map<NoticeKind, string>();

  constructor(root: HTMLElement) {
    this.#root = root;
  }

  set(kind: NoticeKind, text: string | null): void {
    if ((this.#texts.get(kind) ?? null) === text) return;
    if (text === null) this.#texts.delete(kind);
    else this.#texts.set(kind, text);
    this.#render();
  }

  #render(): void {
    this.#root.replaceChildren(...[...this.#texts].map(([kind, text]) => {
      const line = document.createElement("p");
      line.className = "notice";
      line.dataset["kind"] = kind;
      line.textContent = text;
      return line;
    }));
    this.#root.hidden = this.#texts.size === 0;
  }
}

/** Tells a screen reader what has changed, once it has stayed so for a while. */
export class Announcer {
  #region: HTMLElement;
  #wanted = "";
  #since_ms = 0;

  constructor(region: HTMLElement) {
    this.#region = region;
  }

  update(text: string, now_ms: number): void {
    if (text !== this.#wanted) {
      this.#wanted = text;
      this.#since_ms = now_ms;
    } else if (now_ms - this.#since_ms >= 1000) {
      setText(this.#region, text);
    }
  }
}
