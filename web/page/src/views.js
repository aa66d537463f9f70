// The result: figures, pictures that are linked with each other, playback, report and files.
import { $, bytes, clock, make, short } from "./dom.js";
import { Lookup, projector } from "./lookup.js";
import { Path } from "./path.js";
import { Picture } from "./picture.js";

const PICTURES = [
  { id: "flat", label: "Flat map", file: "flat.svg", table: "flat", size: 2 },
  { id: "surface", label: "Surface", file: "surface.svg", table: "contact", size: 3 },
  { id: "scallop", label: "Height left", file: "scallop.svg", table: "contact", size: 3 },
  { id: "removal", label: "Measured rate", file: "removal.svg", table: "contact", size: 3 },
];
const OTHERS = [
  { id: "space", label: "3D" },
  { id: "report", label: "Report" },
  { id: "files", label: "Files" },
];
const WORDS = {
  cut: "pass", trochoid: "trochoid", return: "trochoid return", link: "link", rapid: "rapid",
};
const MEDIA = { svg: "image/svg+xml", html: "text/html", json: "application/json", csv: "text/csv", toml: "application/toml" };
/** The beginning of a file's SHA-256, all of it on demand, where the browser lends its own. */
function digest(content) {
  const code = make("code", {}, "–");
  globalThis.crypto?.subtle?.digest("SHA-256", content).then((sum) => {
    code.title = Array.from(new Uint8Array(sum), (byte) => byte.toString(16).padStart(2, "0")).join("");
    code.textContent = code.title.slice(0, 16);
  });
  return code;
}

/** Length of the bright tail behind the cutter, s. */
const TAIL = 2;

export class Views {
  #plan = null;
  #path = null;
  #lookups = new Map();
  #urls = [];
  #tab = "flat";
  #time = 0;
  #pointed = null;
  #space = null;
  #playing = 0;

