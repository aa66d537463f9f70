// The page: a job and its surface in, a plan out.
import { $, bytes, make } from "./dom.js";
import { Editor, spoken } from "./editor.js";
import { CANCELLED, Engine } from "./engine.js";
import { Drafts, Surfaces, base, isJob, isMesh, isPost, isTools, saveTheme, savedTheme } from "./store.js";
import { Views } from "./views.js";

/** Rest after the last key before a job is checked, ms. */
const REST = 150;
/** Largest surface and job that a tab takes, bytes. */
const LARGEST = { surface: 1e9, job: 1e6 };
/** The example that the page begins with. */
const FIRST = "mould";

const engine = new Engine();
const surfaces = new Surfaces();
const drafts = new Drafts();
const views = new Views({ texture });
let examples = [];
/** The job as it is edited: its name, the example it came from, its text when it came. */
let job = { name: "job.toml", example: null, original: "" };
let checking = 0;
let checked = null;
/** The plan that is being made: what has been shown of it; null while none is. */
let run = null;
/** The text that the shown plan was made of. */
let planned = null;
/** The contents of the files that it names. */
let files = {};

const editor = new Editor($("editor"), engine, {
  changed(text, byUser) {
    const edited = text !== job.original;
    $("edited").hidden = !edited;
    $("revert").hidden = !edited || !job.example;
    $("stale").hidden = planned === null || text === planned;
    if (byUser) drafts.set(job.example ?? "", edited || !job.example ? { name: job.name, text, edited } : null);
    clearTimeout(checking);
    checking = setTimeout(check, REST);
  },
  plan: () => plan(),
});

// ---- the job

/** Shows a job. `original`: its text before it was edited; `visit`: how the address takes it. */
function setJob(name, text, example, { original = text, visit = "push" } = {}) {
  const isOther = name !== job.name || example !== job.example;
  if (isOther) {
    cancel();
    planned = null;
    show("empty");
  }
  job = { name, example, original };
  drafts.last = example ?? "";
  $("job-name").textContent = name;
  $("examples").value = example ?? "";
  document.title = `${name} – evencut`;
  if (isOther) editor.open(text);
  else editor.replace(text);
  editor.show([]);
  const url = new URL(location.href);
  if (example) url.searchParams.set("example", example);
  else url.searchParams.delete("example");
  if (url.href === location.href) return;
  if (visit === "push") history.pushState(null, "", url);
  else history.replaceState(null, "", url);
}

/** A job of the user's own; the edited one that gives way to it, as a message and what to do about it. */
function setOwn(name, text) {
  const before = drafts.get("");
  drafts.set("", { name, text });
  ownChoice();
  setJob(name, text, null);
  if (!before?.edited || before.text === text) return [];
  return [`${before.name} had edits and was replaced.`, [`Back to ${before.name}`, () => {
    setOwn(before.name, before.text);
    drafts.set("", before);
  }]];
}

/** The entry of the user's own job among the examples. */
function ownChoice() {
  $("examples").options[0].textContent = drafts.get("")?.name ?? "–";
}

/** Those of the named files that are here, with their contents. */
async function held(names) {
  const all = await Promise.all(names.map(async (name) => [name, await surfaces.bytes(name)]));
  return all.filter(([, bytes]) => bytes);
}

async function check() {
  const text = editor.text;
  let found;
  try {
    found = await engine.check(text, surfaces.names);
    const beside = await held(found.beside);
    if (beside.length > 0) found = await engine.check(text, surfaces.names, beside);
  } catch (error) {
    tell(error.message ?? String(error));
    return null;
  }
  if (text !== editor.text) return null;
  checked = found;
  editor.show(found.faults);
  showFaults(found.faults);
  showSurface(found);
  const bad = found.faults.some((fault) => fault.severity === "error");
  $("plan").disabled = bad;
  document.body.dataset.checked = bad ? "bad" : "good";
  return found;
}

