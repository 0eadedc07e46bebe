// SPDX-License-Identifier: Apache-2.0
// Writes the files of fuzz/corpus/mcap with MCAP's own library, which mcap_test.cpp compares with, too.
//
//   node fuzz/write_mcaps.mjs FOLDER        (after scripts/fetch_web_packages.sh)
//
// Pixel (column, row) of image i is 600 + i + column + 3 row [mm]; every seventh is not measured.
import { mkdirSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join } from "node:path";

const require = createRequire(new URL("../web/package.json", import.meta.url));
const { McapWriter, TempBuffer } = require("@mcap/core");
const lz4 = require("lz4js");
const { ZstdCodec } = require("zstd-codec");

const WIDTH = 16;
const HEIGHT = 12;
const folder = process.argv[2];

/** Bytes of a message in CDR: little-endian, each number at a multiple of its size. */
class CdrWriter {
  #bytes = [0, 1, 0, 0];

  number(size, write) {
    while ((this.#bytes.length - 4) % size !== 0) this.#bytes.push(0);
    const view = new DataView(new ArrayBuffer(size));
    write(view);
    this.#bytes.push(...new Uint8Array(view.buffer));
    return this;
  }
  u8(value) {
    return this.number(1, (view) => view.setUint8(0, value));
  }
  u16(value) {
    return this.number(2, (view) => view.setUint16(0, value, true));
  }
  u32(value) {
    return this.number(4, (view) => view.setUint32(0, value, true));
  }
  f64(value) {
    return this.number(8, (view) => view.setFloat64(0, value, true));
  }
  text(value) {
    this.u32(value.length + 1);
    this.#bytes.push(...Buffer.from(value), 0);
    return this;
  }
  header(time) {
    return this.u32(Math.floor(time)).u32((time % 1) * 1e9).text("camera_depth_optical_frame");
  }
  bytes() {
    return Uint8Array.from(this.#bytes);
  }
}

function depthImage(number, time) {
  const message = new CdrWriter().header(time).u32(HEIGHT).u32(WIDTH).text("16UC1").u8(0).u32(2 * WIDTH);
  message.u32(2 * WIDTH * HEIGHT);
  for (let row = 0; row < HEIGHT; ++row) {
    for (let column = 0; column < WIDTH; ++column)
      message.u16((row + column) % 7 === 0 ? 0 : 600 + number + column + 3 * row);
  }
  return message.bytes();
}

function cameraInfo(time) {
  const message = new CdrWriter().header(time).u32(HEIGHT).u32(WIDTH).text("plumb_bob");
  const distortion = [0.1, -0.2, 0.001, 0.002, 0.03];
  message.u32(distortion.length);
  const k = [15.5, 0, 7.25, 0, 16.25, 5.75, 0, 0, 1];
  const r = [1, 0, 0, 0, 1, 0, 0, 0, 1];
  const p = [15.5, 0, 7.25, 0, 0, 16.25, 5.75, 0, 0, 0, 1, 0];
  for (const value of [...distortion, ...k, ...r, ...p]) message.f64(value);
  for (let i = 0; i < 6; ++i) message.u32(0); // binning, region of interest
  return message.u8(0).bytes();
}

async function writeMcap(name, options) {
  const file = new TempBuffer();
  const writer = new McapWriter({ writable: file, chunkSize: 1000, ...options });
  await writer.start({ profile: "ros2", library: "" });
  const channels = {};
  for (const [topic, type] of [["camera_info", "CameraInfo"], ["image_raw", "Image"]]) {
    const schemaId = await writer.registerSchema({ name: `sensor_msgs/msg/${type}`, encoding: "ros2msg", data: new Uint8Array() });
    channels[topic] = await writer.registerChannel({ schemaId, topic: `/camera/depth/${topic}`, messageEncoding: "cdr", metadata: new Map() });
  }
  for (let number = 0; number < 3; ++number) {
    const time = 1600000000.25 + number / 32;
    const logTime = BigInt(Math.round(time * 1e6)) * 1000n + 10_000_000n;
    for (const [topic, data] of [["camera_info", cameraInfo(time)], ["image_raw", depthImage(number, time)]])
      await writer.addMessage({ channelId: channels[topic], sequence: number, logTime, publishTime: logTime, data });
  }
  await writer.end();
  writeFileSync(join(folder, name), file.get());
}

const zstd = await new Promise((resolve) => ZstdCodec.run((codec) => resolve(new codec.Simple())));
const noSummary = {
  useStatistics: false, useSummaryOffsets: false, repeatSchemas: false, repeatChannels: false,
  useAttachmentIndex: false, useMetadataIndex: false, useChunkIndex: false,
};

mkdirSync(folder, { recursive: true });
await writeMcap("none", {});
await writeMcap("lz4", { compressChunk: (data) => ({ compression: "lz4", compressedData: lz4.compress(data) }) });
await writeMcap("zstd", { compressChunk: (data) => ({ compression: "zstd", compressedData: zstd.compress(data, 19) }) });
await writeMcap("no_indexes", { useMessageIndex: false });
await writeMcap("no_summary", { ...noSummary, useMessageIndex: false });
await writeMcap("no_chunks", { useChunks: false });
