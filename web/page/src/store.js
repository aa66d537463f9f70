// Files that are there, and what survives a reload: jobs as they were edited, and surfaces.

const THEME = "evencut.theme";
const DRAFTS = "evencut.drafts";
/** Most that surfaces may take in the browser's storage, bytes. */
const MOST = 400e6;
const MESHES = /\.(stl|obj|ply|off|json|step|stp)$/i;

export const isMesh = (name) => MESHES.test(name);
export const isPost = (name) => /\.post\.toml$/i.test(name);
/** Libraries of tools, descriptions of machines; one in JSON looks like a surface until a job names it. */
export const isTools = (name) => /\.((tools|machine)\.toml|fctb)$/i.test(name);
export const isJob = (name) => /\.toml$/i.test(name) && !isPost(name) && !isTools(name);
export const base = (name) => name.split("/").pop();

// ---- surfaces

/** A request of the browser's database as a promise. */
const done = (request) => new Promise((resolve, reject) => {
  request.onsuccess = () => resolve(request.result);
  request.onerror = () => reject(request.error);
});

/** Surfaces that stay in this browser, by name. Where storage is forbidden nothing stays. */
class Kept {
  #database = null;

  #open() {
    this.#database ??= new Promise((resolve, reject) => {
      const request = indexedDB.open("evencut", 1);
      request.onupgradeneeded = () => request.result.createObjectStore("surfaces", { keyPath: "name" });
      request.onblocked = () => reject(new Error("blocked"));
      done(request).then(resolve, reject);
    });
    return this.#database;
  }

  async #store(mode) {
    return (await this.#open()).transaction("surfaces", mode).objectStore("surfaces");
  }

  async all() {
    try {
      return await done((await this.#store("readonly")).getAll());
    } catch {
      return [];
    }
  }

  /** Whether the surface is kept; the oldest ones give way. */
  async put(name, bytes) {
    try {
      if (bytes.length > MOST) return false;
      const others = (await this.all()).filter((one) => one.name !== name).sort((a, b) => b.time - a.time);
      let room = MOST - bytes.length;
      for (const one of others) {
        room -= one.bytes.length;
        if (room < 0) await done((await this.#store("readwrite")).delete(one.name));
      }
      await done((await this.#store("readwrite")).put({ name, bytes, time: Date.now() }));
      return true;
    } catch {
      return false;
    }
  }

  async clear() {
    try {
      await done((await this.#store("readwrite")).clear());
    } catch {
      // Nothing was kept.
    }
  }
}

/** Surfaces: those given by the user, and those of the examples, which are fetched when needed. */
export class Surfaces {
  #given = new Map();
  #fetched = new Map();
  #examples = new Set();
  #kept = new Kept();

  set examples(names) {
    this.#examples = new Set(names);
  }

  /** Brings back what was kept. */
  async restore() {
    for (const { name, bytes } of await this.#kept.all()) {
      if (!this.#given.has(name)) this.#given.set(name, bytes);
    }
  }

  /** Takes a surface; whether it stays when the page is closed. */
  async add(name, bytes) {
    this.#given.set(base(name), bytes);
    return this.#kept.put(base(name), bytes);
  }

  /** Forgets all surfaces that the user gave. */
  async forget() {
    this.#given.clear();
    await this.#kept.clear();
  }

  /** How many surfaces the user gave. */
  get count() {
    return this.#given.size;
  }

  /** Names that a job may use. */
  get names() {
    return [...this.#given.keys(), ...this.#examples];
  }

  /** Whether the user gave the surface that a job names. */
  given(name) {
    return this.#given.get(base(name)) ?? null;
  }

  isExample(name) {
    return this.#examples.has(name);
  }

  /** A copy of the bytes of the surface that a job names; null where it is not there. */
  async bytes(name) {
    const given = this.given(name);
    if (given) return given.slice();
    if (!this.#examples.has(name)) return null;
    if (!this.#fetched.has(name)) {
      const response = await fetch(`examples/${name}`);
      if (!response.ok) throw new Error(`examples/${name}: ${response.status}`);
      this.#fetched.set(name, new Uint8Array(await response.arrayBuffer()));
    }
    return this.#fetched.get(name).slice();
  }
}

// ---- texts

/** Storage may be forbidden; then nothing is kept. */
function stored(storage, key, value) {
  try {
    if (value === undefined) return storage().getItem(key);
    if (value === null) storage().removeItem(key);
    else storage().setItem(key, value);
  } catch {
    // Nothing is kept.
  }
  return null;
}

const tab = () => sessionStorage;
const browser = () => localStorage;

function parsed(text) {
  try {
    const found = JSON.parse(text ?? "null");
    return found && typeof found.texts === "object" ? found : null;
  } catch {
    return null;
  }
}

/**
 * Jobs as they were edited last, {name, text}, by the example they came from or "" for the user's own.
 * Tabs do not disturb each other; a new tab begins with what the last one had.
 */
export class Drafts {
  #held = parsed(stored(tab, DRAFTS)) ?? parsed(stored(browser, DRAFTS)) ?? { last: null, texts: {} };

  get(key) {
    const draft = this.#held.texts[key];
    return typeof draft?.text === "string" && typeof draft?.name === "string" ? draft : null;
  }

  /** The key of what was shown last; null at first. */
  get last() {
    return this.#held.last;
  }

  set last(key) {
    this.#held.last = key;
    this.#write();
  }

  set(key, draft) {
    if (draft) this.#held.texts[key] = draft;
    else delete this.#held.texts[key];
    this.#write();
  }

  #write() {
    const text = JSON.stringify(this.#held);
    stored(tab, DRAFTS, text);
    stored(browser, DRAFTS, text);
  }
}

export const savedTheme = () => stored(browser, THEME);
export const saveTheme = (theme) => stored(browser, THEME, theme);
