/** One socket: requests by lane, the newest wins, and a lost connection is taken up again. */
import type { Refused } from "./types";

export type Status = "connecting" | "compiling" | "ready" | "lost";

export type Message = Record<string, unknown>;

/** An answer: the header, and the arrays of a binary frame by name. */
export interface Answer { header: Record<string, any>; arrays: Record<string, Float32Array | Float64Array>; shapes: Record<string, number[]> }

export class RequestRefused extends Error {
  constructor(readonly refused: Refused) { super(refused.message); }
}

interface Request { id: number; message: Message; done: (answer: Answer) => void; failed: (error: Error) => void }

interface Lane { flying: Request | null; waiting: Request | null }

const FIRST_WAIT = 300, LONGEST_WAIT = 5000; // ms

export class Live {
  private socket: WebSocket | null = null;
  private lanes = new Map<string, Lane>();
  private number = 0;
  private wait = FIRST_WAIT;
  private listeners = new Set<(status: Status) => void>();
  status: Status = "connecting";

  constructor() { this.open(); }

  onStatus(listener: (status: Status) => void): () => void {
    this.listeners.add(listener);
    return () => this.listeners.delete(listener);
  }

  /** Ask; what waits in the lane already is never sent, and never answered. */
  ask(lane: string, message: Message): Promise<Answer> {
    return new Promise((done, failed) => {
      const request = { id: ++this.number, message, done, failed };
      const own = this.lanes.get(lane) ?? { flying: null, waiting: null };
      this.lanes.set(lane, own);
      if (own.flying) own.waiting = request;
      else this.send(lane, own, request);
    });
  }

  private send(lane: string, own: Lane, request: Request): void {
    own.flying = request;
    if (this.socket?.readyState === WebSocket.OPEN) {
      this.socket.send(JSON.stringify({ ...request.message, lane, id: request.id }));
    } // else it is sent once the socket is open
  }

  private open(): void {
    const scheme = location.protocol === "https:" ? "wss:" : "ws:";
    const socket = new WebSocket(`${scheme}//${location.host}${location.pathname.replace(/[^/]*$/, "")}live`);
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      this.wait = FIRST_WAIT;
      for (const [lane, own] of this.lanes) if (own.flying) this.send(lane, own, own.flying);
    };
    socket.onmessage = (event) => this.take(typeof event.data === "string" ? fromText(event.data) : decode(event.data));
    socket.onclose = () => {
      this.tell("lost");
      setTimeout(() => this.open(), this.wait);
      this.wait = Math.min(2 * this.wait, LONGEST_WAIT);
    };
    this.socket = socket;
  }

  private take(answer: Answer): void {
    const { header } = answer;
    if (header.kind === "state") {
      this.tell(header.state);
      return;
    }
    const own = this.lanes.get(header.lane);
    if (!own?.flying || own.flying.id !== header.id) return;
    const request = own.flying, next = own.waiting;
    own.flying = own.waiting = null;
    if (next) this.send(header.lane, own, next);
    if (header.kind === "refused") request.failed(new RequestRefused(header as Refused));
    else request.done(answer);
  }

  private tell(status: Status): void {
    this.status = status;
    for (const listener of this.listeners) listener(status);
  }
}

function fromText(text: string): Answer {
  return { header: JSON.parse(text), arrays: {}, shapes: {} };
}

/** See src/ridedown/apps/web/frames.py. */
export function decode(buffer: ArrayBuffer): Answer {
  const length = new DataView(buffer).getUint32(0, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  const arrays: Answer["arrays"] = {}, shapes: Answer["shapes"] = {};
  let place = 4 + length;
  for (const one of header.arrays as { name: string; type: string; shape: number[] }[]) {
    const count = one.shape.reduce((product, side) => product * side, 1);
    arrays[one.name] = one.type === "f8" ? new Float64Array(buffer, place, count) : new Float32Array(buffer, place, count);
    shapes[one.name] = one.shape;
    place += Math.ceil(count * (one.type === "f8" ? 8 : 4) / 8) * 8;
  }
  return { header, arrays, shapes };
}

/** The rows of a two-dimensional array, without copying. */
export function rows(answer: Answer, name: string): Float32Array[] {
  const [count = 0, length = 0] = answer.shapes[name] ?? [];
  const all = answer.arrays[name] as Float32Array;
  return Array.from({ length: count }, (_, i) => all.subarray(i * length, (i + 1) * length));
}
