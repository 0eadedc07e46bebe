// SPDX-License-Identifier: Apache-2.0
// Colours of depth and of hands.
import type { Hand, Side } from "./protocol.ts";

export const kPaletteSize = 256;

/** Björn Ottosson's OKLCH (lightness 0 to 1, chroma, hue in degrees) as sRGB bytes. */
export function srgbOfOklch(lightness: number, chroma: number, hue_deg: number): [number, number, number] {
  const a = chroma * Math.cos((hue_deg * Math.PI) / 180);
  const b = chroma * Math.sin((hue_deg * Math.PI) / 180);
  const l = (lightness + 0.3963377774 * a + 0.2158037573 * b) ** 3;
  const m = (lightness - 0.1055613458 * a - 0.0638541728 * b) ** 3;
  const s = (lightness - 0.0894841775 * a - 1.291485548 * b) ** 3;
  return [
    srgbByte(4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s),
    srgbByte(-1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s),
    srgbByte(-0.0041960863 * l - 0.7034186147 * m + 1.707614701 * s),
  ];
}

function srgbByte(linear: number): number {
  const value = Math.min(1, Math.max(0, linear));
  return Math.round(255 * (value <= 0.0031308 ? 12.92 * value : 1.055 * value ** (1 / 2.4) - 0.055));
}

/** From near to far, RGBA bytes: lightness falls evenly, so that near and far are told apart without hue as well. */
export function depthPalette(): Uint8Array {
  const palette = new Uint8Array(4 * kPaletteSize);
  for (let i = 0; i < kPaletteSize; ++i) {
    const t = i / (kPaletteSize - 1);
    const [red, green, blue] = srgbOfOklch(0.9 - 0.62 * t, 0.075 + 0.015 * Math.cos(4 * Math.PI * t), 85 + 185 * t);
    palette.set([red, green, blue, 255], 4 * i);
  }
  return palette;
}

// Right hands are warm, left ones violet; more hands of one side differ in shade. None is a colour of depth.
const kHandColours: Record<Side | "unknown", string[]> = {
  right: ["#ff5a2e", "#ffb020", "#e0304e"],
  left: ["#c86bff", "#ff7ac8", "#8f7bff"],
  unknown: ["#f2f4f7", "#b9c2cc", "#8d99a6"],
};

/** A colour per hand, in the order of `hands`: by side, then by id. */
export function handColours(hands: Hand[]): string[] {
  return hands.map((hand) => {
    const shades = kHandColours[hand.side ?? "unknown"];
    const before = hands.filter((other) => other.side === hand.side && other.id < hand.id).length;
    return shades[before % shades.length]!;
  });
}

/** "#rrggbb" as three numbers from 0 to 1. */
export function rgbOf(colour: string): [number, number, number] {
  const bits = parseInt(colour.slice(1), 16);
  return [((bits >> 16) & 255) / 255, ((bits >> 8) & 255) / 255, (bits & 255) / 255];
}
