// The page: a job and its surface in, a plan out.
import { $, bytes, make } from "./dom.js";
import { Editor, spoken } from "./editor.js";
import { CANCELLED, Engine } from "./engine.js";
import { Surfaces, isJob, isMesh, saveJob, saveTheme, savedJob, savedTheme } from "./store.js";
import { Views } from "./views.js";

/** Rest after the last key before a job is checked, ms. */
const REST = 150;
/** Parts of the work that lie behind the start of each stage, roughly. */
const STAGES = {
  "reading the surface": [0, 0.03],
  "laying the surface flat": [0.03, 0.08],
  "laying rings": [0.08, 0.2],
  "cutting within the limit": [0.2, 0.35],
  "locating the cutter": [0.35, 0.6],
  "simulating the path": [0.6, 0.97],
  "writing the results": [0.97, 1],
};

const engine = new Engine();
const surfaces = new Surfaces();
const views = new Views();
let examples = [];
/** The job as it is edited: its name, the example it came from, its text when it came. */
let job = { name: "job.toml", example: null, original: "" };
let checking = 0;
let checked = null;

const editor = new Editor($("editor"), {
  changed(text, byUser) {
    const edited = text !== job.original;
    $("edited").hidden = !edited;
    $("revert").hidden = !edited || !job.example;
    if (byUser) saveJob({ name: job.name, text, example: job.example });
    clearTimeout(checking);
    checking = setTimeout(check, REST);
  },
  plan: () => plan(),
});

// ---- the job

function setJob(name, text, example, original = text) {
  job = { name, example, original };
  $("job-name").textContent = name;
  $("examples").value = example ?? "";
  document.title = `${name} – evencut`;
  editor.replace(text);
  editor.show([]);
  const url = new URL(location.href);
  if (example) url.searchParams.set("example", example);
  else url.searchParams.delete("example");
  history.replaceState(null, "", url);
}

async function check() {
  const text = editor.text;
  let found;
  try {
    found = await engine.check(text, surfaces.names);
  } catch (error) {
    tell(error.message ?? String(error));
    return null;
  }
  if (text !== editor.text) return null;
  checked = found;
  editor.show(found.faults);
  showFaults(found.faults);
  showSurface(found.surface);
  const bad = found.faults.some((fault) => fault.severity === "error");
  $("plan").disabled = bad;
  document.body.dataset.checked = bad ? "bad" : "good";
  return found;
}

function showFaults(faults) {
  const count = (severity) => faults.filter((fault) => fault.severity === severity).length;
  const words = (n, word) => `${n} ${word}${n === 1 ? "" : "s"}`;
  const [errors, warnings] = [count("error"), count("warning")];
  const said = errors ? [words(errors, "error")] : ["Good to plan"];
  if (warnings) said.push(words(warnings, "warning"));
  $("verdict").textContent = said.join(", ");
  $("verdict").className = errors ? "bad" : "good";
  $("faults").replaceChildren(...faults.map(faultItem));
}

function faultItem(fault) {
  const place = fault.line === null ? "whole file" : `line ${fault.line}, column ${fault.column}`;
  const button = make("button", { type: "button" },
    make("span", { className: "place" }, place), make("span", {}, spoken(fault)),
    ...fault.help.map((line) => make("span", { className: "help" }, line)));
  button.addEventListener("click", () => {
    pane("job");
    editor.go(fault.from ?? 0);
  });
  return make("li", { className: fault.severity }, button);
}

function showSurface(name) {
  const given = name && surfaces.given(name);
  const known = given ? bytes(given.length) : name && surfaces.names.includes(name) ? "example" : "not here yet: drop the file on this page";
  $("surface").replaceChildren(...(name
    ? [make("span", {}, "Surface "), make("b", {}, name), make("span", {}, ` ${known}`)]
    : [make("span", {}, checked?.name ? "Surface by formula" : " ")]));
}

// ---- planning

