// Files that are there, and the job's text that survives a reload.

const KEY = "evencut.job";
const THEME = "evencut.theme";
const MESHES = /\.(stl|obj|ply|off)$/i;

export const isMesh = (name) => MESHES.test(name);
export const isJob = (name) => /\.toml$/i.test(name);
const base = (name) => name.split("/").pop();

/** Surfaces: those given by the user, and those of the examples, which are fetched when needed. */
export class Surfaces {
  #given = new Map();
  #fetched = new Map();
  #examples = new Set();

  set examples(names) {
    this.#examples = new Set(names);
  }

  add(name, bytes) {
    this.#given.set(base(name), bytes);
  }

  /** Names that a job may use. */
  get names() {
    return [...this.#given.keys(), ...this.#examples];
  }

  /** Whether the user gave the surface that a job names. */
  given(name) {
    return this.#given.get(base(name)) ?? null;
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

/** Storage may be forbidden; then nothing is kept. */
const stored = (key, value) => {
  try {
    if (value === undefined) return localStorage.getItem(key);
    if (value === null) localStorage.removeItem(key);
    else localStorage.setItem(key, value);
  } catch {
    // Nothing is kept.
  }
  return null;
};

/** The job that was edited last: {name, text, example}; null if there is none. */
export function savedJob() {
  try {
    const job = JSON.parse(stored(KEY) ?? "null");
    return typeof job?.text === "string" && typeof job?.name === "string" ? job : null;
  } catch {
    return null;
  }
}

export const saveJob = (job) => stored(KEY, job && JSON.stringify(job));
export const savedTheme = () => stored(THEME);
export const saveTheme = (theme) => stored(THEME, theme);