  constructor() {
    this.picture = new Picture($("picture"), "Picture of the path", {
      hover: (at, reach) => this.#hover(at, reach),
      pick: (at, reach) => this.#pick(at, reach),
      view: () => this.#marks(),
    });
    this.chart = new Picture($("chart"), "Removal rate along time", {
      quietWheel: true,
      hover: (at) => this.#hoverChart(at),
      pick: (at) => this.#go(this.#timeOf(at)),
      drag: (at) => this.#go(this.#timeOf(at)),
      view: () => this.#marks(),
    });
    $("time").addEventListener("input", () => this.#go(Number($("time").value)));
    $("play").addEventListener("click", () => this.#toggle());
    $("compare").addEventListener("click", () => this.#compare());
    this.#stop();
  }

  show(plan, jobName) {
    this.clear();
    this.#plan = plan;
    this.#path = new Path(plan);
    this.jobName = jobName;
    $("time").max = this.#path.duration;
    $("time").step = Math.max(this.#path.duration / 5000, 1e-3);
    this.report = JSON.parse(new TextDecoder().decode(this.#file("report.json")));
    this.#figures();
    this.#report();
    this.#files();
    this.#tabs();
    this.#chart(false);
    this.#open(this.#names().includes(this.#tab) ? this.#tab : this.#names()[0]);
    this.#go(0.35 * this.#path.duration);
  }

  clear() {
    this.#stop();
    this.#space?.dispose();
    this.#space = null;
    this.#lookups.clear();
    this.#urls.forEach((url) => URL.revokeObjectURL(url));
    this.#urls = [];
    this.#plan = null;
  }

  #file(name) {
    return this.#plan.files.find((file) => file.name === name)?.bytes;
  }

  #names() {
    return [...PICTURES.filter((p) => this.#file(p.file)), ...OTHERS].map((view) => view.id);
  }

  // ---- figures

  #figures() {
    const { plain, slowed, delivered, verification: v } = this.report;
    const time = clock(delivered.time_s.total);
    const tiles = [
      ["Time", time, "min", slowed ? `slowed passes: ${clock(slowed.time_s.total)}` : `${short(delivered.length_mm.total / 1000)} m`],
    ];
    if (v?.mrr && plain) {
      const share = v.mrr.peak_over_limit;
      tiles.push(["Peak rate", `${Math.round(100 * share)}`, "% of the limit", `plain passes: ${Math.round(100 * plain.peak_over_limit)} %`]);
    }
    if (v) {
      const { scallop } = v;
      const rest = scallop.limit_mm === null ? "" : `limit ${short(1e3 * scallop.limit_mm)} + ${short(1e3 * scallop.tolerance_mm)} µm`;
      tiles.push(["Height left", short(1e3 * scallop.largest_mm), "µm", rest]);
      tiles.push(["Gouge", v.gouge_mm < -scallop.tolerance_mm ? short(-1e3 * v.gouge_mm) : "none", v.gouge_mm < -scallop.tolerance_mm ? "µm" : "", `deepest ${short(Math.max(0, -1e3 * v.gouge_mm))} µm`]);
      const passed = v.passed;
      tiles.push(["Limits", passed ? "kept" : "broken", "", passed ? "measured by simulation" : v.broken.join("; "), passed ? "good" : "bad"]);
    }
    $("figures").replaceChildren(...tiles.map(([name, value, unit, note, tone]) =>
      make("div", { className: tone ?? "" },
        make("dt", {}, name),
        make("dd", {}, make("strong", {}, value), unit ? ` ${unit}` : ""),
        make("dd", { className: "note", title: note }, note))));
  }

  #report() {
    const { warnings, verification } = this.report;
    const broken = (verification?.broken ?? []).map((text) => make("p", { className: "callout bad" }, make("b", {}, "Broken: "), text));
    const list = warnings.map(({ stage, message, remedy }) =>
      make("p", { className: "callout" }, make("b", {}, `${stage}: `), message, remedy ? make("span", { className: "remedy" }, `Remedy: ${remedy}`) : ""));
    // The warnings follow as a list.
    const summary = this.#plan.summary.split(/\n\s*warning: /)[0].trimEnd();
    const seconds = `Planned and simulated here in ${this.#plan.seconds.toFixed(1)} s.`;
    $("report").replaceChildren(...broken, make("pre", {}, summary), ...list, make("p", { className: "faint" }, seconds));
  }

  #files() {
    const link = ({ name, bytes: content }) => {
      const type = MEDIA[name.split(".").pop()] ?? "text/plain";
      const href = URL.createObjectURL(new Blob([content], { type }));
      this.#urls.push(href);
      return make("a", { href, download: name }, name);
    };
    const rows = this.#plan.files.map((file) =>
      make("tr", {},
        make("th", { scope: "row" }, link(file)),
        make("td", { className: "number" }, bytes(file.bytes.length)),
        make("td", {}, digest(file.bytes))));
    const all = make("a", { className: "button primary", id: "zip" }, "Download all (zip)");
    const head = make("tr", {}, ...["File", "Size", "SHA-256 begins"].map((text, i) => make("th", { scope: "col", className: i === 1 ? "number" : "" }, text)));
    $("files").replaceChildren(
      make("p", { className: "lead" }, all, make("span", { className: "faint" }, " The same bytes as the command writes.")),
      make("table", {}, make("thead", {}, head), make("tbody", {}, ...rows)));
  }

  /** Makes the zip when the files are looked at first. */
  async #zip() {
    const link = $("zip");
    if (link.href) return;
    const plan = this.#plan;
    const { zipSync } = await import("fflate");
    if (plan !== this.#plan || link.href) return;
    const folder = this.jobName.replace(/\.toml$/, "");
    const entries = plan.files.map(({ name, bytes: content }) => [`${folder}/${name}`, content]);
    // A fixed time, so that the same plan gives the same zip.
    const zip = zipSync(Object.fromEntries(entries), { level: 6, mtime: new Date(1980, 0, 1) });
    link.download = `${folder}.zip`;
    link.href = URL.createObjectURL(new Blob([zip], { type: "application/zip" }));
    link.append(`, ${bytes(zip.length)}`);
    this.#urls.push(link.href);
  }

  // ---- tabs

  #tabs() {
    const names = this.#names();
    const tabs = [...PICTURES, ...OTHERS].filter((view) => names.includes(view.id)).map((view) => {
      const tab = make("button", { type: "button", id: `tab-${view.id}`, data: { view: view.id } }, view.label);
      tab.setAttribute("role", "tab");
      tab.setAttribute("aria-controls", "panel");
      tab.addEventListener("click", () => this.#open(view.id));
      return tab;
    });
    $("tabs").replaceChildren(...tabs);
    $("tabs").onkeydown = (event) => {
      const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
      if (!step) return;
      event.preventDefault();
      const next = (names.indexOf(this.#tab) + step + names.length) % names.length;
      this.#open(names[next]);
      $(`tab-${names[next]}`).focus();
    };
  }

  #open(id) {
    this.#tab = id;
    for (const tab of $("tabs").children) {
      const own = tab.dataset.view === id;
      tab.setAttribute("aria-selected", own);
      tab.tabIndex = own ? 0 : -1;
    }
    $("panel").setAttribute("aria-labelledby", `tab-${id}`);
    const picture = PICTURES.find((view) => view.id === id);
    $("picture").hidden = !picture;
    for (const other of OTHERS) $(other.id).hidden = other.id !== id;
    $("linked").hidden = id === "files" || id === "report";
    $("legend").hidden = !picture;
    if (picture) {
      const placement = this.#path.scales.pictures[picture.file];
      const { legend, caption } = this.picture.show(this.#file(picture.file), { placement, unit: picture.size === 2 ? "mm (flat)" : "mm" });
      $("legend").replaceChildren(legend, make("p", { className: "faint" }, caption));
      $("picture").setAttribute("aria-label", `${picture.label}: arrow keys move, plus and minus zoom, 0 shows all`);
    }
    if (id === "space") this.#turnable();
    if (id === "files") this.#zip();
    this.#pointed = null;
    this.#marks();
  }

  async #turnable() {
    if (this.#space) {
      this.#space.show(this.#path.at(this.#time));
      return;
    }
    const plan = this.#plan;
    $("space").replaceChildren(make("p", { className: "hint" }, "Loading …"));
    try {
      const { Space } = await import("./space.js");
      if (plan !== this.#plan || this.#space) return;
      this.#space = new Space($("space"), this.#path);
      this.#space.show(this.#path.at(this.#time));
    } catch (error) {
      $("space").replaceChildren(make("p", { className: "hint" }, `No three dimensions here: ${error.message}`));
    }
  }

  // ---- linked places

  #lookup(view) {
    if (!this.#lookups.has(view.id)) {
      const placement = this.#path.scales.pictures[view.file];
      this.#lookups.set(view.id, new Lookup(this.#path, view.table, view.size, placement));
    }
    return this.#lookups.get(view.id);
  }

  #found(at, reach) {
    const view = PICTURES.find((picture) => picture.id === this.#tab);
    const found = at && view && this.#path ? this.#lookup(view).nearest(at[0], at[1], reach) : null;
    return found && { ...found, time: this.#path.timeAt(found.index, found.part) };
  }

  #hover(at, reach) {
    this.#pointed = this.#found(at, reach);
    this.#marks();
  }

  #pick(at, reach) {
    const found = this.#found(at, reach);
    if (found) this.#go(found.time);
  }

  #timeOf([x]) {
    const { panels, size, duration } = this.#path.scales.chart;
    const time = ((x - panels[1][0]) / size[0]) * duration;
    return Math.min(Math.max(time, 0), this.#path.duration);
  }

  #hoverChart(at) {
    const { panels, size } = this.#path?.scales.chart ?? {};
    const inside = at && panels && at[0] >= panels[1][0] && at[0] <= panels[1][0] + size[0] && at[1] >= panels[1][1] - 24;
    this.#pointed = inside ? this.#path.at(this.#timeOf(at)) : null;
    this.#marks();
  }

  #go(time) {
    this.#time = time;
    this.#pointed = null;
    $("time").value = time;
    this.#marks();
    this.#space?.show(this.#path.at(time));
  }