async function plan() {
  const found = await check();
  if (!found || $("plan").disabled || !$("working").hidden) return;
  const text = editor.text;
  const { name } = job;
  show("working");
  pane("result");
  const start = performance.now();
  const ticking = setInterval(() => elapsed(start), 100);
  elapsed(start);
  $("progress").value = 0;
  $("stage").textContent = "Starting";
  try {
    const surface = found.surface ? await surfaces.bytes(found.surface) : null;
    const planned = await engine.plan(name, text, surface ?? undefined, progress);
    if ($("working").hidden) return;
    show("planned");
    views.show(planned, name);
    document.body.dataset.planned = name;
  } catch (error) {
    if (error === CANCELLED) show("empty");
    else failed(error);
  } finally {
    clearInterval(ticking);
  }
}

function progress({ stage, part }) {
  const [from, to] = STAGES[stage] ?? [0, 1];
  $("stage").textContent = stage[0].toUpperCase() + stage.slice(1);
  // Stages may come again for what earlier passes left: the bar does not go back.
  $("progress").value = Math.max($("progress").value, from + Math.min(Math.max(part, 0), 1) * (to - from));
}

function elapsed(start) {
  $("elapsed").textContent = `${((performance.now() - start) / 1000).toFixed(1)} s`;
}

function failed(error) {
  const fault = error.fault;
  const heading = make("h2", {}, "This job cannot be planned");
  const text = fault ? spoken(fault) : error.message ?? String(error);
  const help = (fault?.help ?? []).map((line) => make("p", { className: "help" }, line));
  $("failure").replaceChildren(heading, make("p", {}, text), ...help);
  if (fault && fault.line !== null) {
    const go = make("button", { type: "button" }, `Line ${fault.line} of the job`);
    go.addEventListener("click", () => {
      pane("job");
      editor.go(fault.from);
    });
    $("failure").append(go);
  }
  show("failure");
  if (fault) {
    editor.show([fault]);
    showFaults([fault]);
  }
}

/** Shows one part of the result: empty, working, failure or planned. */
function show(part) {
  for (const id of ["empty", "working", "failure", "planned"]) $(id).hidden = id !== part;
  $("cancel").hidden = part !== "working";
  $("plan").hidden = part === "working";
  if (part === "working") {
    views.clear();
    delete document.body.dataset.planned;
  }
  document.body.dataset.state = part;
}

function pane(name) {
  document.body.dataset.pane = name;
  for (const button of document.querySelectorAll(".panes button")) {
    button.setAttribute("aria-pressed", button.dataset.pane === name);
  }
}

/** A message that goes away with the next one; nothing clears it. */
function tell(text = "") {
  $("notice").textContent = text;
  $("notice").hidden = !text;
  if (text) pane("result");
}

// ---- files

async function take(list) {
  tell();
  const files = await Promise.all([...list].map(async (file) => ({ name: file.name, content: new Uint8Array(await file.arrayBuffer()) })));
  const unknown = files.filter(({ name }) => !isJob(name) && !isMesh(name));
  for (const { name, content } of files.filter((file) => isMesh(file.name))) surfaces.add(name, content);
  const jobs = files.filter((file) => isJob(file.name));
  const meshes = files.filter((file) => isMesh(file.name));
  if (jobs.length > 0) setOwn(jobs[0].name, new TextDecoder().decode(jobs[0].content));
  else if (meshes.length > 0) await jobFor(meshes[0]);
  if (unknown.length > 0) {
    tell(`${unknown.map((file) => file.name).join(", ")}: not a job (.toml) and not a surface (.stl, .obj, .ply, .off, .json, .step)`);
  }
  await check();
}

/** A job of the user's own. */
function setOwn(name, text) {
  setJob(name, text, null);
  saveJob({ name, text, example: null });
}

/** A surface without a job: the job on the page may wait for it; otherwise a new one is written. */
async function jobFor({ name, content }) {
  const wanted = (await check())?.surface;
  if (wanted && wanted.split("/").pop() === name && !wanted.startsWith("surfaces/")) return;
  try {
    const text = await engine.newJob(name, content);
    setOwn(name.replace(/\.[^.]*$/, ".toml"), text);
    pane("job");
  } catch (error) {
    tell(`${name}: ${error.message ?? error}`);
  }
}