function showFaults(faults) {
  const count = (severity) => faults.filter((fault) => fault.severity === severity).length;
  const words = (n, word) => `${n} ${word}${n === 1 ? "" : "s"}`;
  const [errors, warnings] = [count("error"), count("warning")];
  const said = errors ? [words(errors, "error")] : ["Ready to plan"];
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

/** What is known of a file that the job names. */
function known(name) {
  const given = surfaces.given(name);
  if (given) return bytes(given.length);
  return surfaces.isExample(name) ? "example" : "not here yet: drop the file on this page";
}

function showSurface({ surface: name, stock, avoid, post, beside, blades }) {
  const named = (what, file) => [make("span", {}, what), make("b", {}, file), make("span", {}, ` ${known(file)}`)];
  const said = name ? named("Surface ", name) : [make("span", {}, checked?.name ? "Surface by formula" : " ")];
  if (stock) said.push(...named(", out of ", stock));
  for (const file of avoid) said.push(...named(", clear of ", file));
  for (const blade of blades) said.push(...named(", blade ", blade));
  if (post) said.push(...named(", post ", post));
  for (const file of beside) said.push(...named(", with ", file));
  const { count } = surfaces;
  const forget = make("button", { type: "button", id: "forget", className: "quiet small", title: "Surfaces that you gave are kept in this browser. This removes them." },
    count === 1 ? "Forget the kept surface" : `Forget ${count} kept surfaces`);
  forget.addEventListener("click", async () => {
    await surfaces.forget();
    await check();
    $("plan").focus();
  });
  $("surface").replaceChildren(make("span", {}, ...said), ...(count > 0 ? [forget] : []));
}

// ---- planning

async function plan() {
  if (run) return;
  const own = { phase: null };
  run = own;
  const found = await check();
  if (!found || $("plan").disabled || run !== own) {
    if (run === own) run = null;
    return;
  }
  const text = editor.text;
  const { name } = job;
  begin();
  const start = performance.now();
  const ticking = setInterval(() => elapsed(start), 100);
  elapsed(start);
  const early = (part) => {
    if (run === own) present(own, part, name, text, part.report ? "planned" : "laid");
  };
  try {
    const one = async (file) => (file ? await surfaces.bytes(file) : null) ?? undefined;
    const contents = {
      surface: await one(found.surface),
      meshes: await held([...found.avoid, found.stock].filter(Boolean)),
      post: await one(found.post),
      beside: await held(found.beside),
      blades: await held(found.blades),
    };
    if (run !== own) return;
    files = contents;
    const whole = await engine.plan(name, text, files, { progress, early });
    if (run !== own) return;
    present(own, whole, name, text, "judged");
    say(`Planned and simulated. ${$("figures").innerText.replaceAll("\n", " ")}`);
    document.body.dataset.planned = name;
  } catch (error) {
    if (run === own && error !== CANCELLED) failed(error);
  } finally {
    clearInterval(ticking);
    if (run === own) end();
  }
}

function begin() {
  show("working");
  pane("result");
  views.clear();
  delete document.body.dataset.planned;
  planned = null;
  $("stale").hidden = true;
  $("progress").value = 0;
  $("stage").textContent = "Starting";
  const hadFocus = document.activeElement === $("plan");
  $("cancel").hidden = false;
  $("plan").hidden = true;
  if (hadFocus) $("cancel").focus();
}

function end() {
  run = null;
  $("working").hidden = true;
  $("cut-short").hidden = true;
  const hadFocus = [$("cancel"), $("stop")].includes(document.activeElement);
  $("plan").hidden = false;
  $("cancel").hidden = true;
  if (hadFocus) $("plan").focus();
}

/** Shows as much of a plan as there is. */
function present(own, part, name, text, phase) {
  own.phase = phase;
  planned = text;
  show(phase === "judged" ? "planned" : "early");
  document.body.dataset.shown = phase;
  views.show(part, name, phase);
  $("stale").hidden = editor.text === text;
  if (phase !== "judged") say(phase === "laid" ? "The path is laid" : "Planned; the simulation goes on");
}

/** Ends the plan that is being made. What is planned stays, what is only laid does not. */
function cancel() {
  if (!run) return;
  const { phase } = run;
  engine.cancel();
  end();
  if (phase === "planned") {
    show("planned");
    views.cut();
    $("cut-short").hidden = false;
  } else {
    planned = null;
    show("empty");
  }
  say("Cancelled");
}

function progress({ stage, done }) {
  $("stage").textContent = stage[0].toUpperCase() + stage.slice(1);
  // Stages may come again for what earlier passes left: the bar does not go back.
  $("progress").value = Math.max($("progress").value, done);
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
  planned = null;
  show("failure");
  if (fault) {
    editor.show([fault]);
    showFaults([fault]);
  }
}

/** Shows one part of the result: empty, working, early (working on what is shown), failure or planned. */
function show(part) {
  const isShown = part === "early" || part === "planned";
  $("empty").hidden = part !== "empty";
  $("working").hidden = part !== "working" && part !== "early";
  $("failure").hidden = part !== "failure";
  $("planned").hidden = !isShown;
  if (!isShown) delete document.body.dataset.shown;
  document.body.dataset.state = part;
}

function pane(name) {
  document.body.dataset.pane = name;
  for (const button of document.querySelectorAll(".panes button")) {
    button.setAttribute("aria-pressed", button.dataset.pane === name);
  }
}

/** A message that goes away with the next one, with things to do about it; nothing clears it. */
function tell(text = "", ...actions) {
  const buttons = actions.map(([label, act]) => {
    const button = make("button", { type: "button" }, label);
    button.addEventListener("click", () => {
      tell();
      act();
    });
    return button;
  });
  const row = buttons.length > 0 ? make("p", { className: "actions" }, ...buttons) : "";
  $("notice").replaceChildren(text, row);
  $("notice").hidden = !text;
}

/** For those who listen: what happens on the page. */
function say(text) {
  $("said").textContent = text;
}

/** Simulates what the teeth leave of the shown path about a place. */
function texture(path, at) {
  return engine.texture(planned, files, path, at);
}

// ---- files

/** The content of a file, or why it cannot be had. */
async function content(file) {
  const most = isJob(file.name) ? LARGEST.job : LARGEST.surface;
  if (file.size > most) return { name: file.name, trouble: `${bytes(file.size)} is too large for a browser tab; at most ${bytes(most)}` };
  try {
    return { name: file.name, bytes: new Uint8Array(await file.arrayBuffer()) };
  } catch {
    return { name: file.name, trouble: "it cannot be read; folders cannot be opened" };
  }
}

/** Takes files; `afresh`: a surface gets a job of its own, whatever is waited for. */
async function take(list, afresh = false) {
  tell();
  const all = [...list];
  const known = all.filter(({ name }) => isJob(name) || isMesh(name) || isPost(name) || isTools(name));
  const troubles = all.filter((file) => !known.includes(file))
    .map(({ name }) => `${name}: not a job (.toml), a surface (.stl, .obj, .ply, .off, .json, .step, .stp), a post (.post.toml), a machine (.machine.toml) or tools (.tools.toml, .fctb)`);
  const files = await Promise.all(known.map(content));
  troubles.push(...files.filter((file) => file.trouble).map(({ name, trouble }) => `${name}: ${trouble}`));
  const good = files.filter((file) => !file.trouble);
  const meshes = good.filter((file) => isMesh(file.name));
  const jobs = good.filter((file) => isJob(file.name));
  const actions = [];
  const open = (name, text) => {
    const [trouble, action] = setOwn(name, text);
    if (trouble) troubles.push(trouble);
    if (action) actions.push(action);
    pane("job");
  };
  for (const file of good.filter(({ name }) => !isJob(name))) {
    const stays = await surfaces.add(file.name, file.bytes);
    if (!stays) troubles.push(`${file.name}: too large, or not allowed, to be kept in this browser: it is gone when the page is closed`);
  }
  if (jobs.length > 1) troubles.push(`${jobs.slice(1).map(({ name }) => name).join(", ")}: one job at a time; ${jobs[0].name} was opened`);
  if (jobs.length > 0) {
    open(jobs[0].name, new TextDecoder().decode(jobs[0].bytes));
  } else if (meshes.length > 0) {
    await surfaceAlone(meshes, open, troubles, actions, afresh);
  }
  if (troubles.length > 0) tell(troubles.join("\n"), ...actions);
  await check();
}

/** A surface without a job: the job on the page may wait for it; otherwise a new one is opened. */
async function surfaceAlone(meshes, open, troubles, actions, afresh) {
  const found = await check();
  const wanted = found?.surface;
  const isGiven = (file) => file && meshes.some(({ name }) => base(file) === name) && !surfaces.isExample(file);
  const files = [wanted, found?.stock, found?.post, ...(found?.beside ?? []), ...(found?.avoid ?? []), ...(found?.blades ?? [])];
  if (files.some(isGiven)) return;
  // A job that can be read has no other error than that its surface is not here.
  const waits = wanted ? found.faults.find((fault) => fault.severity === "error") : null;
  const [mesh] = meshes;
  const missing = found?.beside.find((file) => !surfaces.given(file));
  if (!afresh && !job.example && missing) {
    troubles.push(`${job.name} waits for ${base(missing)}.`);
    actions.push([`New job for ${mesh.name}`, () => take([new File([mesh.bytes], mesh.name)], true)]);
    return;
  }
  if (!afresh && !job.example && waits && waits.from !== null) {
    troubles.push(`${job.name} asks for ${base(wanted)}, not for ${mesh.name}.`);
    actions.push(
      [`Use ${mesh.name} in ${job.name}`, () => editor.put(waits.from, waits.to, JSON.stringify(mesh.name))],
      [`New job for ${mesh.name}`, () => take([new File([mesh.bytes], mesh.name)], true)]);
    return;
  }
  try {
    open(mesh.name.replace(/\.[^.]*$/, ".toml"), await newJob(mesh));
  } catch (error) {
    troubles.push(`${mesh.name}: ${error.message ?? error}`);
  }
  if (meshes.length > 1) troubles.push(`A job has one surface: ${mesh.name} was taken.`);
}

/** A job for a surface, which takes a while for large ones. */
function newJob({ name, bytes: mesh }) {
  $("verdict").className = "";
  $("verdict").textContent = `Reading ${name} …`;
  return engine.newJob(name, mesh);
}

function listen() {
  $("open").addEventListener("click", () => $("file-input").click());
  $("file-input").addEventListener("change", () => {
    // The list empties with the input.
    take([...$("file-input").files]);
    $("file-input").value = "";
  });
  let depth = 0;
  const over = (shown) => document.body.classList.toggle("dropping", shown);
  const brings = (event) => [...(event.dataTransfer?.types ?? [])].includes("Files");
  addEventListener("dragenter", (event) => {
    if (!brings(event)) return;
    event.preventDefault();
    over(++depth > 0);
  });
  addEventListener("dragleave", (event) => {
    if (brings(event)) over(--depth > 0);
  });
  addEventListener("dragover", (event) => {
    if (brings(event)) event.preventDefault();
  });
  addEventListener("drop", (event) => {
    if (!brings(event)) return;
    event.preventDefault();
    event.stopPropagation();
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
      if (/^\s*version\s*=/m.test(text)) tell(...setOwn("job.toml", text));
      else if (text.trim()) tell("What was pasted is not a job: a job has a line such as version = 1.");
    }
  }, true);
  $("save").addEventListener("click", () => {
    const href = URL.createObjectURL(new Blob([editor.text], { type: "application/toml" }));
    make("a", { href, download: job.name }).click();
    setTimeout(() => URL.revokeObjectURL(href), 10_000);
  });
  $("revert").addEventListener("click", () => {
    drafts.set(job.example ?? "", null);
    setJob(job.name, job.original, job.example);
  });
  $("plan").addEventListener("click", plan);
  for (const id of ["cancel", "stop"]) $(id).addEventListener("click", cancel);
  $("examples").addEventListener("change", () => visit($("examples").value, "push"));
  addEventListener("popstate", () => visit(asked() ?? "", "stay"));
  addEventListener("keydown", (event) => {
    if (event.key === "Enter" && (event.ctrlKey || event.metaKey)) plan();
    if (event.key === "Escape" && !event.defaultPrevented) cancel();
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

const asked = () => new URLSearchParams(location.search).get("example");

/** Shows an example as it was edited last, or the user's own job where `id` is empty. */
async function example(id, visit) {
  const draft = drafts.get(id);
  if (id === "") {
    if (draft) setJob(draft.name, draft.text, null, { visit });
    return;
  }
  const known = examples.find((one) => one.id === id);
  if (!known) throw new Error(`there is no example ${id}; there are ${examples.map((one) => one.id).join(", ")}`);
  const response = await fetch(`examples/${known.files[0]}`);
  if (!response.ok) throw new Error(`examples/${known.files[0]}: ${response.status}`);
  const original = await response.text();
  setJob(known.files[0], draft?.text ?? original, id, { original, visit });
}

/** As `example`, and what is wrong is shown; whether nothing was. */
async function visit(id, how) {
  tell();
  try {
    await example(id, how);
    await check();
    return true;
  } catch (error) {
    $("examples").value = job.example ?? "";
    const isAway = error instanceof TypeError;
    tell(isAway ? "The example cannot be loaded: the server of this page does not answer." : error.message);
    return false;
  }
}

async function start() {
  theme();
  listen();
  show("empty");
  const [response] = await Promise.all([fetch("examples.json"), surfaces.restore()]);
  examples = response.ok ? await response.json() : [];
  $("examples").append(...examples.map(({ id, name, about }) => make("option", { value: id, title: about }, name)));
  surfaces.examples = examples.flatMap((one) => one.files.slice(1));
  ownChoice();
  const isThere = (id) => (id === "" ? drafts.get("") !== null : examples.some((one) => one.id === id));
  const last = isThere(drafts.last) ? drafts.last : FIRST;
  if (!(await visit(asked() ?? last, "replace"))) await example(FIRST, "replace");
  await check();
}

start().catch((error) => {
  $("verdict").textContent = "The planner cannot be loaded.";
  tell(error.message ?? String(error));
});
