// The planner's workers: one that stays, for short questions, and one for each plan.

/** The module is compiled once; servers that do not know its type are forgiven. */
async function compiled(url) {
  const response = await fetch(url);
  if (!response.ok) throw new Error(`${url}: ${response.status}`);
  const copy = response.clone();
  try {
    return await WebAssembly.compileStreaming(response);
  } catch (error) {
    if (error instanceof WebAssembly.CompileError) {
      throw new Error("This browser cannot run the planner, which needs WebAssembly with SIMD: Chrome 91, Firefox 89, Safari 16.4 or newer.");
    }
    if (!(error instanceof TypeError)) throw error;
    return WebAssembly.compile(await copy.arrayBuffer());
  }
}

/** The worker's script, kept so that planning goes on when the server does not. */
async function kept(url) {
  const response = await fetch(url);
  if (!response.ok) throw new Error(`${url}: ${response.status}`);
  return URL.createObjectURL(new Blob([await response.text()], { type: "text/javascript" }));
}

/** A worker that answers requests in their order; `web/wasm/src/request.rs` has their list. */
class Hand {
  #worker;
  #waiting = new Map();
  #next = 0;

  constructor([module, script]) {
    this.#worker = new Worker(script, { type: "module", name: "evencut" });
    this.#worker.onmessage = ({ data }) => this.#take(data);
    this.#worker.onerror = (event) => {
      event.preventDefault();
      this.end({ message: event.message || "the worker cannot be started" });
    };
    this.dead = false;
    this.#worker.postMessage(module);
  }

  /** Asks for one thing: `{ check: { … } }`. `on.progress` and `on.early` receive what a plan reports before its end. */
  ask(ask, on = {}) {
    const id = this.#next++;
    return new Promise((resolve, reject) => {
      this.#waiting.set(id, { resolve, reject, on });
      this.#worker.postMessage({ id, ask });
    });
  }

  /** Ends the worker; what it was asked fails with `reason`. */
  end(reason) {
    this.dead = true;
    this.#worker.terminate();
    for (const { reject } of this.#waiting.values()) reject(reason);
    this.#waiting.clear();
  }

  #take({ id, value, error, progress, early, ended }) {
    if (ended) {
      this.end(ended);
      return;
    }
    const asked = this.#waiting.get(id);
    if (!asked) return;
    if (progress || early) {
      if (progress) asked.on.progress?.(progress);
      if (early) asked.on.early?.(early);
      return;
    }
    this.#waiting.delete(id);
    if (error) asked.reject(error);
    else asked.resolve(value);
  }
}

export const CANCELLED = { cancelled: true };

/** The planner as the page knows it. Errors are `{fault}` or `{message}`, or `CANCELLED`. */
export class Engine {
  #parts = Promise.all([compiled("evencut.wasm"), kept("worker.js")]);
  #short = null;
  #planning = null;
  #texture = null;

  constructor() {
    // Whoever asks hears of it.
    this.#parts.catch(() => {});
  }

  async #ask(ask) {
    const parts = await this.#parts;
    if (!this.#short || this.#short.dead) this.#short = new Hand(parts);
    return this.#short.ask(ask);
  }

  /** What may be written at a place of a job, in UTF-16 units. */
  completions(source, at) {
    return this.#ask({ completions: { source, at } });
  }

  /** What the key means that ends at a place; null where there is none. */
  explanation(source, at) {
    return this.#ask({ explanation: { source, at } });
  }

  /** `beside`: names and contents of the files that the job is completed with, as far as they are there. */
  check(source, surfaces, beside = []) {
    return this.#ask({ check: { source, surfaces, beside } });
  }

  newJob(name, bytes) {
    return this.#ask({ newJob: { name, bytes } });
  }

  /** Plans in a worker of its own, whose memory is given back at the end. */
  async plan(name, source, files, on) {
    this.cancel();
    const hand = new Hand(await this.#parts);
    this.#planning = hand;
    try {
      return await hand.ask({ plan: { name, job: { source, ...files } } }, on);
    } finally {
      hand.end(CANCELLED);
      if (this.#planning === hand) this.#planning = null;
    }
  }

  /** The texture about a place `at` of a planned path, in a worker of its own; an earlier one gives way. */
  async texture(source, files, path, at) {
    this.#texture?.end(CANCELLED);
    const hand = new Hand(await this.#parts);
    this.#texture = hand;
    try {
      return await hand.ask({ texture: { job: { source, ...files }, path, at } });
    } finally {
      hand.end(CANCELLED);
      if (this.#texture === hand) this.#texture = null;
    }
  }

  cancel() {
    this.#texture?.end(CANCELLED);
    this.#planning?.end(CANCELLED);
    this.#planning = null;
  }
}
