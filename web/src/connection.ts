// SPDX-License-Identifier: Apache-2.0
// The line to the server: it is opened again whenever it is lost.
import { MessageError, readFrame, readInfo, readRecording, type FrameMessage, type Info, type Recording } from "./protocol.ts";

export type ConnectionState =
  | { is: "connecting" }
  | { is: "open" }
  | { is: "lost"; reason: string; retry_ms: number };  // when it is tried again, on the clock of performance.now()

export interface ConnectionEvents {
  state(state: ConnectionState): void;
  info(info: Info): void;
  frame(message: FrameMessage): void;
  malformed(reason: string): void;
}

const kFirstWait_ms = 500;
const kLongestWait_ms = 5000;

/** An address of the server, with the token that the page was opened with. */
export function apiAddress(path: string, page: Location = location): string {
  const address = new URL(path, page.href);
  const token = new URLSearchParams(page.search).get("token");
  if (token !== null) address.searchParams.set("token", token);
  return address.href;
}

export function socketAddress(path: string): string {
  return apiAddress(path).replace(/^http/, "ws");
}

export function plainRefusal(status: number): string {
  if (status === 401 || status === 403) return "the server refused this page; open it with the address that knuckle printed, with its token";
  if (status === 503) return "too many pages are open already";
  return `the server answered with status ${status}`;
}

export class Connection {
  #events: ConnectionEvents;
  #socket: WebSocket | null = null;
  #wait_ms = kFirstWait_ms;
  #timer = 0;

  constructor(events: ConnectionEvents) {
    this.#events = events;
  }

  async open(): Promise<void> {
    clearTimeout(this.#timer);
    this.#events.state({ is: "connecting" });
    try {
      const answer = await fetch(apiAddress("api/info"), { cache: "no-store", signal: AbortSignal.timeout(10_000) });
      if (!answer.ok) return this.#lose(plainRefusal(answer.status));
      this.#events.info(readInfo(await answer.json()));
    } catch (error) {
      return this.#lose(error instanceof MessageError ? `the server's answer cannot be read: ${error.message}` : "the server does not answer");
    }
    this.#listen();
  }

  /** Tries at once instead of waiting. */
  retry(): void {
    if (!this.#socket) void this.open();
  }

  #listen(): void {
    const socket = new WebSocket(socketAddress("api/frames"));
    this.#socket = socket;
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      this.#wait_ms = kFirstWait_ms;
      this.#events.state({ is: "open" });
    };
    socket.onmessage = (event) => this.#take(event.data);
    socket.onclose = () => {
      this.#socket = null;
      this.#lose("knuckle has ended, or the network is interrupted");
    };
  }

  #take(data: unknown): void {
    try {
      this.#events.frame(readFrame(data));
    } catch (error) {
      if (!(error instanceof MessageError)) throw error;
      this.#events.malformed(error.message);
    }
  }

  #lose(reason: string): void {
    this.#events.state({ is: "lost", reason, retry_ms: performance.now() + this.#wait_ms });
    this.#timer = window.setTimeout(() => void this.open(), this.#wait_ms);
    this.#wait_ms = Math.min(2 * this.#wait_ms, kLongestWait_ms);
  }
}

/** Starts or stops the recording; its state afterwards. Throws an Error with a plain sentence. */
export async function setRecording(on: boolean): Promise<Recording | null> {
  let status = 0;
  let said = "";
  try {
    const answer = await fetch(apiAddress("api/recording"), {
      method: "POST",
      headers: { "Content-Type": "application/json" },
      body: JSON.stringify({ on }),
      signal: AbortSignal.timeout(10_000),
    });
    status = answer.status;
    said = await answer.text();
  } catch {
    throw new Error("the server does not answer");
  }
  const body = jsonOf(said) as { error?: unknown; recording?: unknown } | null;
  if (typeof body?.error === "string") throw new Error(body.error);
  if (status !== 200) throw new Error(body === null && said.trim() !== "" ? said.trim().slice(0, 500) : plainRefusal(status));
  return readRecording(body?.recording ?? body);  // the answer is the state itself, or all of /api/info
}

function jsonOf(text: string): unknown {
  try {
    return JSON.parse(text);
  } catch {
    return null;
  }
}
