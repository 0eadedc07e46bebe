// SPDX-License-Identifier: Apache-2.0
// How a hand is drawn, the same in both views.
import type { Hand } from "./protocol.ts";

/** How sure a landmark is, 0 to 1. Where the method says nothing of it, the hand's score stands in; then 1. */
export function confidenceOf(hand: Hand, landmark: string): number {
  const value = hand.confidence[landmark] ?? hand.score ?? 1;
  return Math.min(1, Math.max(0, value));
}

/** Unsure landmarks are fainter, never invisible. */
export function opacityOf(confidence: number): number {
  return 0.3 + 0.7 * confidence;
}

/** Unsure landmarks are smaller: a factor of the full size. */
export function sizeOf(confidence: number): number {
  return 0.55 + 0.45 * confidence;
}

/** Mean confidence of the landmarks that were found; null where the method gives none. */
export function meanConfidence(hand: Hand): number | null {
  const values = Object.values(hand.confidence).filter((value): value is number => value !== null);
  return values.length === 0 ? null : values.reduce((sum, value) => sum + value, 0) / values.length;
}