  /** Draws what is pointed at and where playback is, in all views. */
  #marks() {
    if (!this.#path || !this.#plan) return;
    const now = this.#path.at(this.#time);
    const view = PICTURES.find((picture) => picture.id === this.#tab);
    if (view) {
      const project = projector(this.#path.scales.pictures[view.file]);
      const placed = (place) => {
        const at = place && this.#path.vector(view.table, place, view.size);
        return at && project(at).slice(0, 2);
      };
      this.picture.mark({ trail: this.#trail(view, project), dot: placed(now), hover: placed(this.#pointed) });
    }
    const { panels, size, duration } = this.#path.scales.chart;
    const x = (time) => panels[1][0] + (size[0] * time) / duration;
    this.chart.mark({
      line: {
        x: x(now.time),
        hover: this.#pointed && x(this.#pointed.time),
        range: [panels[1][1], panels[1][1] + size[1]],
      },
    });
    if (this.#space && this.#pointed) this.#space.show(this.#pointed);
    this.#readout(this.#path.values(this.#pointed ?? now));
    const text = `${clock(now.time)} / ${clock(this.#path.duration)}`;
    $("clock").value = text;
    $("time").setAttribute("aria-valuetext", text);
  }

  #trail(view, project) {
    const now = this.#path.at(this.#time);
    const first = this.#path.at(Math.max(0, this.#time - TAIL)).index;
    const values = this.#path.tables[view.table];
    const points = [];
    for (let i = first; i < now.index; i++) {
      const p = project(values.subarray(view.size * i, view.size * i + view.size));
      if (Number.isFinite(p[0])) points.push(p);
    }
    const end = this.#path.vector(view.table, now, view.size);
    return end ? [...points, project(end)] : points;
  }

  #readout(v) {
    const height = v.state === 1 ? "untouched" : v.state === 2 ? "too tight" : v.residual === null ? "–" : `${short(v.residual)} µm`;
    const cells = [
      ["Rate", `${short(v.rate)} mm³/min`, Number.isFinite(v.share) ? `${Math.round(100 * v.share)} % of limit` : ""],
      ["Engagement", `${short(v.engagement)}°`, ""],
      ["Height left", height, ""],
      ["Feed", `${short(v.feed)} mm/min`, ""],
      ["Pass", `${v.pass}`, WORDS[v.kind]],
      ["Region", `${v.region}`, ""],
    ];
    const readout = $("readout");
    if (readout.children.length !== cells.length) {
      readout.replaceChildren(...cells.map(([name]) => make("div", { data: { name } }, make("dt", {}, name), make("dd", {}))));
    }
    cells.forEach(([, value, note], i) => {
      readout.children[i].lastChild.replaceChildren(value, note ? make("small", {}, ` ${note}`) : "");
    });
    readout.classList.toggle("pointed", this.#pointed !== null);
  }

  // ---- chart and playback

  #chart(all) {
    const file = this.#file("mrr.svg");
    $("chart").hidden = !file;
    if (!file) return;
    const { panels, size } = this.#path.scales.chart;
    // The delivered path's panel with its heading and both its axes.
    const crop = [20, panels[1][1] - 8, 890, size[1] + 36];
    this.chart.show(file, { crop: all ? undefined : crop });
    const above = [...$("chart").querySelectorAll("text")].filter((text) => Number(text.getAttribute("y")) < panels[1][1]);
    const heading = above.find((text) => text.textContent.startsWith("Delivered path"))?.textContent ?? "";
    $("chart-title").textContent = all ? "" : `Removal rate, mm³/min. ${heading}`;
    $("chart-title").title = heading;
    if (!all) above.forEach((text) => text.remove());
    $("compare").setAttribute("aria-pressed", all);
    $("chart").classList.toggle("all", all);
    this.#marks();
  }

  #compare() {
    this.#chart($("compare").getAttribute("aria-pressed") !== "true");
  }

  #toggle() {
    if (this.#playing) {
      this.#stop();
      return;
    }
    if (this.#time >= this.#path.duration) this.#go(0);
    this.#button(true);
    let last = performance.now();
    const step = (now) => {
      const time = this.#time + ((now - last) / 1000) * Number($("speed").value);
      last = now;
      this.#go(Math.min(time, this.#path.duration));
      if (time >= this.#path.duration) this.#stop();
      else this.#playing = requestAnimationFrame(step);
    };
    this.#playing = requestAnimationFrame(step);
  }

  #stop() {
    cancelAnimationFrame(this.#playing);
    this.#playing = 0;
    this.#button(false);
  }

  #button(playing) {
    $("play").setAttribute("aria-label", playing ? "Pause" : "Play");
    $("play").dataset.playing = playing;
  }
}
