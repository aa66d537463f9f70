// The part, the path and the cutter in three dimensions; loaded when asked for.
import {
  AmbientLight, Box3, BufferAttribute, BufferGeometry, Color, DirectionalLight, DoubleSide, Group,
  LatheGeometry, LineBasicMaterial, LineSegments, Mesh, MeshLambertMaterial, PerspectiveCamera, Points,
  PointsMaterial, Scene, Vector2, Vector3, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";

/** Length of the cutter that is drawn, radii. */
const SHANK = 7;
const UP = new Vector3(0, 0, 1);

/** Colours of heights, low to high: of one lightness order, and unlike those of rates and of what is left. */
const HEIGHTS = [[0x1d, 0x3f, 0x72], [0x3f, 0x7f, 0xa6], [0x8f, 0xbf, 0xc4], [0xdd, 0xe3, 0xcb], [0xf4, 0xe3, 0xb4]];
const PLAIN_LINE = [0x24, 0x50, 0x6e];
/** A coloured dot reaches so far over its place's part of the surface that no ground shows. */
const OVERLAP = 1.7;
/** Share of the light that comes from everywhere, on dots. */
const AMBIENT = 0.62;
const LIGHT = new Vector3(-0.35, -0.45, 0.82).normalize();
/** A cell and those around it, itself first. */
const NEIGHBOURS = [0, 1, -1].flatMap((x) => [0, 1, -1].flatMap((y) => [0, 1, -1].map((z) => [x, y, z])));

export class Space {
  #renderer;
  #scene = new Scene();
  #camera = new PerspectiveCamera(35, 1, 0.1, 1000);
  #asked = false;
  #content = new Group();
  #reset = null;

  constructor(root) {
    this.root = root;
    this.#renderer = new WebGLRenderer({ antialias: true, alpha: true });
    this.#renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    const canvas = this.#renderer.domElement;
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", "The part with the path in three dimensions: drag or press arrow keys to turn, plus and minus zoom, 0 shows all");
    canvas.tabIndex = 0;
    root.replaceChildren(canvas, this.#hint(), this.#triad());
    this.#scene.add(this.#content);
    this.#lights();
    this.#controls(canvas);
    this.sizes = new ResizeObserver(() => this.#resize());
    this.sizes.observe(root);
  }

  /** Takes another path and its part; who looks stays where they are. */
  load(path) {
    const isFirst = !this.path;
    this.path = path;
    this.#empty();
    this.parts = this.#part();
    this.line = this.#lines();
    this.tool = this.#cutter();
    this.dots = new Map();
    this.#content.add(...this.parts, this.line, this.tool);
    this.colour(this.surface ?? "plain", this.lines ?? "scale");
    if (isFirst) this.#reset();
    this.#resize();
  }

  /** `surface`: plain, height, residual or rate; `lines`: scale, plain or none. */
  colour(surface, lines) {
    Object.assign(this, { surface, lines });
    const isDotted = surface === "residual" || surface === "rate";
    if (isDotted && !this.dots.has(surface)) {
      this.dots.set(surface, this.#dots(surface));
      this.#content.add(this.dots.get(surface));
    }
    for (const [kind, dots] of this.dots) dots.visible = kind === surface;
    this.#heighten(surface === "height");
    this.line.visible = lines !== "none";
    this.line.material.vertexColors = lines === "scale";
    this.line.material.color.setRGB(...(lines === "scale" ? [1, 1, 1] : PLAIN_LINE.map((x) => x / 255)), "srgb");
    this.line.material.needsUpdate = true;
    this.draw();
  }

  /** The legend of heights. */
  heights() {
    const [low, high] = this.#range();
    const make = (name, className, text) => Object.assign(document.createElement(name), { className, textContent: text });
    const legend = make("div", "ramp", "");
    const bar = make("i", "", "");
    const stops = HEIGHTS.map((colour) => `rgb(${colour.join(" ")})`).join(", ");
    bar.style.background = `linear-gradient(to top, ${stops})`;
    const labels = make("ol", "", "");
    for (let i = 4; i >= 0; i--) labels.append(make("li", "", (low + (i / 4) * (high - low)).toFixed(high - low < 10 ? 2 : 1).replace("-", "−")));
    legend.append(make("p", "", "Height"), make("p", "unit", "z, mm"), bar, labels);
    return legend;
  }

  dispose() {
    this.sizes.disconnect();
    this.controls.dispose();
    this.#empty();
    this.#renderer.dispose();
    this.root.replaceChildren();
  }

  #empty() {
    this.#content.traverse((object) => {
      object.geometry?.dispose();
      object.material?.dispose();
    });
    this.#content.clear();
  }

  /** Puts the cutter at a place of the path. */
  show(place) {
    const tip = this.path.vector("tip", place);
    const axis = this.path.vector("axis", place);
    if (!tip || !axis) return;
    this.tool.visible = true;
    this.tool.position.set(...tip);
    this.tool.quaternion.setFromUnitVectors(UP, new Vector3(...axis).normalize());
    this.draw();
  }

  draw() {
    if (this.#asked) return;
    this.#asked = true;
    requestAnimationFrame(() => {
      this.#asked = false;
      this.#renderer.render(this.#scene, this.#camera);
      this.#turnTriad();
    });
  }

  #part() {
    const { meshPositions: positions, meshFaces: faces } = this.path.tables;
    const machined = 3 * this.path.scales.machined;
    const parts = [[faces.subarray(0, machined), 0xc3ccd0], [faces.subarray(machined), 0x858e94]];
    return parts.filter(([index]) => index.length > 0).map(([index, colour]) => {
      const geometry = new BufferGeometry();
      geometry.setAttribute("position", new BufferAttribute(positions, 3));
      geometry.setIndex(new BufferAttribute(index, 1));
      geometry.computeVertexNormals();
      const material = new MeshLambertMaterial({ color: colour, side: DoubleSide, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 4 });
      const mesh = new Mesh(geometry, material);
      mesh.userData.colour = colour;
      return mesh;
    });
  }

  /** Lowest and highest z of what is machined, mm. */
  #range() {
    const { meshPositions, meshFaces } = this.path.tables;
    let [low, high] = [Infinity, -Infinity];
    for (let i = 0; i < 3 * this.path.scales.machined; i++) {
      const z = meshPositions[3 * meshFaces[i] + 2];
      low = Math.min(low, z);
      high = Math.max(high, z);
    }
    return low < high ? [low, high] : [low - 0.5, low + 0.5];
  }

  /** Colours what is machined by height. */
  #heighten(on) {
    const [mesh] = this.parts;
    if (!mesh) return;
    const { geometry, material } = mesh;
    if (on && !geometry.hasAttribute("color")) {
      const positions = this.path.tables.meshPositions;
      const [low, high] = this.#range();
      const colours = new Float32Array(positions.length);
      const colour = new Color();
      for (let i = 0; i < positions.length; i += 3) {
        const place = Math.min(Math.max((positions[i + 2] - low) / (high - low), 0), 1) * (HEIGHTS.length - 1);
        const below = Math.min(Math.floor(place), HEIGHTS.length - 2);
        const mixed = HEIGHTS[below].map((a, k) => (a + (place - below) * (HEIGHTS[below + 1][k] - a)) / 255);
        colour.setRGB(...mixed, "srgb").toArray(colours, i);
      }
      geometry.setAttribute("color", new BufferAttribute(colours, 3));
    }
    material.vertexColors = on;
    material.color.set(on ? 0xffffff : mesh.userData.colour);
    material.needsUpdate = true;
  }

  /** The judge's samples as dots in the colours of their picture, shaded by the nearest vertex. */
  #dots(kind) {
    const { samplePlace: places, sampleResidualTone, sampleRateTone } = this.path.tables;
    const [tones, palette] = kind === "rate" ? [sampleRateTone, this.path.scales.rateColours] : [sampleResidualTone, this.path.scales.residualColours];
    const near = this.#normals();
    const colours = new Float32Array(places.length);
    const colour = new Color();
    let light = 1;
    for (let i = 0; i < tones.length; i++) {
      const normal = near(places[3 * i], places[3 * i + 1], places[3 * i + 2]);
      // Far from all vertices: as the place before, which lies beside it.
      if (normal) light = AMBIENT + (1 - AMBIENT) * Math.max(normal.dot(LIGHT), 0);
      const [r, g, b] = palette[tones[i]];
      colour.setRGB(r / 255, g / 255, b / 255, "srgb").multiplyScalar(light).toArray(colours, 3 * i);
    }
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(places, 3));
    geometry.setAttribute("color", new BufferAttribute(colours, 3));
    const size = OVERLAP * Math.sqrt(this.#area() / Math.max(tones.length, 1));
    return new Points(geometry, new PointsMaterial({ size, vertexColors: true, sizeAttenuation: true }));
  }

  /** Area of what is machined, mm². */
  #area() {
    const { meshPositions, meshFaces } = this.path.tables;
    const [a, b, c] = [new Vector3(), new Vector3(), new Vector3()];
    let twice = 0;
    for (let i = 0; i < 3 * this.path.scales.machined; i += 3) {
      [a, b, c].forEach((p, k) => p.fromArray(meshPositions, 3 * meshFaces[i + k]));
      twice += b.sub(a).cross(c.sub(a)).length();
    }
    return twice / 2;
  }

  /** A function from a place to the normal at a vertex near it. */
  #normals() {
    const positions = this.path.tables.meshPositions;
    const { normal } = this.parts[0].geometry.attributes;
    const cell = 1.5 * Math.sqrt((2 * this.#area()) / Math.max(this.path.scales.machined, 1)) || 1;
    const key = (x, y, z) => {
      const [a, b, c] = [x, y, z].map((v) => Math.floor(v / cell) & 0xffff);
      return (a * 0x10000 + b) * 0x10000 + c;
    };
    const { meshFaces } = this.path.tables;
    const cells = new Map();
    for (let i = 0; i < 3 * this.path.scales.machined; i++) {
      const [v, next] = [meshFaces[i], meshFaces[i % 3 === 2 ? i - 2 : i + 1]];
      // Sides longer than a cell mark those between, too.
      const [from, to] = [v, next].map((k) => positions.subarray(3 * k, 3 * k + 3));
      const pieces = Math.min(Math.ceil(Math.hypot(to[0] - from[0], to[1] - from[1], to[2] - from[2]) / cell), 64);
      for (let k = 0; k < Math.max(pieces, 1); k++) {
        const part = k / Math.max(pieces, 1);
        const place = key(...[0, 1, 2].map((j) => from[j] + part * (to[j] - from[j])));
        if (!cells.has(place)) cells.set(place, part < 0.5 ? v : next);
      }
    }
    const found = new Vector3();
    return (x, y, z) => {
      for (const cube of NEIGHBOURS) {
        const i = cells.get(key(x + cube[0] * cell, y + cube[1] * cell, z + cube[2] * cell));
        if (i !== undefined) return found.fromBufferAttribute(normal, i);
      }
      return null;
    };
  }

  /** Moves that cut by the scale of the path; returns, links and rapids as in the flat pictures. */
  #lines() {
    const { tip, contact, kind } = this.path.tables;
    const { colours } = this.path.scales;
    const others = { 2: [0x98, 0x9e, 0xa6], 3: [0x5a, 0x60, 0x68], 4: [0x56, 0xb4, 0xe9] };
    const shades = colours.length - 1;
    const positions = new Float32Array(6 * Math.max(this.path.count - 1, 0));
    const tints = new Float32Array(positions.length);
    const colour = new Color();
    const place = (i, at) => {
      const on = Number.isFinite(contact[3 * i]);
      positions.set((on ? contact : tip).subarray(3 * i, 3 * i + 3), at);
    };
    for (let i = 1; i < this.path.count; i++) {
      const share = this.path.share(i);
      const own = share > 1.000001 ? colours[shades] : colours[Math.min(Math.max(Math.floor(share * shades), 0), shades - 1)];
      const [r, g, b] = share <= 1.000001 && others[kind[i]] ? others[kind[i]] : own;
      const at = 6 * (i - 1);
      place(i - 1, at);
      place(i, at + 3);
      colour.setRGB(r / 255, g / 255, b / 255, "srgb");
      colour.toArray(tints, at);
      colour.toArray(tints, at + 3);
    }
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(positions, 3));
    geometry.setAttribute("color", new BufferAttribute(tints, 3));
    return new LineSegments(geometry, new LineBasicMaterial({ vertexColors: true }));
  }

  #cutter() {
    const { radius, corner } = this.path.scales.tool;
    const profile = [new Vector2(0, 0), new Vector2(radius - corner, 0)];
    for (let i = 1; i <= 12 && corner > 0; i++) {
      const angle = (i / 12) * (Math.PI / 2);
      profile.push(new Vector2(radius - corner + corner * Math.sin(angle), corner * (1 - Math.cos(angle))));
    }
    profile.push(new Vector2(radius, SHANK * radius));
    const lathe = new LatheGeometry(profile, 40);
    lathe.rotateX(Math.PI / 2);
    const material = new MeshLambertMaterial({ color: 0xd9a441, side: DoubleSide, transparent: true, opacity: 0.55, depthWrite: false });
    const group = new Group();
    group.add(new Mesh(lathe, material));
    group.visible = false;
    return group;
  }

  #lights() {
    this.#scene.add(new AmbientLight(0xffffff, 1.3));
    const key = new DirectionalLight(0xffffff, 1.9);
    key.position.set(-0.4, -0.5, 1);
    const back = new DirectionalLight(0xffffff, 0.5);
    back.position.set(0.6, 0.8, 0.2);
    this.#camera.add(key, back);
    this.#scene.add(this.#camera);
  }

  #controls(canvas) {
    this.#reset = () => {
      const box = new Box3();
      for (const part of this.parts) {
        part.geometry.computeBoundingBox();
        box.union(part.geometry.boundingBox);
      }
      const centre = box.getCenter(new Vector3());
      const size = box.getSize(new Vector3()).length() || 1;
      this.#camera.up.copy(UP);
      this.#camera.near = 0.01 * size;
      this.#camera.far = 20 * size;
      this.#resize();
      const toward = new Vector3(0.35, -0.75, 0.75).normalize();
      this.#camera.position.copy(centre).addScaledVector(toward, this.#distance(box, centre, toward));
      this.controls.target.copy(centre);
      this.controls.update();
      this.draw();
    };
    this.controls = new OrbitControls(this.#camera, canvas);
    this.controls.addEventListener("change", () => this.draw());
    canvas.addEventListener("keydown", (event) => {
      const offset = this.#camera.position.clone().sub(this.controls.target);
      const turn = { ArrowLeft: -0.15, ArrowRight: 0.15 }[event.key];
      const factor = { "+": 0.85, "=": 0.85, "-": 1.18 }[event.key];
      if (turn) offset.applyAxisAngle(UP, turn);
      else if (factor) offset.multiplyScalar(factor);
      else if (event.key === "ArrowUp" || event.key === "ArrowDown") {
        const side = new Vector3().crossVectors(UP, offset).normalize();
        offset.applyAxisAngle(side, event.key === "ArrowUp" ? -0.12 : 0.12);
      } else if (event.key === "0") {
        event.preventDefault();
        this.#reset();
        return;
      } else return;
      event.preventDefault();
      this.#camera.position.copy(this.controls.target).add(offset);
      this.controls.update();
      this.draw();
    });
  }

  /** How far the camera must stand for a box to be seen whole. */
  #distance(box, centre, toward) {
    const right = new Vector3().crossVectors(UP, toward).normalize();
    const up = new Vector3().crossVectors(toward, right);
    const slope = Math.tan((this.#camera.fov * Math.PI) / 360);
    const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((i) =>
      new Vector3(...["x", "y", "z"].map((axis, k) => ((i >> k) & 1 ? box.max : box.min)[axis])).sub(centre));
    const needed = corners.map((corner) => {
      const across = Math.max(Math.abs(corner.dot(right)) / this.#camera.aspect, Math.abs(corner.dot(up)));
      return across / slope + corner.dot(toward);
    });
    return 1.08 * Math.max(...needed);
  }

  #hint() {
    const hint = document.createElement("p");
    hint.className = "hint";
    const isTouch = matchMedia("(pointer: coarse)").matches;
    hint.textContent = isTouch ? "Drag to turn, pinch to zoom" : "Drag to turn, wheel to zoom, right button to move";
    return hint;
  }

  /** The part's axes, in a corner. */
  #triad() {
    const element = (name) => document.createElementNS("http://www.w3.org/2000/svg", name);
    const triad = element("svg");
    triad.setAttribute("viewBox", "-40 -40 80 80");
    triad.setAttribute("class", "triad");
    triad.setAttribute("aria-hidden", "true");
    this.axes = ["X", "Y", "Z"].map((name) => {
      const [line, label] = [element("line"), element("text")];
      label.textContent = name;
      triad.append(line, label);
      return { line, label };
    });
    return triad;
  }

  #turnTriad() {
    const back = this.#camera.quaternion.clone().invert();
    [[1, 0, 0], [0, 1, 0], [0, 0, 1]].forEach((direction, i) => {
      const { x, y } = new Vector3(...direction).applyQuaternion(back);
      const { line, label } = this.axes[i];
      line.setAttribute("x2", 26 * x);
      line.setAttribute("y2", -26 * y);
      label.setAttribute("x", 34 * x);
      label.setAttribute("y", 4 - 34 * y);
    });
  }

  #resize() {
    const { clientWidth: width, clientHeight: height } = this.root;
    if (width === 0 || height === 0) return;
    this.#renderer.setSize(width, height, false);
    this.#camera.aspect = width / height;
    this.#camera.updateProjectionMatrix();
    this.draw();
  }
}
