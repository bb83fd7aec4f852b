import type { Calls, EventWord, Notifications } from "./methods.js";

export type { Calls, EventWord, Notifications } from "./methods.js";

type MethodName = keyof Calls;
type Params<M extends MethodName> = Calls[M]["params"];
type Result<M extends MethodName> = Calls[M]["result"];
type Method<M extends MethodName> = {} extends Params<M>
  ? (params?: Params<M>) => Promise<Result<M>>
  : (params: Params<M>) => Promise<Result<M>>;
type GroupName<M = MethodName> = M extends `${infer G}.${string}` ? G : never;
type Group<G extends string> = {
  [M in MethodName as M extends `${G}.${infer Name}` ? Name : never]: Method<M>;
};
type Single = { [M in MethodName as M extends `${string}.${string}` | "wait" | "export" ? never : M]: Method<M> };
type Groups = { [G in GroupName]: Group<G> };

export type Level = "coarse" | "complete" | "converged";
/** What can be sent as a file. */
export type Bytes = Uint8Array | Blob;

/** What went wrong. */
export class QuiltdError extends Error {
  /** MethodNotFound, ParameterError, InternalError, Busy, PathRefused, BadScene, NoDevice, TimedOut, NoDaemon,
   * WrongToken, ConnectionClosed, NotSupported, Cancelled, or QuiltdError. */
  name: string;
  /** Of the answer, if there was one. */
  code?: number;
  data?: { file?: string; line?: number; pointer?: string };
}

/** A notification. */
export type Event = { [N in keyof Notifications]: { name: N; params: Notifications[N] } }[keyof Notifications];

/** Values in order; it ends by return(), which `break` calls. */
export interface Values<T> extends AsyncIterableIterator<T> {
  return(): Promise<IteratorResult<T>>;
}

/** An image that the panel shows: a quilt with view 0 at the bottom left. */
export interface Image {
  /** Modulo 2^32. */
  generation: number;
  level: "none" | Level;
  columns: number;
  rows: number;
  views: number;
  /** Of one view, in pixels. */
  width: number;
  height: number;
  jpeg: Uint8Array;
}

export interface Upload {
  path: string;
  folder: string;
}

/** A connection. Each method that `hello` lists is a member, too: q.camera.orbit({ yaw: 15 }). */
export interface Quiltd extends Single, Groups {}
export class Quiltd {
  private constructor();
  /** The answer of `hello`. */
  readonly info: { name: string; version: string; protocol: number; [key: string]: any };
  /** The result of a method by its name. timeout: seconds to wait for the answer. */
  call<M extends MethodName>(method: M, params?: Params<M>, options?: { timeout?: number }): Promise<Result<M>>;
  call(method: string, params?: object, options?: { timeout?: number }): Promise<any>;
  /** A call without an answer. */
  notify(method: string, params?: object): void;
  close(): void;
  /** Until the panel shows the newest generation, or this one, at a level (coarse). timeout: seconds. */
  wait(level?: Level, options?: { generation?: number; timeout?: number }): Promise<Result<"wait">>;
  /** Notifications of these events, or of all, from now on. timeout: seconds without one that end it. */
  events(...words: EventWord[]): Values<Event>;
  events(...wordsAndOptions: [...EventWord[], { timeout?: number }]): Values<Event>;
  /** Images as they are shown. Needs quiltweb, as all members below. One reader at a time. */
  images(): AsyncGenerator<Image, void, void>;
  /** The image that is shown now. */
  preview(): Promise<Image>;
  /** Puts a file where scene.load finds it. folder: that of an earlier upload. */
  upload(name: string, data: Bytes, options?: { folder?: string }): Promise<Upload>;
  /** Shows a picture file as a quilt. */
  showQuilt(
    picture: Bytes,
    tiles: { columns: number; rows: number; views?: number; aspect?: number },
  ): Promise<{ generation: number; warnings: string[] }>;
  /** What `quiltctl export` writes. timeout: seconds. */
  export(
    kind?: Params<"export">["kind"],
    params?: Partial<Params<"export">> & { timeout?: number },
  ): Promise<{ name: string; data: Uint8Array }[]>;
}

/** The image of a message of quiltweb. */
export function readImage(buffer: ArrayBuffer): Image;

/** A client. In a browser: of the quiltd whose page this is. In Node, where is the path of a socket, or the URL that
 * quiltweb printed; without it, the socket that quiltctl would take. */
export function connect(where?: string): Promise<Quiltd>;
