// SPDX-License-Identifier: Apache-2.0
// What the page for labelling has to tell: why something was not done, and what is wrong.
import { Refusal } from "./label_client.ts";
import { element, Notices } from "./panel.ts";
import { MessageError } from "./protocol.ts";

const kRemarkShown_ms = 8000;

export class AnnotateNotices {
  #notices = new Notices(element("notices"));
  #remarkTimer = 0;

  /** Does something that may fail, and says why it did. */
  async attempt(act: () => Promise<void>): Promise<void> {
    try {
      await act();
    } catch (error) {
      if (!(error instanceof Refusal) && !(error instanceof MessageError)) throw error;
      this.remark(error instanceof MessageError ? `The server's answer cannot be read: ${error.message}.` : error.message);
    }
  }

  /** Says something for a while; an empty text ends it. */
  remark(text: string): void {
    clearTimeout(this.#remarkTimer);
    this.#notices.set("remark", text === "" ? null : text);
    if (text !== "") this.#remarkTimer = window.setTimeout(() => this.#notices.set("remark", null), kRemarkShown_ms);
  }

  /** `fault`: why labels cannot be written; empty where they can. */
  showDisk(fault: string, waiting: number): void {
    this.#notices.set("disk", fault === "" ? null
      : `The labels cannot be written: ${fault}. ${waiting} changes wait in the program's memory, and are written once there is room.`);
  }

  showConnection(isOpen: boolean): void {
    this.#notices.set("connection", isOpen ? null
      : "Connection lost: knuckle has ended, or the network is interrupted. What was labelled until then is kept; the page tries again.");
  }
}
