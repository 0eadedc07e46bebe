// SPDX-License-Identifier: Apache-2.0
// A server that speaks as `knuckle live --view` does, and sends what a test hands it. For tests alone.
import { createHash } from "node:crypto";
import { readFile } from "node:fs/promises";
import { createServer } from "node:http";
import { dirname, extname, join } from "node:path";
import { fileURLToPath } from "node:url";

const pageFolder = join(dirname(fileURLToPath(import.meta.url)), "..", "dist");
const types = { ".html": "text/html; charset=utf-8", ".js": "text/javascript", ".css": "text/css", ".svg": "image/svg+xml" };

// What the server of knuckle allows a page (src/knuckle/view).
const rules = "default-src 'self'; object-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'none';";

/** A message of /api/frames: header (its `record` and all else), depth, and infrared where there is one. */
export function encodeFrame(header, depth, infrared = null, padding = 0) {
  const text = Buffer.from(JSON.stringify(header) + " ".repeat(padding));
  const length = Buffer.alloc(4);
  length.writeUInt32LE(text.length);
  const pixels = [depth, infrared].filter(Boolean).map((image) => Buffer.from(image.buffer, image.byteOffset, image.byteLength));
  return Buffer.concat([length, text, ...pixels]);
}

/** A WebSocket frame, whole and unmasked, as servers send them (RFC 6455). */
function webSocketFrame(opcode, payload) {
  const head = payload.length < 126 ? Buffer.alloc(2) : payload.length < 65536 ? Buffer.alloc(4) : Buffer.alloc(10);
  head[0] = 0x80 | opcode;
  if (head.length === 2) head[1] = payload.length;
  else if (head.length === 4) { head[1] = 126; head.writeUInt16BE(payload.length, 2); }
  else { head[1] = 127; head.writeBigUInt64BE(BigInt(payload.length), 2); }
  return Buffer.concat([head, payload]);
}

export class MockServer {
  requests = [];  // "GET /api/info?token=..."
  posted = [];  // bodies of POST /api/recording
  recording = { file: null, frames: 0, dropped: 0 };
  recordingFault = null;  // what POST /api/recording answers instead
  refusesInfo = 0;  // the status of /api/info, where it is not to succeed
  #server;
  #sockets = new Set();
  #viewers = new Set();
  #waiting = [];
  #port = 0;

  constructor(info) {
    this.info = info;
  }

  async start() {
    this.#server = createServer((request, answer) => this.#answer(request, answer));
    this.#server.on("connection", (socket) => {
      this.#sockets.add(socket);
      socket.on("close", () => this.#sockets.delete(socket));
    });
    this.#server.on("upgrade", (request, socket) => this.#upgrade(request, socket));
    await new Promise((done) => this.#server.listen(this.#port, "127.0.0.1", done));
    this.#port = this.#server.address().port;
  }

  get address() {
    return `http://127.0.0.1:${this.#port}/`;
  }

  /** Ends all connections and listens no more; `start` begins again at the same port. */
  async stop() {
    this.#viewers.clear();
    for (const socket of this.#sockets) socket.destroy();
    await new Promise((done) => this.#server.close(done));
  }

  /** Resolves once a page listens to frames. */
  viewer() {
    return this.#viewers.size > 0 ? Promise.resolve() : new Promise((done) => this.#waiting.push(done));
  }

  /** Sends bytes as a binary message to all pages. */
  send(message) {
    for (const socket of this.#viewers) socket.write(webSocketFrame(2, message));
  }

  sendText(text) {
    for (const socket of this.#viewers) socket.write(webSocketFrame(1, Buffer.from(text)));
  }

  /** Bytes that wait to be taken by the slowest page. */
  backlog() {
    return Math.max(0, ...[...this.#viewers].map((socket) => socket.writableLength));
  }

  async #answer(request, answer) {
    this.requests.push(`${request.method} ${request.url}`);
    const { pathname } = new URL(request.url, "http://localhost");
    answer.setHeader("Content-Security-Policy", rules + ` connect-src 'self' ws://${request.headers.host}`);
    answer.setHeader("Cache-Control", "no-store");
    const json = (status, value) => answer.writeHead(status, { "Content-Type": "application/json" }).end(JSON.stringify(value));
    if (pathname === "/api/info") return this.refusesInfo ? json(this.refusesInfo, { error: "refused" }) : json(200, this.info);
    if (pathname === "/api/recording" && request.method === "POST") return this.#record(request, json);
    const file = pathname === "/" ? "index.html" : pathname.slice(1);
    try {
      if (!/^[a-z_]+\.[a-z]+$/.test(file)) throw new Error("not a file of the page");
      const bytes = await readFile(join(pageFolder, file));
      answer.writeHead(200, { "Content-Type": types[extname(file)] }).end(bytes);
    } catch {
      json(404, { error: "there is no such page" });
    }
  }

  async #record(request, json) {
    let body = "";
    for await (const part of request) body += part;
    this.posted.push(JSON.parse(body));
    if (this.recordingFault) return json(409, { error: this.recordingFault });
    const { on } = JSON.parse(body);
    this.recording = { file: on ? "hand.h5" : null, frames: on ? 0 : this.recording.frames, dropped: this.recording.dropped };
    json(200, this.recording);
  }

  #upgrade(request, socket) {
    this.requests.push(`${request.method} ${request.url}`);
    const accept = createHash("sha1").update(request.headers["sec-websocket-key"] + "258EAFA5-E914-47DA-95CA-C5AB0DC85B11").digest("base64");
    socket.write(`HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Accept: ${accept}\r\n\r\n`);
    socket.on("error", () => {});
    socket.on("data", (data) => { if ((data[0] & 15) === 8) socket.end(webSocketFrame(8, Buffer.alloc(0))); });
    socket.on("close", () => this.#viewers.delete(socket));
    this.#viewers.add(socket);
    for (const done of this.#waiting.splice(0)) done();
  }
}
