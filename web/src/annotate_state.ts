// SPDX-License-Identifier: Apache-2.0
// All that the page for labelling knows, and what follows from it; what is seen is drawn and said from here.
import type { HandLabels, Labelled, LabelInfo, Standings } from "./label_protocol.ts";
import { FrameImages, type FrameHeader, type Hand, type Point2, type Point3, type Side } from "./protocol.ts";
import type { Shown } from "./views.ts";

/** A pointer that is held down: it moves the landmark that is chosen, or the image. */
export interface Drag {
  view: "image" | "cloud";
  from: Point2;  // where it began [CSS px of the canvas]
  at: Point2;
  start: Point3 | null;  // of the landmark in the points [mm]
  hasMoved: boolean;
  pans: Point2 | null;  // the image's centre where it began; null: a landmark moves
}

export class AnnotateState implements Shown {
  readonly images = new FrameImages();
  info: LabelInfo | null = null;
  frame = 0;
  header: FrameHeader | null = null;
  labels: HandLabels[] = [];  // of the record's hands, in their order
  side: Side = "right";
  landmark = "wrist";
  standings: Standings | null = null;
  usesModel = true;
  isOpen = false;  // the line that tells of changes
  drag: Drag | null = null;
  fit_ms: number | null = null;  // of the last fit of the hand model
  imageChanged = false;  // to be drawn again, and what the page says with it
  cloudChanged = false;

  get bones(): readonly [string, string][] {
    return this.info?.bones ?? [];
  }

  /** The hand that is chosen; null where the frame has none of its side. */
  get hand(): Hand | null {
    return this.handOf(this.side);
  }

  handOf(side: Side): Hand | null {
    return this.header?.record.hands.find((hand) => hand.side === side) ?? null;
  }

  get handLabels(): HandLabels | null {
    return this.labels.find(({ side }) => side === this.side) ?? null;
  }

  /** Of the labels that a change is made on; 0: there are none yet. */
  get revision(): number {
    return this.handLabels?.revision ?? 0;
  }

  takeLabels({ record, surface, labels }: Labelled): void {
    if (!this.header) return;
    this.header.record = record;
    this.header.surface = surface;
    this.labels = labels;
  }

  choose(landmark: string): void {
    this.landmark = landmark;
    this.imageChanged = true;
  }

  /** The landmark that comes `by` after the one that is chosen, round and round. */
  chooseBeside(by: number): void {
    const names = this.info?.landmarks ?? [];
    this.choose(names[(names.indexOf(this.landmark) + by + names.length) % names.length] ?? this.landmark);
  }

  chooseSide(side: Side): void {
    this.side = side;
    this.imageChanged = true;
  }
}
