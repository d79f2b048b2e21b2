// The map in 3D: points, the chosen thing in its own colour and box.

import {
  BoxGeometry, BufferAttribute, BufferGeometry, Color, EdgesGeometry, LineBasicMaterial,
  LineSegments, Matrix4, PerspectiveCamera, Points, PointsMaterial, Raycaster, Scene, Vector2,
  Vector3, WebGLRenderer, OrbitControls,
} from "./three.min.js";

const CHOSEN = new Color("#ff3b30");
const POINT_M = 0.03;
const NEAR_M = 2; // to a small thing; to a large one as many of its own sizes
const NEAR_SIZES = 3;
const MIDDLE_M = 0.5;

export class Map3D {
  constructor(canvas, onPick) {
    this.canvas = canvas;
    this.scene = new Scene();
    this.camera = new PerspectiveCamera(50, 1, 0.05, 200);
    this.renderer = new WebGLRenderer({ canvas, antialias: true, alpha: true });
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener("change", () => this.draw());
    this.cloud = null;
    this.box = null;
    this.chosen = 0;
    this.far = Infinity;
    this.middle = new Vector3();
    this.aslant = null; // from where all of it is seen, once there is something to see
    new ResizeObserver(() => this.fit()).observe(canvas);
    let down = null;
    canvas.addEventListener("pointerdown", (event) => { down = [event.clientX, event.clientY]; });
    canvas.addEventListener("pointerup", (event) => {
      const still = down && Math.hypot(event.clientX - down[0], event.clientY - down[1]) < 4;
      const id = still ? this.at(event) : 0;
      if (id) onPick(id);
    });
    canvas.addEventListener("keydown", (event) => this.key(event));
  }

  // Takes the bytes of GET /cloud.
  load(data) {
    const view = new DataView(data);
    const count = view.getUint32(4, true);
    const up = [8, 12, 16].map((at) => view.getFloat32(at, true));
    const colourBytes = 3 * count + ((4 - ((3 * count) % 4)) % 4);
    const positions = new Float32Array(data, 20, 3 * count);
    this.rgb = new Uint8Array(data, 20 + 12 * count, 3 * count);
    this.owner = new Int32Array(data, 20 + 12 * count + colourBytes, count);
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(positions, 3));
    geometry.setAttribute("color", new BufferAttribute(new Uint8Array(3 * count), 3, true));
    if (this.cloud) { this.scene.remove(this.cloud); this.cloud.geometry.dispose(); }
    const material = new PointsMaterial({ size: POINT_M, vertexColors: true });
    this.cloud = new Points(geometry, material);
    this.scene.add(this.cloud);
    this.paint();
    if (count && !this.aslant) this.look(new Vector3(...up));
    this.draw();
  }

  // Shows a thing: its points in one colour, its box, the rest dimmed.
  choose(record) {
    this.chosen = record ? record.id : 0;
    this.canvas.dataset.chosen = this.chosen;
    if (this.box) { this.scene.remove(this.box); this.box.geometry.dispose(); this.box = null; }
    if (record) {
      const box = record.box_oriented;
      const edges = new EdgesGeometry(new BoxGeometry(...box.size.map((edge) => edge + 0.02)));
      this.box = new LineSegments(edges, new LineBasicMaterial({ color: CHOSEN }));
      const [a, b, c] = box.rotation;
      this.box.applyMatrix4(new Matrix4().set(
        a[0], a[1], a[2], box.centre[0], b[0], b[1], b[2], box.centre[1],
        c[0], c[1], c[2], box.centre[2], 0, 0, 0, 1));
      this.scene.add(this.box);
      this.approach(new Vector3(...record.centre), Math.hypot(...box.size));
    }
    this.paint();
    this.draw();
  }

  paint() {
    if (!this.cloud) return;
    const colours = this.cloud.geometry.attributes.color;
    const chosen = [CHOSEN.r, CHOSEN.g, CHOSEN.b].map((part) => Math.round(255 * part ** (1 / 2.2)));
    for (let i = 0; i < this.owner.length; i += 1) {
      const hit = this.chosen && this.owner[i] === this.chosen;
      for (let c = 0; c < 3; c += 1) {
        const own = this.rgb[3 * i + c];
        colours.array[3 * i + c] = hit ? (own + 3 * chosen[c]) / 4 : this.chosen ? own * 0.7 + 20 : own;
      }
    }
    colours.needsUpdate = true;
  }

  look(up) {
    if (up.lengthSq() === 0) up.set(0, 0, 1);
    this.camera.up.copy(up.normalize());
    const aside = Math.abs(up.x) < 0.9 ? new Vector3(1, 0, 0) : new Vector3(0, 1, 0);
    this.aslant = aside.cross(up).normalize().add(up).normalize();
    this.whole();
  }

  // All of the map, aslant from above.
  whole() {
    if (!this.aslant) return;
    this.cloud.geometry.computeBoundingSphere();
    const { center, radius } = this.cloud.geometry.boundingSphere;
    const half = Math.atan(Math.tan((Math.PI * this.camera.fov) / 360) * Math.min(1, this.camera.aspect));
    this.far = (0.85 * radius) / Math.sin(half);
    this.middle.copy(center);
    this.camera.position.copy(center).addScaledVector(this.aslant, this.far);
    this.controls.target.copy(center);
    this.controls.update();
    this.draw();
  }

  // Turns to a thing, so far away that it is seen with what is around it, and from the middle of
  // the map where it is not there itself: no wall is between.
  approach(centre, size) {
    const { up } = this.camera;
    const inward = this.middle.clone().sub(centre);
    inward.addScaledVector(up, -inward.dot(up));
    const offset = inward.length() > MIDDLE_M
      ? inward.normalize().add(up)
      : this.camera.position.clone().sub(this.controls.target);
    offset.setLength(Math.min(this.far, Math.max(NEAR_M, NEAR_SIZES * size)));
    this.controls.target.copy(centre);
    this.camera.position.copy(centre).add(offset);
    this.controls.update();
  }

  at(event) {
    if (!this.cloud) return 0;
    const frame = this.canvas.getBoundingClientRect();
    const x = (2 * (event.clientX - frame.left)) / frame.width - 1;
    const y = 1 - (2 * (event.clientY - frame.top)) / frame.height;
    const ray = new Raycaster();
    ray.params.Points.threshold = POINT_M;
    ray.setFromCamera(new Vector2(x, y), this.camera);
    const hits = ray.intersectObject(this.cloud).filter((hit) => this.owner[hit.index] > 0);
    return hits.length ? this.owner[hits[0].index] : 0;
  }

  key(event) {
    if (event.key === "Home" && this.cloud) {
      event.preventDefault();
      this.whole();
    }
    const turn = { ArrowLeft: [0.1, 0], ArrowRight: [-0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1] }[event.key];
    const near = { "+": 0.9, "=": 0.9, "-": 1.1 }[event.key];
    if (!turn && !near) return;
    event.preventDefault();
    const offset = this.camera.position.clone().sub(this.controls.target);
    if (near) offset.multiplyScalar(near);
    if (turn) {
      offset.applyAxisAngle(this.camera.up, turn[0]);
      const side = offset.clone().cross(this.camera.up).normalize();
      offset.applyAxisAngle(side, -turn[1]);
    }
    this.camera.position.copy(this.controls.target).add(offset);
    this.controls.update();
    this.draw();
  }

  fit() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (!width || !height) return;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  draw() {
    if (this.pending) return;
    this.pending = requestAnimationFrame(() => {
      this.pending = null;
      this.renderer.render(this.scene, this.camera);
    });
  }
}
