// The result: figures, pictures that are linked with each other, playback, report and files.
import { $, bytes, clock, make, short } from "./dom.js";
import { Lookup, projector } from "./lookup.js";
import { Path } from "./path.js";
import { Picture, legendOf, svgOf, titleOf } from "./picture.js";

const PICTURES = [
  { id: "flat", label: "Flat map", file: "flat.svg", table: "flat", size: 2 },
  { id: "surface", label: "Surface", file: "surface.svg", table: "contact", size: 3 },
  { id: "scallop", label: "Height left", file: "scallop.svg", table: "contact", size: 3 },
  { id: "removal", label: "Measured rate", file: "removal.svg", table: "contact", size: 3 },
];
const OTHERS = [
  { id: "space", label: "3D" },
  { id: "texture", label: "Texture" },
  { id: "report", label: "Report" },
  { id: "files", label: "Files" },
];
/** The chart under the pictures. */
const CHART = "mrr.svg";
/** What the teeth leave, and the picture on which its place is chosen. */
const TEXTURE = "texture.svg";
const MAP = { file: "surface.svg", table: "contact", size: 3 };
/** What surface and path may be coloured by in three dimensions. */
const SURFACES = [
  { id: "plain", label: "plain" },
  { id: "height", label: "height" },
  { id: "residual", label: "height left", file: "scallop.svg" },
  { id: "rate", label: "measured rate", file: "removal.svg" },
];
const LINES = [{ id: "scale", label: "" }, { id: "plain", label: "one colour" }, { id: "none", label: "hidden" }];
const WORDS = {
  cut: "", trochoid: "trochoid", return: "trochoid return", link: "link", rapid: "rapid",
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
  #pictures = [];
  #lookups = new Map();
  #urls = [];
  #tab = "flat";
  #time = 0;
  #pointed = null;
  #space = null;
  #playing = 0;
  #simulated = null;

  /** `on.texture(path, at)` simulates the texture of a path, its toolpath.csv, about a place. */
  constructor(on) {
    this.on = on;
    this.map = new Picture($("texture-map"), "Surface on which to choose a point", {
      pick: (at, reach) => this.#chosen(at, reach),
      view: () => this.#window(),
    });
    $("texture-here").addEventListener("click", () => this.#textured(this.#path.vector("contact", this.#path.at(this.#time))));
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
    for (const id of ["space-surface", "space-lines"]) $(id).addEventListener("change", () => this.#colour(id));
    this.#stop();
  }

  /** Shows a plan, or as much of one as there is: `phase` is laid, planned or judged. */
  show(plan, jobName, phase) {
    const follows = this.#plan !== null;
    const part = follows && this.#path.duration ? this.#time / this.#path.duration : 0.35;
    if (phase !== "judged" || !follows) this.#stop();
    this.#plan = plan;
    this.#path = new Path(plan);
    this.#lookups.clear();
    this.#free();
    this.report = plan.report;
    this.jobName = jobName;
    this.phase = phase;
    this.#pictures = this.#known();
    $("planned").dataset.phase = phase;
    $("time").max = this.#path.duration;
    $("time").step = Math.max(this.#path.duration / 5000, 1e-3);
    this.#figures();
    if (plan.report) {
      this.#report();
      this.#files();
    }
    this.#texture();
    this.#tabs();
    this.#chart(follows && $("compare").getAttribute("aria-pressed") === "true");
    this.#space?.load(this.#path);
    this.#open(this.#names().includes(this.#tab) ? this.#tab : this.#names()[0], follows);
    this.#go(part * this.#path.duration);
  }

  /** Says that what is shown will not be simulated. */
  cut() {
    this.phase = "cut";
    $("planned").dataset.phase = this.phase;
    this.#figures();
    this.#report();
    this.#files();
  }

  clear() {
    this.#stop();
    this.#space?.dispose();
    this.#space = null;
    this.#lookups.clear();
    this.#free();
    this.#plan = null;
  }

  #free() {
    this.#urls.forEach((url) => URL.revokeObjectURL(url));
    this.#urls = [];
  }

  #file(name) {
    return this.#plan.files.find((file) => file.name === name)?.bytes;
  }

  /** The pictures that are there: those the page knows, and any others by their own titles. */
  #known() {
    const placed = this.#path.scales.pictures;
    const others = this.#plan.files
      .filter(({ name }) => name.endsWith(".svg") && ![CHART, TEXTURE].includes(name) && !PICTURES.some((p) => p.file === name))
      .map(({ name: file, bytes: content }) => {
        const isFlat = placed[file]?.near.every((x) => x === 0);
        const stem = file.slice(0, -4);
        const label = stem[0].toUpperCase() + stem.slice(1).replaceAll("-", " ");
        return { id: `picture-${stem}`, label, file, title: titleOf(content), table: isFlat ? "flat" : "contact", size: isFlat ? 2 : 3 };
      });
    return [...PICTURES.filter((p) => this.#file(p.file)), ...others];
  }

  #views() {
    const others = OTHERS.filter(({ id }) => id === "space" || this.report);
    return [...this.#pictures, ...others];
  }

  #names() {
    return this.#views().map((view) => view.id);
  }

  // ---- figures

  #figures() {
    const tiles = this.report ? this.#tiles(this.report) : [["Time", "…", "", ""]];
    if (this.phase === "laid" && this.#path.scales.limit !== null) tiles.push(["Peak rate", "…", "", ""]);
    if (this.phase !== "judged") {
      const note = { laid: "", planned: "simulating", cut: "not simulated" }[this.phase];
      const value = this.phase === "cut" ? "–" : "…";
      for (const name of ["Height left", "Gouge", "Limits"]) tiles.push([name, value, "", note]);
    }
    $("figures").replaceChildren(...tiles.map(([name, value, unit, note, tone]) =>
      make("div", { className: tone ?? "" },
        make("dt", {}, name),
        make("dd", {}, make("strong", {}, value), unit ? ` ${unit}` : ""),
        make("dd", { className: "note", title: note }, note))));
  }

  #tiles({ plain, slowed, delivered, verification: v }) {
    const time = clock(delivered.time_s.total);
    const tiles = [
      ["Time", time, "min", slowed ? `slowed passes: ${clock(slowed.time_s.total)}` : `${short(delivered.length_mm.total / 1000)} m`],
    ];
    const percent = (share) => `${Math.round(100 * share)}`;
    const share = v?.mrr?.peak_over_limit ?? delivered.peak_over_limit;
    if (plain && share !== undefined) {
      tiles.push(["Peak rate", percent(share), "% of the limit", v ? `plain passes: ${percent(plain.peak_over_limit)} %` : "predicted"]);
    }
    if (v) {
      const { scallop } = v;
      const rest = scallop.limit_mm === null ? "" : `limit ${short(1e3 * scallop.limit_mm)} + ${short(1e3 * scallop.tolerance_mm)} µm`;
      tiles.push(["Height left", short(1e3 * scallop.largest_mm), "µm", rest]);
      tiles.push(["Gouge", v.gouge_mm < -scallop.tolerance_mm ? short(-1e3 * v.gouge_mm) : "none", v.gouge_mm < -scallop.tolerance_mm ? "µm" : "", `deepest ${short(Math.max(0, -1e3 * v.gouge_mm))} µm`]);
      tiles.push(["Limits", v.passed ? "kept" : "broken", "", v.passed ? "measured by simulation" : v.broken.join("; "), v.passed ? "good" : "bad"]);
    }
    return tiles;
  }

  #report() {
    const { warnings, verification } = this.report;
    const broken = (verification?.broken ?? []).map((text) => make("p", { className: "callout bad" }, make("b", {}, "Broken: "), text));
    const list = warnings.map(({ stage, message, remedy }) =>
      make("p", { className: "callout" }, make("b", {}, `${stage}: `), message, remedy ? make("span", { className: "remedy" }, `Remedy: ${remedy}`) : ""));
    // The warnings follow as a list.
    const summary = this.#plan.summary.split(/\n\s*warning: /)[0].trimEnd();
    const done = this.phase === "judged" ? "Planned and simulated" : "Planned, not yet simulated,";
    const seconds = `${done} here in ${this.#plan.seconds.toFixed(1)} s.`;
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
    const isWhole = this.phase === "judged";
    const all = isWhole ? make("a", { className: "button primary", id: "zip" }, "Download all (zip)") : null;
    const said = isWhole ? " Identical to the files that the command line writes."
      : `Without reports and measured pictures${this.phase === "cut" ? "." : ", which follow when the simulation is done."}`;
    const head = make("tr", {}, ...["File", "Size", "SHA-256 begins"].map((text, i) => make("th", { scope: "col", className: i === 1 ? "number" : "" }, text)));
    $("files").replaceChildren(
      make("p", { className: "lead" }, all, make("span", { className: "faint" }, said)),
      make("table", {}, make("thead", {}, head), make("tbody", {}, ...rows)));
  }

  /** Makes the zip when the files are looked at first. */
  async #zip() {
    const link = $("zip");
    if (!link || link.href) return;
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
    const focused = document.activeElement?.dataset.view;
    const tabs = this.#views().map((view) => {
      const tab = make("button", { type: "button", id: `tab-${view.id}`, title: view.title ?? "", data: { view: view.id } }, view.label);
      tab.setAttribute("role", "tab");
      tab.setAttribute("aria-controls", "panel");
      tab.addEventListener("click", () => this.#open(view.id));
      return tab;
    });
    $("tabs").replaceChildren(...tabs);
    if (focused && names.includes(focused)) $(`tab-${focused}`).focus();
    $("tabs").onkeydown = (event) => {
      const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
      if (!step) return;
      event.preventDefault();
      const next = (names.indexOf(this.#tab) + step + names.length) % names.length;
      this.#open(names[next]);
      $(`tab-${names[next]}`).focus();
    };
  }

  #open(id, keep = false) {
    const stays = keep && id === this.#tab;
    this.#tab = id;
    for (const tab of $("tabs").children) {
      const own = tab.dataset.view === id;
      tab.setAttribute("aria-selected", own);
      tab.tabIndex = own ? 0 : -1;
    }
    $("panel").setAttribute("aria-labelledby", `tab-${id}`);
    const picture = this.#view();
    $("picture").hidden = !picture;
    for (const other of OTHERS) $(other.id).hidden = other.id !== id;
    $("linked").hidden = id === "files" || id === "report";
    $("legend").hidden = !picture && id !== "space";
    if (picture) {
      const placement = this.#path.scales.pictures[picture.file];
      const unit = picture.size === 2 ? "mm (flat)" : "mm";
      const { legend, caption } = this.picture.show(this.#file(picture.file), { placement: placement ?? undefined, unit, keep: stays });
      $("legend").hidden = !legend;
      $("legend").replaceChildren(legend ?? "", make("p", { className: "faint" }, caption ?? ""));
      $("picture").setAttribute("aria-label", `${picture.label}: arrow keys move, plus and minus zoom, 0 shows all`);
    }
    if (id === "space") this.#turnable();
    if (id === "texture") this.#choose(stays);
    if (id === "files") this.#zip();
    this.#pointed = null;
    this.#marks();
  }

  /** The picture that is shown, if it is one. */
  #view() {
    return this.#pictures.find((picture) => picture.id === this.#tab);
  }

  async #turnable() {
    this.#choices();
    if (!this.#space) {
      const plan = this.#plan;
      $("stage3d").replaceChildren(make("p", { className: "hint" }, "Loading …"));
      try {
        const { Space } = await import("./space.js");
        if (!this.#plan || this.#space) return;
        this.#space = new Space($("stage3d"));
        this.#space.load(this.#path);
      } catch (error) {
        if (plan === this.#plan) $("stage3d").replaceChildren(make("p", { className: "hint" }, `The 3D view is not available here: ${error.message}`));
        return;
      }
    }
    this.#colour();
    if (this.phase !== "laid") this.#space.show(this.#path.at(this.#time));
  }

  /** Fills the menus of what is coloured in three dimensions. */
  #choices() {
    const there = SURFACES.filter((one) => !one.file || this.#file(one.file));
    const timed = this.#path.scales.limit === null ? "by time" : "by rate";
    for (const [id, all] of [["space-surface", there], ["space-lines", LINES]]) {
      const chosen = $(id).value;
      $(id).replaceChildren(...all.map((one) => make("option", { value: one.id }, one.label || timed)));
      if (all.some((one) => one.id === chosen)) $(id).value = chosen;
    }
  }

  /** Colours what is chosen in three dimensions. A coloured surface is not hidden under lines, unless asked for. */
  #colour(changed) {
    if (changed === "space-surface") $("space-lines").value = $("space-surface").value === "plain" ? "scale" : "none";
    if (!this.#space) return;
    const [surface, lines] = [$("space-surface").value, $("space-lines").value];
    this.#space.colour(surface, lines);
    const chosen = SURFACES.find((one) => one.id === surface);
    const pictured = [chosen?.file, lines === "scale" ? "surface.svg" : null].filter((file) => file && this.#file(file));
    const legends = pictured.map((file) => legendOf(this.#file(file), this.#path.scales.pictures[file]));
    if (surface === "height") legends.unshift(this.#space.heights());
    $("legend").replaceChildren(...legends);
    $("legend").hidden = legends.length === 0;
  }

  // ---- texture

  /** The texture that came with the plan, or how to get one. */
  #texture() {
    this.#simulated = null;
    const own = this.#file(TEXTURE);
    delete $("texture-result").dataset.at;
    const hint = "Click a point on the surface to simulate the tooth marks there: heights, Sa, Rz.";
    $("texture-result").replaceChildren(own ? svgOf(own) : make("p", { className: "faint" }, hint));
  }

  /** Shows the surface on which a place is chosen. */
  #choose(keep) {
    const placement = this.#path.scales.pictures[MAP.file];
    const picture = this.#file(MAP.file);
    $("texture-map").hidden = !picture || !placement;
    if (picture && placement) this.map.show(picture, { placement, unit: "mm", keep });
    this.#window();
  }

  /** Marks the place of the window. */
  #window() {
    const placement = this.#path?.scales.pictures[MAP.file];
    if (!placement) return;
    const at = this.#simulated ?? this.report?.texture?.window.middle_mm;
    this.map.mark({ dot: at ? projector(placement)(at).slice(0, 2) : null });
  }

  #chosen(at, reach) {
    this.#lookups.get("texture") ?? this.#lookups.set("texture", new Lookup(this.#path, MAP.table, MAP.size, this.#path.scales.pictures[MAP.file]));
    const found = this.#lookups.get("texture").nearest(at[0], at[1], 4 * reach);
    if (found) this.#textured(this.#path.vector("contact", found));
  }

  /** Simulates the texture about a place. */
  async #textured(at) {
    if (!at || this.phase === "laid") return;
    this.#simulated = at;
    this.#window();
    const plan = this.#plan;
    $("texture").setAttribute("aria-busy", "true");
    const place = at.map((x) => short(x)).join(", ");
    $("texture-result").replaceChildren(make("p", { className: "faint", role: "status" }, `Simulating the tooth marks at (${place}) mm …`));
    try {
      const { files, summary } = await this.on.texture(this.#file("toolpath.csv"), at);
      if (plan !== this.#plan) return;
      const held = Object.fromEntries(files.map(({ name, bytes: content }) => [name, content]));
      const links = files.filter(({ name }) => name !== TEXTURE).map(({ name, bytes: content }) => {
        const href = URL.createObjectURL(new Blob([content]));
        this.#urls.push(href);
        return make("a", { href, download: name }, name);
      });
      $("texture-result").dataset.at = at.join(",");
      $("texture-result").replaceChildren(make("pre", {}, summary), svgOf(held[TEXTURE]), make("p", { className: "links" }, ...links));
    } catch (error) {
      if (plan !== this.#plan || error.cancelled) return;
      const said = error.fault?.message ?? error.message ?? String(error);
      $("texture-result").replaceChildren(make("p", { className: "callout bad", role: "alert" }, said));
    } finally {
      $("texture").removeAttribute("aria-busy");
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

  /** Whether places can be found in a picture. */
  #placed(view) {
    return Boolean(this.#path?.scales.pictures[view.file]);
  }

  #found(at, reach) {
    const view = this.#view();
    const found = at && view && this.#placed(view) && this.phase !== "laid" ? this.#lookup(view).nearest(at[0], at[1], reach) : null;
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
    if (this.phase !== "laid") this.#space?.show(this.#path.at(time));
  }

  /** Draws what is pointed at and where playback is, in all views. */
  #marks() {
    if (!this.#path || !this.#plan) return;
    const now = this.#path.at(this.#time);
    const view = this.#view();
    if (view && (!this.#placed(view) || this.phase === "laid")) this.picture.mark({});
    else if (view) {
      const project = projector(this.#path.scales.pictures[view.file]);
      const placed = (place) => {
        const at = place && this.#path.vector(view.table, place, view.size);
        return at && project(at).slice(0, 2);
      };
      this.picture.mark({ trail: this.#trail(view, project), dot: placed(now), hover: placed(this.#pointed) });
    }
    if (this.phase === "laid") return;
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
    const height = v.state === 1 ? "untouched" : v.state === 2 ? "inaccessible" : v.residual === null ? "–" : `${short(v.residual)} µm`;
    const cells = [
      [this.#path.scales.limit === null ? "Measured rate" : "Rate", Number.isFinite(v.rate) ? `${short(v.rate)} mm³/min` : "–", Number.isFinite(v.share) ? `${Math.round(100 * v.share)} % of limit` : ""],
      ["Engagement", Number.isFinite(v.engagement) ? `${short(v.engagement)}°` : "–", ""],
      ["Height left", height, ""],
      ["Feed", `${short(v.feed)} mm/min`, ""],
      ["Pass", `${v.pass}`, WORDS[v.kind]],
      ["Region", `${v.region}`, ""],
    ];
    const readout = $("readout");
    if (readout.children.length !== cells.length || readout.firstChild.dataset.name !== cells[0][0]) {
      readout.replaceChildren(...cells.map(([name]) => make("div", { data: { name } }, make("dt", {}, name), make("dd", {}))));
    }
    cells.forEach(([, value, note], i) => {
      readout.children[i].lastChild.replaceChildren(value, note ? make("small", {}, ` ${note}`) : "");
    });
    readout.classList.toggle("pointed", this.#pointed !== null);
  }

  // ---- chart and playback

  #chart(all) {
    const file = this.#file(CHART);
    // Its place is kept while it may come.
    $("chart-frame").hidden = !file && this.#path.scales.limit === null;
    if (!file) {
      this.chart.empty();
      return;
    }
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
    // The slider's end lies a few ten-thousandths before the path's.
    if (this.#time >= 0.999 * this.#path.duration) this.#go(0);
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
