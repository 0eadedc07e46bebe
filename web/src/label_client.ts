// SPDX-License-Identifier: Apache-2.0
// Asks the server of `knuckle annotate`, and hears of what others change.
import { apiAddress, plainRefusal, socketAddress } from "./connection.ts";
import { readFrame, type FrameMessage, object, number } from "./protocol.ts";
import {
  readLabelAnswer, readLabelInfo, readStandings, type LabelAnswer, type LabelInfo, type LabelRequest, type Standings,
} from "./label_protocol.ts";

const kPatience_ms = 30_000;
const kFirstWait_ms = 500;
const kLongestWait_ms = 5000;

/** An answer that says why not, as a sentence. */
export class Refusal extends Error {}

async function ask(path: string, more: RequestInit = {}): Promise<Response> {
  try {
    return await fetch(apiAddress(path), { cache: "no-store", signal: AbortSignal.timeout(kPatience_ms), ...more });
  } catch {
    throw new Refusal("The server does not answer.");
  }
}

async function refusalOf(answer: Response): Promise<Refusal> {
  const said = (await answer.text()).trim().slice(0, 500);
  return new Refusal(said !== "" && (answer.headers.get("Content-Type") ?? "").startsWith("text/plain") ? said : `${plainRefusal(answer.status)}.`);
}

async function askJson(path: string): Promise<unknown> {
  const answer = await ask(path);
  if (!answer.ok) throw await refusalOf(answer);
  return answer.json();
}

export async function fetchInfo(): Promise<LabelInfo> {
  return readLabelInfo(await askJson("api/info"));
}

export async function fetchFrame(index: number): Promise<FrameMessage> {
  const answer = await ask(`api/frame?index=${index}`);
  if (!answer.ok) throw await refusalOf(answer);
  return readFrame(await answer.arrayBuffer());
}

export async function fetchThumbnail(index: number): Promise<FrameMessage> {
  const answer = await ask(`api/thumbnail?index=${index}`);
  if (!answer.ok) throw await refusalOf(answer);
  return readFrame(await answer.arrayBuffer());
}

export async function fetchStandings(): Promise<Standings> {
  return readStandings(await askJson("api/standings"));
}

/** The frame whose correction would change most; null where all are verified. */
export async function fetchNext(after: number): Promise<number | null> {
  const next = object(await askJson(`api/next?after=${after}`), "the answer")["frame"];
  return next === null ? null : number(next, "frame");
}

/** Asks for a change. An answer whose `refused` is set did nothing. Throws a Refusal or a MessageError. */
export async function postChange(request: LabelRequest): Promise<LabelAnswer> {
  const answer = await ask("api/labels", { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(request) });
  if (!answer.ok && answer.status !== 409) throw await refusalOf(answer);
  return readLabelAnswer(await answer.json());
}

/** What has changed: a hand's revision. */
export interface Change {
  frame: number;
  side: string;
  revision: number;
}

/** Hears of changes; says when the line is open, and when it is lost. It is opened again by itself. */
export function listenToChanges(changed: (change: Change) => void, isOpen: (isOpen: boolean) => void): void {
  let wait_ms = kFirstWait_ms;
  const open = (): void => {
    const socket = new WebSocket(socketAddress("api/changes"));
    socket.onopen = () => {
      wait_ms = kFirstWait_ms;
      isOpen(true);
    };
    socket.onmessage = (event) => {
      try {
        const said = object(JSON.parse(String(event.data)), "the message");
        changed({ frame: number(said["frame"], "frame"), side: String(said["side"]), revision: number(said["revision"], "revision") });
      } catch {
        // what is none of ours is not looked at
      }
    };
    socket.onclose = () => {
      isOpen(false);
      window.setTimeout(open, wait_ms);
      wait_ms = Math.min(2 * wait_ms, kLongestWait_ms);
    };
  };
  open();
}
