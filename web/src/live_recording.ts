// SPDX-License-Identifier: Apache-2.0
// The recording that the program writes while the live page is open: started and stopped here, and how it goes.
import { setRecording } from "./connection.ts";
import type { LiveState } from "./live_state.ts";
import { element, setText, type Notices } from "./panel.ts";
import type { Info, Recording } from "./protocol.ts";

interface Parts {
  state: LiveState;
  notices: Notices;
}

export class LiveRecording {
  #parts: Parts;
  #button = element<HTMLButtonElement>("record");
  #shownFault = "";

  constructor(parts: Parts) {
    this.#parts = parts;
  }

  /** Starts it, or stops it. */
  async toggle(): Promise<void> {
    if (this.#button.disabled) return;
    const { state, notices } = this.#parts;
    const on = !isOn(state.recording);
    state.isAskingToRecord = true;
    this.show();
    try {
      state.recording = await setRecording(on);
      notices.set("recording", null);
    } catch (error) {
      notices.set("recording", sentence(`The recording could not be ${on ? "started" : "stopped"}: ${(error as Error).message}`));
    }
    state.isAskingToRecord = false;
    this.show();
  }

  show(): void {
    const { recording, info, isAskingToRecord } = this.#parts.state;
    const records = isOn(recording);
    this.#button.disabled = isAskingToRecord || (!records && info !== null && !info.can_record);
    this.#button.setAttribute("aria-pressed", String(records));
    setText(this.#button.querySelector(".label")!, records ? "Stop recording" : "Record");
    this.#button.title = records ? "Stop recording (R)" : "Record (R)";
    setText(element("recording-text"), described(recording, info));
    this.#showFault(recording?.fault ?? "");
  }

  #showFault(fault: string): void {
    if (fault === this.#shownFault) return;
    this.#shownFault = fault;
    this.#parts.notices.set("recording", fault === "" ? null : sentence(`The recording has ended: ${fault}`));
  }
}

function isOn(recording: Recording | null): boolean {
  return recording !== null && recording.file !== null;
}

function described(recording: Recording | null, info: Info | null): string {
  if (recording && isOn(recording)) {
    const dropped = recording.dropped > 0 ? `, ${recording.dropped} dropped because the disk is too slow` : "";
    return `${recording.file}: ${recording.frames} frames${dropped}`;
  }
  if (info && !info.can_record) return "not possible here; start knuckle live with --record-folder DIR";
  return recording && recording.frames > 0 ? `off; ${recording.frames} frames written` : "off";
}

function sentence(text: string): string {
  return /[.!?]$/.test(text) ? text : `${text}.`;
}