function listen() {
  $("open").addEventListener("click", () => $("file-input").click());
  $("file-input").addEventListener("change", () => {
    take($("file-input").files);
    $("file-input").value = "";
  });
  let depth = 0;
  const over = (shown) => document.body.classList.toggle("dropping", shown);
  addEventListener("dragenter", (event) => {
    event.preventDefault();
    over(++depth > 0);
  });
  addEventListener("dragleave", () => over(--depth > 0));
  addEventListener("dragover", (event) => event.preventDefault());
  addEventListener("drop", (event) => {
    event.preventDefault();
    depth = 0;
    over(false);
    take(event.dataTransfer.files);
  }, true);
  addEventListener("paste", (event) => {
    if (event.clipboardData.files.length > 0) {
      event.preventDefault();
      take(event.clipboardData.files);
    } else if (!$("editor").contains(event.target)) {
      const text = event.clipboardData.getData("text/plain");
      if (/^\s*version\s*=/m.test(text)) setOwn("job.toml", text);
    }
  }, true);
  $("save").addEventListener("click", () => {
    const href = URL.createObjectURL(new Blob([editor.text], { type: "application/toml" }));
    make("a", { href, download: job.name }).click();
    setTimeout(() => URL.revokeObjectURL(href), 10_000);
  });
  $("revert").addEventListener("click", () => {
    saveJob(null);
    setJob(job.name, job.original, job.example);
  });
  $("plan").addEventListener("click", plan);
  $("cancel").addEventListener("click", () => engine.cancel());
  $("examples").addEventListener("change", () => {
    if ($("examples").value) example($("examples").value).catch((error) => tell(error.message));
  });
  addEventListener("keydown", (event) => {
    if (event.key === "Enter" && (event.ctrlKey || event.metaKey)) plan();
    if (event.key === "Escape" && !$("working").hidden) engine.cancel();
  });
  for (const button of document.querySelectorAll(".panes button")) {
    button.addEventListener("click", () => pane(button.dataset.pane));
  }
}

// ---- colours

function theme() {
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const apply = () => {
    const name = savedTheme() ?? (dark.matches ? "dark" : "light");
    document.documentElement.dataset.theme = name;
    $("theme").setAttribute("aria-pressed", name === "dark");
  };
  dark.addEventListener("change", apply);
  $("theme").addEventListener("click", () => {
    saveTheme(document.documentElement.dataset.theme === "dark" ? "light" : "dark");
    apply();
  });
  apply();
}

// ---- examples

async function example(id) {
  const known = examples.find((one) => one.id === id);
  if (!known) throw new Error(`there is no example ${id}; there are ${examples.map((one) => one.id).join(", ")}`);
  tell();
  const response = await fetch(`examples/${known.files[0]}`);
  if (!response.ok) throw new Error(`examples/${known.files[0]}: ${response.status}`);
  setJob(known.files[0], await response.text(), id);
}

async function start() {
  theme();
  listen();
  show("empty");
  const response = await fetch("examples.json");
  examples = response.ok ? await response.json() : [];
  $("examples").append(...examples.map(({ id, name, about }) => make("option", { value: id, title: about }, name)));
  surfaces.examples = examples.flatMap((one) => one.files.slice(1));
  const asked = new URLSearchParams(location.search).get("example");
  const saved = savedJob();
  if (saved && (!asked || asked === saved.example)) {
    if (saved.example && examples.some((one) => one.id === saved.example)) {
      await example(saved.example);
      setJob(saved.name, saved.text, saved.example, job.original);
    } else {
      setJob(saved.name, saved.text, null);
    }
  } else {
    await example(asked ?? "mould").catch((error) => tell(error.message));
  }
  const facts = await engine.facts();
  editor.schema = facts.schema;
  await check();
}

start().catch((error) => {
  $("verdict").textContent = "The planner cannot be loaded.";
  tell(error.message ?? String(error));
});
