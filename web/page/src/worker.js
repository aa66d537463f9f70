// The planner in a thread of its own. The page sends {id, module} once, then {id, call, args};
// every message is answered by {id, value} or {id, error}; plans report {id, progress} and, as far as
// there is something to show, {id, early}.
import init, { check, completions, explanation, newJob, plan, texture } from "evencut-module";

/** Progress is reported at most this often, ms. */
const PAUSE = 50;
const TABLES = [
  "kind", "pass", "region", "time", "tip", "axis", "contact", "flat", "feed", "rate", "engagement",
  "plainTime", "plainRate", "samplePlace", "sampleResidual", "sampleRate", "sampleState",
  "sampleResidualTone", "sampleRateTone",
  "meshPositions", "meshFaces",
];

let panic = "";
globalThis.evencutPanicked = (message) => {
  panic = message;
};

const calls = {
  check: (_id, source, surfaces) => JSON.parse(check(source, surfaces)),
  newJob: (_id, name, bytes) => newJob(name, bytes),
  completions: (_id, source, at) => JSON.parse(completions(source, at)),
  explanation: (_id, source, at) => JSON.parse(explanation(source, at)),
  plan: planned,
  texture: textured,
};

function planned(id, name, source, surface, wall) {
  let last = 0;
  const start = performance.now();
  const report = (stage, part, done) => {
    const now = performance.now();
    if (part > 0 && now - last < PAUSE) return;
    last = now;
    postMessage({ id, progress: { stage, done } });
  };
  const seconds = () => (performance.now() - start) / 1000;
  const show = (made) => {
    const early = taken(made, seconds());
    postMessage({ id, early }, buffers(early));
  };
  return taken(plan(name, source, surface, wall, report, show), seconds());
}

function textured(_id, source, surface, wall, path, at) {
  const made = texture(source, surface, wall, path, Float64Array.from(at));
  try {
    return { files: files(made), summary: made.summary(), tables: {} };
  } finally {
    made.free();
  }
}

const files = (made) => made.names().map((file) => ({ name: file, bytes: made.file(file) }));

/** What the page needs of a plan, which is freed. */
function taken(made, seconds) {
  try {
    const report = made.report();
    return {
      files: files(made),
      report: report ? JSON.parse(report) : null,
      summary: made.summary() ?? null,
      scales: JSON.parse(made.scales()),
      tables: Object.fromEntries(TABLES.map((table) => [table, made.table(table)])),
      seconds,
    };
  } finally {
    made.free();
  }
}

/** What the page shows of an error: a fault of the planner, or a message. */
function described(error) {
  if (typeof error === "string") {
    return error.startsWith("{") ? { fault: JSON.parse(error) } : { message: error };
  }
  if (panic) return { message: `This is a bug in evencut: ${panic}`, dead: true };
  if (error instanceof WebAssembly.RuntimeError || error instanceof RangeError) {
    return {
      message: "The browser ran out of memory for this job. Use a coarser mesh or a larger side step, or the command-line program, which may use more memory.",
      dead: true,
    };
  }
  return { message: String(error), dead: true };
}

const buffers = (value) => {
  if (!value?.files) return [];
  return [...value.files.map((f) => f.bytes), ...Object.values(value.tables)].map((a) => a.buffer);
};

onmessage = async ({ data: { id, module, call, args } }) => {
  try {
    if (module) await init({ module_or_path: module });
    const value = call ? calls[call](id, ...args) : null;
    postMessage({ id, value }, buffers(value));
  } catch (error) {
    postMessage({ id, error: described(error) });
  }
};
