// The planner's workers: one that stays, for short questions, and one for each plan.

/** The module is compiled once; servers that do not know its type are forgiven. */
async function compiled(url) {
  const response = await fetch(url);
  if (!response.ok) throw new Error(`${url}: ${response.status}`);
  const copy = response.clone();
  try {
    return await WebAssembly.compileStreaming(response);
  } catch (error) {
    if (!(error instanceof TypeError)) throw error;
    return WebAssembly.compile(await copy.arrayBuffer());
  }
}

/** A worker that answers calls in their order. */
class Hand {
  #worker = new Worker("worker.js", { type: "module", name: "evencut" });
  #waiting = new Map();
  #next = 0;

  constructor(module) {
    this.#worker.onmessage = ({ data }) => this.#take(data);
    this.#worker.onerror = (event) => {
      event.preventDefault();
      this.#fail({ message: event.message || "the worker cannot be started", dead: true });
    };
    this.dead = false;
    this.#send({ module }).catch(() => {});
  }

  call(call, args, progress) {
    return this.#send({ call, args }, progress);
  }

  /** Ends the worker; what it was asked fails with `reason`. */
  end(reason) {
    this.#worker.terminate();
    this.#fail(reason);
  }

  #send(message, progress) {
    const id = this.#next++;
    return new Promise((resolve, reject) => {
      this.#waiting.set(id, { resolve, reject, progress });
      this.#worker.postMessage({ id, ...message });
    });
  }

  #take({ id, value, error, progress }) {
    const asked = this.#waiting.get(id);
    if (!asked) return;
    if (progress) {
      asked.progress?.(progress);
      return;
    }
    this.#waiting.delete(id);
    if (error?.dead) this.dead = true;
    if (error) asked.reject(error);
    else asked.resolve(value);
  }

  #fail(reason) {
    this.dead = true;
    for (const { reject } of this.#waiting.values()) reject(reason);
    this.#waiting.clear();
  }
}

export const CANCELLED = { cancelled: true };

/** The planner as the page knows it. Errors are `{fault}` or `{message}`, or `CANCELLED`. */
export class Engine {
  #module = compiled("evencut.wasm");
  #short = null;
  #planning = null;

  async #ask(call, args) {
    const module = await this.#module;
    if (!this.#short || this.#short.dead) this.#short = new Hand(module);
    return this.#short.call(call, args);
  }

  facts() {
    return this.#ask("facts", []);
  }

  check(source, surfaces) {
    return this.#ask("check", [source, surfaces]);
  }

  newJob(name, bytes) {
    return this.#ask("newJob", [name, bytes]);
  }

  /** Plans in a worker of its own, whose memory is given back at the end. */
  async plan(name, source, surface, progress) {
    this.cancel();
    const hand = new Hand(await this.#module);
    this.#planning = hand;
    try {
      return await hand.call("plan", [name, source, surface], progress);
    } finally {
      hand.end(CANCELLED);
      if (this.#planning === hand) this.#planning = null;
    }
  }

  cancel() {
    this.#planning?.end(CANCELLED);
    this.#planning = null;
  }
}
