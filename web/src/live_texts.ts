// SPDX-License-Identifier: Apache-2.0
// What the live page says of the frame that is shown, of the stream, and of the line to the server.
import type { LiveState } from "./live_state.ts";
import { Announcer, describeHands, element, HandList, setText, type Notices } from "./panel.ts";
import type { RangeScale } from "./range_scale.ts";
import { allowInfrared, showRange } from "./view_controls.ts";
import type { Views } from "./views.ts";

const kSilence_ms = 2000;  // without a frame for so long, the page says so
const kFaultShown_ms = 6000;

interface Parts {
  state: LiveState;
  views: Views;
  scale: RangeScale;
  notices: Notices;
}

/** What the lamp beside the page's name shows, and what is wrong. */
interface ConnectionTexts {
  lamp: string;
  text: string;
  lost: string | null;
  silence: string | null;
}

export class LiveTexts {
  #parts: Parts;
  #hands = new HandList(element("hands"), element("no-hands"));
  #announcer = new Announcer(element("announcer"));

  constructor(parts: Parts) {
    this.#parts = parts;
  }

  /** The frame that is shown. */
  showRecord(): void {
    const { state: { header }, views, scale } = this.#parts;
    if (!header) return;
    const { record, camera } = header;
    this.#hands.show(record.hands, record.status);
    const placard = element("status");
    setText(placard, record.status);
    placard.hidden = record.status === "";
    const time = record.time_s === null ? "" : `  ${record.time_s.toFixed(3)} s`;
    const name = record.name && record.name !== String(record.frame) ? ` (${record.name})` : "";
    setText(element("frame"), `${record.frame}${name}${time}`);
    setText(element("camera"), `${header.width} x ${header.height}, ${camera.model}, f ${round(camera.fx)} ${camera.model === "projective" ? "px" : "px/mm"}`);
    showRange(views.range);
    scale.show(views.range);
    allowInfrared(views, header.infrared);
  }

  /** What holds for all frames of the stream. */
  showStream(): void {
    const { info } = this.#parts.state;
    if (!info) return;
    setText(element("source"), info.source || "–");
    setText(element("pipeline"), info.pipeline.split("/").slice(-2).join("/") || "–");
    element("pipeline").title = info.pipeline;
    setText(element("version"), `Knuckle ${info.version}`);
    document.title = info.source ? `${info.source} – Knuckle live` : "Knuckle live";
  }

  showConnection(): void {
    const { state, notices } = this.#parts;
    const { lamp, text, lost, silence } = connectionTexts(state, performance.now());
    element("connection").dataset["state"] = lamp;
    setText(element("connection-text"), text);
    if (state.connection.is !== "connecting") notices.set("connection", lost);
    notices.set("frames", silence);
  }

  /** A message could not be read. */
  showMalformed(reason: string): void {
    const { state, notices } = this.#parts;
    const isFirst = state.malformed === 1;
    const count = isFirst ? "A message" : `${state.malformed} messages`;
    notices.set("malformed", `${count} from the server could not be read and ${isFirst ? "was" : "were"} ignored; the last: ${reason}.`);
  }

  /** What changes by itself as time goes on. */
  showPassing(now_ms: number): void {
    const { state, notices } = this.#parts;
    if (state.malformed > 0 && now_ms - state.lastMalformed_ms > kFaultShown_ms) notices.set("malformed", null);
    const { header } = state;
    setText(element("passed-over"), header?.passed_over == null ? "–" : `${header.passed_over} of ${header.arrived ?? "?"} frames`);
    if (!header) return;
    this.#announcer.update(state.connection.is === "open" ? describeHands(header.record.hands, header.record.status) : "", now_ms);
  }
}

function connectionTexts(state: LiveState, now_ms: number): ConnectionTexts {
  const { connection } = state;
  if (connection.is === "connecting") return { lamp: "connecting", text: "Connecting", lost: null, silence: null };
  if (connection.is === "lost") {
    const wait_s = Math.max(0, Math.ceil((connection.retry_ms - now_ms) / 1000));
    const lost = `Connection lost: ${connection.reason}. The page tries again ${wait_s === 0 ? "now" : `in ${wait_s} s`}.`;
    return { lamp: "lost", text: "No connection", lost, silence: null };
  }
  const silence_ms = now_ms - Math.max(state.lastFrame_ms, state.openedAt_ms);
  if (silence_ms > kSilence_ms) {
    const since = `${Math.floor(silence_ms / 1000)} s`;
    const silence = state.received === 0 ? `Connected, but no frame has come for ${since}. Is the camera running?`
                                         : `No frames for ${since}. Has the recording ended, or is the camera unplugged?`;
    return { lamp: "waiting", text: "No frames", lost: null, silence };
  }
  return state.isPaused ? { lamp: "waiting", text: "Paused", lost: null, silence: null } : { lamp: "open", text: "Live", lost: null, silence: null };
}

function round(value: number): string {
  return Math.abs(value) >= 10 ? value.toFixed(1) : value.toPrecision(3);
}
