// Calls that move the camera. One call is on its way at a time; what is asked for meanwhile is summed
// up, so that no step is lost.

import { placed, shifted } from "./rig.js";

export const DEGREES_PER_PIXEL = 0.35;

export class Camera {
  #rpc;
  #canvas;
  #moves;
  #fail;
  #turn = { yaw: 0, pitch: 0, zoom: 1 };
  #shift = [0, 0]; // pixels by which the target moves
  #busy = false;

  /**
   * @param moves called before a move and after each call
   * @param fail called with the error of a call
   */
  constructor(rpc, canvas, moves, fail) {
    this.#rpc = rpc;
    this.#canvas = canvas;
    this.#moves = moves;
    this.#fail = fail;
  }

  turn(right, down) {
    this.#turn.yaw -= right * DEGREES_PER_PIXEL;
    this.#turn.pitch += down * DEGREES_PER_PIXEL;
    this.#send();
  }

  zoom(factor) {
    this.#turn.zoom = Math.min(Math.max(this.#turn.zoom * factor, 0.001), 1000);
    this.#send();
  }

  // Moves the image with the pointer: the target goes the other way.
  shift(right, down) {
    this.#shift = [this.#shift[0] + right, this.#shift[1] + down];
    this.#send();
  }

  async #send() {
    this.#moves();
    if (this.#busy) return;
    this.#busy = true;
    try {
      while (await this.#sendOne()) this.#moves();
    } catch (error) {
      this.#fail(error);
    } finally {
      this.#busy = false;
    }
  }

  // Whether there was something to send.
  async #sendOne() {
    const turn = this.#turn,
      shift = this.#shift;
    if (turn.yaw !== 0 || turn.pitch !== 0 || turn.zoom !== 1) {
      this.#turn = { yaw: 0, pitch: 0, zoom: 1 };
      await this.#rpc.call("camera.orbit", turn);
      return true;
    }
    if (shift[0] === 0 && shift[1] === 0) return false;
    this.#shift = [0, 0];
    await this.#moveTarget(shift);
    return true;
  }

  async #moveTarget([right, down]) {
    const { scene } = await this.#rpc.call("scene.get");
    const camera = placed(scene?.camera);
    if (!camera)
      throw new Error(
        "The target cannot be moved: the camera of this scene has no fixed position.",
      );
    await this.#rpc.call("camera.set", shifted(camera, right, down, this.#canvas.clientHeight));
  }
}
