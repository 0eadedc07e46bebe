// SPDX-License-Identifier: Apache-2.0
// The frames as a film strip: those around the one that is shown, in time or the most doubtful first.
import { DepthRange } from "./depth_range.ts";
import { ImageView } from "./image_view.ts";
import { fetchThumbnail } from "./label_client.ts";
import { setText } from "./panel.ts";
import { FrameImages, type FrameMessage } from "./protocol.ts";
import type { Standings } from "./label_protocol.ts";

export type StripOrder = "time" | "doubt";

const kShown = 15;
const kMostKept = 400;  // thumbnails
const kNames: Record<string, string> = { "-": "no labels", e: "estimated", p: "propagated", c: "corrected", v: "verified" };

interface Tile {
  button: HTMLButtonElement;
  view: ImageView;
  canvas: HTMLCanvasElement;
  caption: HTMLElement;
  frame: number;
  drawn: number;
}

export class FilmStrip {
  order: StripOrder = "time";

  #root: HTMLElement;
  #palette: Uint8Array;
  #open: (frame: number) => void;
  #tiles: Tile[] = [];
  #kept = new Map<number, FrameMessage | null>();  // null: on its way
  #images = new FrameImages();

  constructor(root: HTMLElement, palette: Uint8Array, open: (frame: number) => void) {
    this.#root = root;
    this.#palette = palette;
    this.#open = open;
  }

  /** All frames in the strip's order. */
  sequence(count: number, standings: Standings | null): number[] {
    const frames = Array.from({ length: count }, (_, i) => i);
    if (this.order === "time" || !standings) return frames;
    const rank = (i: number): number => (standings.states[i] === "v" ? -1 : standings.states[i] === "-" ? 0 : standings.doubts[i] ?? 0);
    return frames.sort((a, b) => rank(b) - rank(a) || a - b);
  }

  /** The frame that comes `by` after another one in the strip's order; null at the ends. */
  beside(frame: number, by: number, count: number, standings: Standings | null): number | null {
    const sequence = this.sequence(count, standings);
    return sequence[sequence.indexOf(frame) + by] ?? null;
  }

  show(current: number, count: number, standings: Standings | null): void {
    const sequence = this.sequence(count, standings);
    const at = sequence.indexOf(current);
    const shown = Math.min(kShown, count);
    const first = Math.max(0, Math.min(at - (shown >> 1), count - shown));
    while (this.#tiles.length < shown) this.#tiles.push(this.#makeTile());
    this.#tiles.forEach((tile, i) => this.#fill(tile, sequence[first + i]!, current, standings));
  }

  #fill(tile: Tile, frame: number, current: number, standings: Standings | null): void {
    const letter = standings?.states[frame] ?? "-";
    const doubt = standings?.doubts[frame] ?? 0;
    tile.frame = frame;
    tile.button.dataset["state"] = letter;
    if (frame === current) tile.button.setAttribute("aria-current", "true");
    else tile.button.removeAttribute("aria-current");
    const said = letter === "v" || letter === "-" ? "" : `, doubt ${doubt.toFixed(1)} mm`;
    tile.button.setAttribute("aria-label", `Frame ${frame}: ${kNames[letter]}${said}`);
    tile.button.title = `Frame ${frame}: ${kNames[letter]}${said}`;
    setText(tile.caption, String(frame));
    const kept = this.#kept.get(frame);
    if (kept === undefined) void this.#fetch(frame);
    else if (kept && tile.drawn !== frame) this.#draw(tile, kept);
    else if (!kept && tile.drawn !== frame) tile.canvas.getContext("2d")!.clearRect(0, 0, tile.canvas.width, tile.canvas.height);
  }

  async #fetch(frame: number): Promise<void> {
    if (this.#kept.size >= kMostKept) this.#kept.delete(this.#kept.keys().next().value!);
    this.#kept.set(frame, null);
    try {
      const message = await fetchThumbnail(frame);
      this.#kept.set(frame, message);
      for (const tile of this.#tiles) if (tile.frame === frame) this.#draw(tile, message);
    } catch {
      this.#kept.delete(frame);  // it is asked for again when it is shown next
    }
  }

  #draw(tile: Tile, message: FrameMessage): void {
    this.#images.take(message);
    const range = new DepthRange();
    range.follow(this.#images.depth, message.header.depth_unit_mm);
    tile.canvas.width = message.header.width;
    tile.canvas.height = message.header.height;
    tile.view.colour(this.#images, message.header.depth_unit_mm, range);
    tile.view.draw(message.header, []);
    tile.drawn = message.header === undefined ? -1 : tile.frame;
  }

  #makeTile(): Tile {
    const item = document.createElement("li");
    const button = document.createElement("button");
    button.type = "button";
    button.className = "tile";
    const canvas = document.createElement("canvas");
    canvas.setAttribute("aria-hidden", "true");
    const caption = document.createElement("span");
    button.append(canvas, caption);
    item.append(button);
    this.#root.append(item);
    const tile: Tile = { button, canvas, caption, view: new ImageView(canvas, this.#palette), frame: -1, drawn: -1 };
    button.addEventListener("click", () => this.#open(tile.frame));
    return tile;
  }
}
