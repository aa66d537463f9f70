// A picture made by the planner, with zoom, pan and marks on top.

const SVG = "http://www.w3.org/2000/svg";
const CLOSEST = 40;
const STEP = 1.3;

const element = (name, attributes = {}) => {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  return made;
};

export class Picture {
  #layer = document.createElement("div");
  #view = { x: 0, y: 0, k: 1 };
  #fit = { width: 1, height: 1 };
  #pointers = new Map();
  #moved = false;
  #ruler = null;
  #bar = document.createElement("div");

  /** `on.hover(x, y, reach)` with places in the picture or null, `on.pick` on a click. */
  constructor(root, label, on) {
    this.root = root;
    this.on = on;
    root.tabIndex = 0;
    root.setAttribute("role", "group");
    root.setAttribute("aria-label", `${label}: arrow keys move, plus and minus zoom, 0 shows all`);
    this.#layer.className = "layer";
    this.#bar.className = "ruler";
    this.#bar.hidden = true;
    root.append(this.#layer, this.#bar, this.#buttons());
    root.addEventListener("wheel", (event) => this.#wheel(event), { passive: false });
    root.addEventListener("pointerdown", (event) => this.#down(event));
    root.addEventListener("pointermove", (event) => this.#move(event));
    for (const end of ["pointerup", "pointercancel"]) {
      root.addEventListener(end, (event) => this.#up(event));
    }
    root.addEventListener("pointerleave", () => this.on.hover?.(null));
    root.addEventListener("keydown", (event) => this.#key(event));
    new ResizeObserver(() => this.#place()).observe(root);
  }

  /**
   * Shows a picture, or a part of it: `crop` is x, y, width, height, px. With a `placement` the
   * drawing alone is shown; what is beside it comes back as `legend`, what is written above it as
   * `caption`, and a scale bar in `unit` follows the zoom. `keep`: the view stays where the drawing has
   * its place.
   */
  show(bytes, { crop, placement, unit, keep } = {}) {
    const picture = parsed(bytes);
    const apart = placement ? setApart(picture, placement.drawing) : {};
    const box = apart.box ?? crop ?? picture.getAttribute("viewBox").split(" ").map(Number);
    this.#ruler = placement && { mm: Math.hypot(placement.x[0], placement.x[1], placement.x[2]) || 1, unit };
    this.#bar.hidden = !placement;
    picture.setAttribute("viewBox", box.join(" "));
    const stays = keep && this.box?.every((x, i) => Math.abs(x - box[i]) < 1);
    this.box = box;
    this.root.style.setProperty("--aspect", box[2] / box[3]);
    this.marks = element("svg", { viewBox: box.join(" "), class: "marks", "aria-hidden": "true" });
    this.#layer.replaceChildren(picture, this.marks);
    if (stays) this.#place();
    else this.reset();
    return apart;
  }

  /** Shows nothing. */
  empty() {
    this.box = null;
    this.marks = null;
    this.#layer.replaceChildren();
  }

  reset() {
    this.#view = { x: 0, y: 0, k: 1 };
    this.#place();
  }

  /** A line and a dot on top; places in px of the picture. */
  mark({ trail = [], dot = null, line = null, hover = null }) {
    if (!this.marks) return;
    const size = 1 / this.scale;
    const parts = [];
    if (trail.length > 1) {
      const points = trail.map(([x, y]) => `${x.toFixed(2)},${y.toFixed(2)}`).join(" ");
      parts.push(element("polyline", { points, class: "trail-halo", "stroke-width": 5 * size }));
      parts.push(element("polyline", { points, class: "trail", "stroke-width": 2.2 * size }));
    }
    const rule = (x, kind) => {
      const [from, to] = line.range;
      parts.push(element("line", { x1: x, x2: x, y1: from, y2: to, class: kind, "stroke-width": 1.5 * size }));
    };
    if (line) rule(line.x, "now");
    if (line?.hover !== undefined && line?.hover !== null) rule(line.hover, "pointed");
    for (const [place, kind, r] of [[dot, "dot", 6], [hover, "dot pointed", 5]]) {
      if (place) parts.push(element("circle", { cx: place[0], cy: place[1], r: r * size, class: kind, "stroke-width": 2 * size }));
    }
    this.marks.replaceChildren(...parts);
  }

  /** Px of the screen for one of the picture. */
  get scale() {
    return (this.#fit.width / (this.box?.[2] ?? 1)) * this.#view.k || 1;
  }

  #place() {
    if (!this.box) return;
    const { clientWidth: width, clientHeight: height } = this.root;
    const scale = Math.min(width / this.box[2], height / this.box[3]) || 0;
    this.#fit = { width: scale * this.box[2], height: scale * this.box[3] };
    const { k } = this.#view;
    const clamp = (at, size, room) => {
      const most = Math.max(0, (size * k - room) / 2 + (k > 1 ? 0.25 * room : 0));
      return Math.min(Math.max(at, -most), most);
    };
    this.#view.x = clamp(this.#view.x, this.#fit.width, width);
    this.#view.y = clamp(this.#view.y, this.#fit.height, height);
    const left = (width - this.#fit.width * k) / 2 + this.#view.x;
    const top = (height - this.#fit.height * k) / 2 + this.#view.y;
    this.#layer.style.width = `${this.#fit.width}px`;
    this.#layer.style.height = `${this.#fit.height}px`;
    this.#layer.style.transform = `translate(${left}px, ${top}px) scale(${k})`;
    this.#measure();
    this.on.view?.();
  }

  /** The scale bar: the longest round length of at most 120 px of the screen. */
  #measure() {
    if (!this.#ruler) return;
    const most = 120 / (this.#ruler.mm * this.scale);
    const decade = 10 ** Math.floor(Math.log10(most));
    const length = [5, 2, 1].map((digit) => digit * decade).find((round) => round <= most) ?? decade;
    const line = document.createElement("i");
    line.style.width = `${length * this.#ruler.mm * this.scale}px`;
    this.#bar.replaceChildren(line, `${Number(length.toPrecision(1))} ${this.#ruler.unit}`);
  }

  zoom(factor, x = this.root.clientWidth / 2, y = this.root.clientHeight / 2) {
    const view = this.#view;
    const k = Math.min(Math.max(view.k * factor, 1), CLOSEST);
    const [cx, cy] = [x - this.root.clientWidth / 2, y - this.root.clientHeight / 2];
    view.x = cx - ((cx - view.x) * k) / view.k;
    view.y = cy - ((cy - view.y) * k) / view.k;
    view.k = k;
    this.#place();
  }

  pan(dx, dy) {
    this.#view.x += dx;
    this.#view.y += dy;
    this.#place();
  }

  /** A place of the screen in px of the picture. */
  #inside(event) {
    const rect = this.#layer.getBoundingClientRect();
    return [
      this.box[0] + ((event.clientX - rect.left) / rect.width) * this.box[2],
      this.box[1] + ((event.clientY - rect.top) / rect.height) * this.box[3],
    ];
  }

  #wheel(event) {
    if (!this.box || (this.on.quietWheel && !event.ctrlKey)) return;
    event.preventDefault();
    const rect = this.root.getBoundingClientRect();
    this.zoom(Math.exp(-0.002 * event.deltaY), event.clientX - rect.left, event.clientY - rect.top);
  }

  #down(event) {
    if (event.target.closest("button")) return;
    this.#pointers.set(event.pointerId, event);
    this.#moved = false;
    this.root.setPointerCapture(event.pointerId);
  }

  #move(event) {
    const last = this.#pointers.get(event.pointerId);
    if (!this.box) return;
    if (!last) {
      this.on.hover?.(this.#inside(event), 14 / this.scale);
      return;
    }
    const others = [...this.#pointers.values()].filter((p) => p.pointerId !== event.pointerId);
    const [dx, dy] = [event.clientX - last.clientX, event.clientY - last.clientY];
    if (Math.hypot(dx, dy) < 3 && !this.#moved) return;
    this.#moved = true;
    this.root.classList.add("dragged");
    if (others.length === 1) {
      const far = (p) => Math.hypot(p.clientX - others[0].clientX, p.clientY - others[0].clientY);
      const rect = this.root.getBoundingClientRect();
      this.zoom(far(event) / Math.max(far(last), 1), others[0].clientX - rect.left, others[0].clientY - rect.top);
    } else if (this.on.drag) {
      this.on.drag(this.#inside(event), 14 / this.scale);
    } else {
      this.pan(dx, dy);
    }
    this.#pointers.set(event.pointerId, event);
  }

  #up(event) {
    const was = this.#pointers.delete(event.pointerId);
    this.root.classList.remove("dragged");
    if (was && !this.#moved && event.type === "pointerup") this.on.pick?.(this.#inside(event), 14 / this.scale);
  }

  #key(event) {
    if (event.target !== this.root || event.ctrlKey || event.metaKey) return;
    const moves = { ArrowLeft: [40, 0], ArrowRight: [-40, 0], ArrowUp: [0, 40], ArrowDown: [0, -40] };
    if (moves[event.key]) this.pan(...moves[event.key]);
    else if (event.key === "+" || event.key === "=") this.zoom(STEP);
    else if (event.key === "-") this.zoom(1 / STEP);
    else if (event.key === "0") this.reset();
    else return;
    event.preventDefault();
  }

  #buttons() {
    const bar = document.createElement("div");
    bar.className = "zoom";
    const actions = [["+", "Zoom in", () => this.zoom(STEP)], ["−", "Zoom out", () => this.zoom(1 / STEP)], ["⤢", "Show all", () => this.reset()]];
    for (const [sign, label, act] of actions) {
      const button = document.createElement("button");
      button.type = "button";
      button.textContent = sign;
      button.title = label;
      button.setAttribute("aria-label", label);
      button.addEventListener("click", act);
      bar.append(button);
    }
    return bar;
  }
}

function parsed(bytes) {
  const text = new TextDecoder().decode(bytes);
  return document.adoptNode(new DOMParser().parseFromString(text, "image/svg+xml").documentElement);
}

/** A picture that stays as it is. */
export function svgOf(bytes) {
  const picture = parsed(bytes);
  picture.setAttribute("role", "img");
  picture.setAttribute("aria-label", picture.querySelector("title")?.textContent ?? "");
  return picture;
}

/** The legend of a picture without the axes of its view. */
export function legendOf(bytes, placement) {
  const picture = parsed(bytes);
  const children = [...picture.children];
  const start = (line) => ["x1", "y1"].map((name) => line.getAttribute(name)).join(" ");
  const lines = children.filter((child) => child.localName === "line");
  const isAxis = (child) => child.localName === "line"
    ? lines.filter((other) => start(other) === start(child)).length === 3
    : child.localName === "text" && ["X", "Y", "Z"].includes(child.textContent);
  children.filter(isAxis).forEach((child) => child.remove());
  return setApart(picture, placement.drawing).legend;
}

/** The name that a picture gives itself. */
export function titleOf(bytes) {
  return parsed(bytes).querySelector("title")?.textContent ?? "";
}

/** Room around a drawing, px. */
const ROOM = 14;

/** Takes what is beside and above the drawing out of a picture. */
function setApart(picture, [x, y, width, height]) {
  const [, , whole] = picture.getAttribute("viewBox").split(" ").map(Number);
  const place = (child, axis) => Number(child.getAttribute(axis) ?? child.getAttribute(`${axis}1`) ?? child.getAttribute(`c${axis}`) ?? NaN);
  const right = x + width + ROOM;
  const beside = [];
  const above = [];
  for (const child of [...picture.children]) {
    if (["title", "desc", "path", "image", "polyline"].includes(child.localName)) continue;
    if (place(child, "x") >= right) beside.push(child);
    else if (child.localName === "text" && place(child, "y") < y) above.push(child.textContent);
  }
  const [from, to] = [Math.min, Math.max].map((most) => most(...beside.map((child) => place(child, "y"))));
  const box = [right, from - 14, whole - right, to - from + 34];
  const legend = element("svg", { viewBox: box.join(" "), width: box[2], height: box[3], role: "img" });
  for (const name of ["font-family"]) legend.setAttribute(name, picture.getAttribute(name) ?? "");
  legend.setAttribute("aria-label", beside.filter((child) => child.localName === "text").map((child) => child.textContent).join(", "));
  legend.append(...beside);
  // The first line above is the title, which the tab tells.
  return { legend, caption: above.slice(1).join(". "), box: [x - ROOM, y - ROOM, width + 2 * ROOM, height + 2 * ROOM] };
}
