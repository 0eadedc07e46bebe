// SPDX-License-Identifier: Apache-2.0
// Reads the PNG files that browsers write: 8 bits, grey, RGB or RGBA, not interlaced; and of masks.
import { inflateSync } from "node:zlib";

/** Width, height and RGBA bytes of a PNG file. Throws where it is none of the expected kind. */
export function decodePng(file) {
  if (file.readUInt32BE(0) !== 0x89504e47) throw new Error("not a PNG file");
  const parts = [];
  let header = null;
  for (let at = 8; at < file.length;) {
    const length = file.readUInt32BE(at);
    const kind = file.toString("latin1", at + 4, at + 8);
    const body = file.subarray(at + 8, at + 8 + length);
    if (kind === "IHDR") header = { width: body.readUInt32BE(0), height: body.readUInt32BE(4), bits: body[8], colour: body[9], interlaced: body[12] };
    if (kind === "IDAT") parts.push(body);
    at += 12 + length;
  }
  if (header.bits !== 8 || ![0, 2, 6].includes(header.colour) || header.interlaced) throw new Error("a PNG of another kind");
  return { width: header.width, height: header.height, pixels: unfilter(inflateSync(Buffer.concat(parts)), header) };
}

function unfilter(data, { width, height, colour }) {
  const channels = colour === 6 ? 4 : colour === 2 ? 3 : 1;
  const stride = width * channels;
  const rows = Buffer.alloc(stride * height);
  const pixels = new Uint8Array(4 * width * height).fill(255);
  for (let row = 0; row < height; ++row) {
    const filter = data[row * (stride + 1)];
    for (let i = 0; i < stride; ++i) {
      const left = i >= channels ? rows[row * stride + i - channels] : 0;
      const up = row > 0 ? rows[(row - 1) * stride + i] : 0;
      const corner = row > 0 && i >= channels ? rows[(row - 1) * stride + i - channels] : 0;
      const predicted = [0, left, up, (left + up) >> 1, paeth(left, up, corner)][filter];
      rows[row * stride + i] = data[row * (stride + 1) + 1 + i] + predicted;
    }
    for (let column = 0; column < width; ++column) {
      for (let k = 0; k < Math.max(3, channels); ++k) pixels[4 * (row * width + column) + k] = rows[row * stride + column * channels + Math.min(k, channels - 1)];
    }
  }
  return pixels;
}

function paeth(left, up, corner) {
  const guess = left + up - corner;
  const [a, b, c] = [Math.abs(guess - left), Math.abs(guess - up), Math.abs(guess - corner)];
  return a <= b && a <= c ? left : b <= c ? up : corner;
}

/** Red, green and blue at a column and row. */
export function colourAt(picture, column, row) {
  const i = 4 * (Math.floor(row) * picture.width + Math.floor(column));
  return [...picture.pixels.subarray(i, i + 3)];
}

/** Whether two colours differ by no more than `most` in any channel. */
export function isLike(colour, wanted, most = 24) {
  return colour.every((value, i) => Math.abs(value - wanted[i]) <= most);
}

/** Number of the pixels that are like a colour, and their mean column and row (centres of pixels at .5). */
export function findColour(picture, wanted, most = 24) {
  return middleOf(picture, (colour) => isLike(colour, wanted, most));
}

/** Number of the pixels whose colour is taken, and their mean column and row (centres of pixels at .5). */
export function middleOf(picture, isTaken) {
  let [count, columns, rows] = [0, 0, 0];
  for (let row = 0; row < picture.height; ++row) {
    for (let column = 0; column < picture.width; ++column) {
      if (!isTaken(colourAt(picture, column, row))) continue;
      ++count;
      columns += column + 0.5;
      rows += row + 0.5;
    }
  }
  return { count, column: columns / count, row: rows / count };
}
