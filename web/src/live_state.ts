// SPDX-License-Identifier: Apache-2.0
// All that the live page knows; what is seen follows from it.
import type { ConnectionState } from "./connection.ts";
import { FrameImages, type FrameHeader, type FrameMessage, type Info, type Recording } from "./protocol.ts";
import type { Shown } from "./views.ts";

const noBones: [string, string][] = [];

/** Times are those of performance.now(). */
export class LiveState implements Shown {
  readonly images = new FrameImages();
  connection: ConnectionState = { is: "connecting" };
  info: Info | null = null;
  header: FrameHeader | null = null;
  newest: FrameMessage | null = null;  // came, and is not shown yet
  isPaused = false;
  isStepping = false;  // the next frame that comes is shown, though paused
  recording: Recording | null = null;
  isAskingToRecord = false;
  malformed = 0;
  lastMalformed_ms = -Infinity;
  lastFrame_ms = -Infinity;
  openedAt_ms = 0;
  received = 0;
  shown = 0;
  imageChanged = false;  // the image has to be drawn again
  cloudChanged = false;

  get bones(): readonly [string, string][] {
    return this.info?.bones ?? noBones;
  }
}
