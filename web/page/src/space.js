// The part, the path and the cutter in three dimensions; loaded when asked for.
import {
  AmbientLight, BufferAttribute, BufferGeometry, Color, DirectionalLight, DoubleSide, Group,
  LatheGeometry, LineBasicMaterial, LineSegments, Mesh, MeshLambertMaterial, PerspectiveCamera,
  Scene, Vector2, Vector3, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";

/** Length of the cutter that is drawn, radii. */
const SHANK = 7;
const UP = new Vector3(0, 0, 1);

export class Space {
  #renderer;
  #scene = new Scene();
  #camera = new PerspectiveCamera(35, 1, 0.1, 1000);
  #asked = false;

  constructor(root, path) {
    this.root = root;
    this.path = path;
    this.#renderer = new WebGLRenderer({ antialias: true, alpha: true });
    this.#renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    const canvas = this.#renderer.domElement;
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", "The part with the path in three dimensions: drag or press arrow keys to turn, plus and minus zoom");
    canvas.tabIndex = 0;
    root.replaceChildren(canvas, this.#hint());
    this.#part();
    this.#lines();
    this.tool = this.#cutter();
    this.#lights();
    this.#controls(canvas);
    this.sizes = new ResizeObserver(() => this.#resize());
    this.sizes.observe(root);
    this.#resize();
  }

  dispose() {
    this.sizes.disconnect();
    this.controls.dispose();
    this.#scene.traverse((object) => {
      object.geometry?.dispose();
      object.material?.dispose();
    });
    this.#renderer.dispose();
    this.root.replaceChildren();
  }

  /** Puts the cutter at a place of the path. */
  show(place) {
    const tip = this.path.vector("tip", place);
    const axis = this.path.vector("axis", place);
    if (!tip || !axis) return;
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
    });
  }

  #part() {
    const { meshPositions: positions, meshFaces: faces } = this.path.tables;
    const machined = 3 * this.path.scales.machined;
    const parts = [[faces.subarray(0, machined), 0xbcc6ca], [faces.subarray(machined), 0x858e94]];
    for (const [index, colour] of parts) {
      if (index.length === 0) continue;
      const geometry = new BufferGeometry();
      geometry.setAttribute("position", new BufferAttribute(positions, 3));
      geometry.setIndex(new BufferAttribute(index, 1));
      geometry.computeVertexNormals();
      const material = new MeshLambertMaterial({ color: colour, side: DoubleSide, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 4 });
      this.#scene.add(new Mesh(geometry, material));
    }
  }

  /** Moves that cut by their rate; returns, links and rapids as in the flat pictures. */
  #lines() {
    const { tip, contact, kind, rate } = this.path.tables;
    const { colours, limit } = this.path.scales;
    const others = { 2: [0x98, 0x9e, 0xa6], 3: [0x5a, 0x60, 0x68], 4: [0x56, 0xb4, 0xe9] };
    const shades = colours.length - 1;
    const positions = new Float32Array(6 * Math.max(this.path.count - 1, 0));
    const tints = new Uint8Array(positions.length);
    const place = (i, at) => {
      const on = Number.isFinite(contact[3 * i]);
      positions.set((on ? contact : tip).subarray(3 * i, 3 * i + 3), at);
    };
    for (let i = 1; i < this.path.count; i++) {
      const share = rate[i] / limit;
      const own = share > 1.000001 ? colours[shades] : colours[Math.min(Math.max(Math.floor(share * shades), 0), shades - 1)];
      const tint = share <= 1.000001 && others[kind[i]] ? others[kind[i]] : own;
      const at = 6 * (i - 1);
      place(i - 1, at);
      place(i, at + 3);
      tints.set(tint, at);
      tints.set(tint, at + 3);
    }
    const linear = new Float32Array(tints.length);
    const colour = new Color();
    for (let i = 0; i < tints.length; i += 3) {
      colour.setRGB(tints[i] / 255, tints[i + 1] / 255, tints[i + 2] / 255, "srgb").toArray(linear, i);
    }
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(positions, 3));
    geometry.setAttribute("color", new BufferAttribute(linear, 3));
    this.#scene.add(new LineSegments(geometry, new LineBasicMaterial({ vertexColors: true })));
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
    this.#scene.add(group);
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
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(this.path.tables.meshPositions, 3));
    geometry.computeBoundingBox();
    const box = geometry.boundingBox;
    const centre = box.getCenter(new Vector3());
    const size = box.getSize(new Vector3()).length() || 1;
    this.#camera.up.copy(UP);
    this.#camera.near = 0.01 * size;
    this.#camera.far = 20 * size;
    const reset = () => {
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
        reset();
        return;
      } else return;
      event.preventDefault();
      this.#camera.position.copy(this.controls.target).add(offset);
      this.controls.update();
      this.draw();
    });
    reset();
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
    hint.textContent = "Drag to turn, wheel to zoom, right button to move";
    return hint;
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
