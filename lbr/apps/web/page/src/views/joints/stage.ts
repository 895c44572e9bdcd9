// The body in three dimensions: built from the model, moved by angles, coloured by state; a limb can be picked and dragged.
import {
  ACESFilmicToneMapping, BufferGeometry, CapsuleGeometry, CircleGeometry, Color, CylinderGeometry, DirectionalLight, Float32BufferAttribute, Group,
  HemisphereLight, LineBasicMaterial, LineLoop, LineSegments, type Material, Mesh, MeshBasicMaterial, MeshStandardMaterial, type Object3D, PCFShadowMap,
  PerspectiveCamera, PlaneGeometry, Raycaster, Scene, ShadowMaterial, SphereGeometry, TorusGeometry, Vector2, Vector3, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { RoundedBoxGeometry } from "three/addons/geometries/RoundedBoxGeometry.js";
import { draggedTo, type Held } from "./drag";
import type { BodyModel, Link, Shape, Vec } from "./model";
import { extent, grounded, type Place, placed } from "./pose";
import type { Tone } from "./tone";

export interface Colours { accent: string; good: string; warn: string; bad: string; muted: string; line: string; dark: boolean }
export interface Hooks {
  /** A joint was tapped; empty: none. */
  onPick(joint: string): void;
  /** A limb is being dragged there; false: it may not be. */
  onDrag(joint: string, rad: number): boolean;
  onDrop(joint: string): void;
}

const AXES: Record<string, Vector3> = { x: new Vector3(1, 0, 0), y: new Vector3(0, 1, 0), z: new Vector3(0, 0, 1) };
const TAP_PX = 6;
/** Half of what is left of the way to what was measured is made in so many milliseconds. */
const HALF_MS = 35;
const GHOST_RAD = 0.05;
const FOV_DEG = 34;
/** A body that leans further than this is looked at as one that lies. */
const LIES_RAD = 1;
/** Frames that come slower than this, so many times on end, are drawn with less effort: what holds the robot needs the time. */
const SLOW_MS = 70;
const SLOW_FRAMES = 5;
/** Where even that is slow, it is drawn this often at most. */
const RARE_MS = 120;

type Side = "front" | "left" | "back";
interface Bone { link: Link; group: Group; hinge: Group; meshes: Mesh[]; joint: string }
interface Built { root: Group; bones: Map<string, Bone>; byJoint: Map<string, Bone> }

function geometry({ kind, size }: Shape): BufferGeometry {
  const [a = 0.01, b = 0.01, c = 0.01] = size;
  if (kind === "box") return new RoundedBoxGeometry(a, b, c, 3, 0.24 * Math.min(a, b, c));
  if (kind === "cylinder") return new CylinderGeometry(a, a, b, 36).rotateX(Math.PI / 2);
  if (kind === "capsule") return new CapsuleGeometry(a, b, 8, 20).rotateX(Math.PI / 2);
  const ball = new SphereGeometry(kind === "sphere" ? a : 1, 32, 20);
  return kind === "sphere" ? ball : ball.scale(a, b, c);
}

/** Builds the links one within the other; each turns by its own group `hinge`. */
function build(model: BodyModel, material: (shape: Shape) => Material): Built {
  const root = new Group();
  const bones = new Map<string, Bone>();
  const byJoint = new Map<string, Bone>();
  for (const link of model.links) {
    const group = new Group();
    group.position.set(...link.origin_xyz);
    group.rotation.set(...link.origin_rpy, "ZYX");
    const hinge = new Group();
    group.add(hinge);
    const parent = bones.get(link.parent);
    (parent?.hinge ?? root).add(group);
    const joint = link.joint || (parent?.joint ?? "");
    const meshes = link.shapes.map((shape) => {
      const mesh = new Mesh(geometry(shape), material(shape));
      mesh.position.set(...shape.xyz);
      mesh.rotation.set(...shape.rpy, "ZYX");
      mesh.castShadow = mesh.receiveShadow = true;
      mesh.userData["joint"] = joint;
      hinge.add(mesh);
      return mesh;
    });
    const bone = { link, group, hinge, meshes, joint };
    bones.set(link.name, bone);
    if (link.joint) byJoint.set(link.joint, bone);
  }
  return { root, bones, byJoint };
}

export class Stage {
  private readonly renderer: WebGLRenderer;
  private readonly scene = new Scene();
  private readonly camera = new PerspectiveCamera(FOV_DEG, 1, 0.01, 50);
  private readonly controls: OrbitControls;
  private readonly body: Built;
  private readonly ghost: Built;
  private readonly upright = new Group();
  private readonly rings = new Map<string, Mesh<TorusGeometry, MeshBasicMaterial>>();
  private readonly lifted: Group;
  private readonly ray = new Raycaster();
  private readonly wanted = new Map<string, number>();
  private readonly shown = new Map<string, number>();
  private readonly aims = new Map<string, number>();
  private readonly tones = new Map<string, Tone>();
  /** How large what there is to look at is, and all of it. */
  private readonly size: number;
  private readonly wide: number;
  private readonly watch: ResizeObserver;
  private readonly sun = new DirectionalLight(0xffffff, 2.4);
  private readonly sky = new HemisphereLight(0xffffff, 0x445055, 1.5);
  private arc: Group | null = null;
  private held: { held: Held; joint: string; from: number; start: Vector2; moved: boolean; pointer: number } | null = null;
  private selected = "";
  private tilt = { roll: 0, pitch: 0 };
  private shownTilt = { roll: 0, pitch: 0 };
  private lies = false;
  private side: Side = "front";
  private mayDrag = true;
  private frame = 0;
  private last = 0;
  private stale = true;
  /** Whether what is wanted was brought nearer since it was last given. */
  private posed = false;
  private slow = 0;
  private drawnAt = 0;
  private effort = 2;

  constructor(private readonly canvas: HTMLCanvasElement, private readonly model: BodyModel, private colours: Colours, private readonly hooks: Hooks) {
    this.renderer = new WebGLRenderer({ canvas, antialias: true, alpha: true, powerPreference: "low-power" });
    this.renderer.toneMapping = ACESFilmicToneMapping;
    this.renderer.toneMappingExposure = 1.05;
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = PCFShadowMap;
    this.body = build(model, (shape) => new MeshStandardMaterial({ color: new Color().setRGB(shape.rgba[0], shape.rgba[1], shape.rgba[2], "srgb"), roughness: 0.52, metalness: 0.06, transparent: shape.rgba[3] < 1, opacity: shape.rgba[3] }));
    const glass = new MeshBasicMaterial({ color: colours.accent, transparent: true, opacity: 0.34, depthWrite: false });
    this.ghost = build(model, () => glass);
    for (const bone of this.ghost.bones.values()) for (const mesh of bone.meshes) mesh.castShadow = mesh.receiveShadow = mesh.visible = false;
    this.lifted = new Group();
    this.lifted.add(this.body.root, this.ghost.root);
    this.upright.add(this.lifted);
    this.upright.rotation.x = -Math.PI / 2;
    this.scene.add(this.upright);
    for (const bone of this.body.bones.values()) for (const mesh of bone.meshes) mesh.userData["colour"] = (mesh.material as MeshStandardMaterial).color.clone();
    const { low, high } = this.seen({});
    const whole = extent(model, placed(model, {}));
    this.size = largest(low, high);
    this.wide = largest(whole.low, whole.high);
    this.addRings();
    this.addFloor();
    this.addLight();
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enableDamping = true;
    this.controls.dampingFactor = 0.12;
    this.controls.enablePan = false;
    this.controls.maxPolarAngle = 1.75;
    this.controls.minDistance = 0.6 * this.size;
    this.controls.maxDistance = 6 * this.size;
    this.look("front");
    this.controls.addEventListener("change", () => this.ask());
    canvas.addEventListener("pointerdown", this.press, true);
    canvas.addEventListener("pointermove", this.move);
    canvas.addEventListener("pointerup", this.lift);
    canvas.addEventListener("pointercancel", this.lift);
    this.watch = new ResizeObserver(() => this.resize());
    this.watch.observe(canvas);
    this.resize();
    this.warmUp();
    this.ask();
  }

  /** Draws once all that may come, so that nothing is prepared while something moves. */
  private warmUp(): void {
    const ghosts = [...this.ghost.bones.values()].flatMap((bone) => bone.meshes);
    for (const mesh of ghosts) mesh.visible = true;
    this.select([...this.rings.keys()][0] ?? "");
    this.renderer.render(this.scene, this.camera);
    const took = this.measured();
    if (took > SLOW_MS) this.ease();
    if (took > 2 * SLOW_MS) this.ease();
    for (const mesh of ghosts) mesh.visible = false;
    this.select("");
  }

  /** How long it takes to draw once more, until the last dot is there. */
  private measured(): number {
    const begun = performance.now();
    this.renderer.render(this.scene, this.camera);
    this.renderer.getContext().readPixels(0, 0, 1, 1, 6408, 5121, new Uint8Array(4));
    return performance.now() - begun;
  }

  /** Where the joints were measured, and to where they are on their way. */
  setPose(angles: Record<string, number | null | undefined>, aims: Record<string, number | null | undefined>): void {
    for (const joint of this.body.byJoint.keys()) {
      const angle = angles[joint];
      if (angle != null && Number.isFinite(angle)) {
        this.wanted.set(joint, angle);
        if (!this.shown.has(joint)) this.shown.set(joint, angle);
      }
      const aim = aims[joint];
      if (aim != null && Number.isFinite(aim)) this.aims.set(joint, aim);
      else this.aims.delete(joint);
    }
    this.posed = false;
    this.ask();
  }

  /** How the body leans, by its inertial unit; null: not known, then it stands upright. */
  setTilt(roll: number | null, pitch: number | null): void {
    this.tilt = { roll: roll ?? 0, pitch: pitch ?? 0 };
    this.ask();
  }

  setTones(tones: Record<string, Tone>): void {
    for (const [joint, tone] of Object.entries(tones)) {
      if (this.tones.get(joint) === tone) continue;
      this.tones.set(joint, tone);
      this.paint(joint);
    }
  }

  select(joint: string): void {
    if (joint === this.selected) return;
    const before = this.selected;
    this.selected = joint;
    this.paint(before);
    this.paint(joint);
    this.drawArc();
  }

  /** Whether dragging a limb moves it; else it turns the view. */
  setDrag(may: boolean): void {
    this.mayDrag = may;
  }

  setColours(colours: Colours): void {
    this.colours = colours;
    for (const joint of this.rings.keys()) this.paint(joint);
    this.drawArc();
    this.ask();
  }

  /** Looks at all of it from a side. */
  look(from: Side): void {
    this.side = from;
    const { low, high } = this.seen(Object.fromEntries(this.shown), this.leant());
    const middle = new Vector3((low[0] + high[0]) / 2, low[2] + (high[2] - low[2]) * 0.49, -(low[1] + high[1]) / 2);
    const yaw = { front: 0.5, left: Math.PI / 2, back: Math.PI - 0.5 }[from];
    const aspect = this.camera.aspect || 1;
    const tall = Math.max(high[2] - low[2], 0.1);
    const wide = Math.max(Math.hypot(high[1] - low[1], high[0] - low[0]), this.lies ? this.size : 0);
    const reach = Math.max(tall, wide / Math.max(aspect, 0.3)) / 2 / Math.tan((FOV_DEG * Math.PI) / 360);
    const away = 1.34 * reach + wide / 3;
    this.camera.position.set(middle.x + away * Math.cos(yaw) * 0.97, middle.y + away * 0.2, middle.z - away * Math.sin(yaw) * 0.97);
    this.controls.target.copy(middle);
    this.controls.update();
    this.ask();
  }

  /** The box around what there is to look at: all of it, or what moves if that is a small part of it. */
  private seen(angles: Record<string, number>, root?: Place): { low: Vec; high: Vec } {
    const places = placed(this.model, angles, root);
    const whole = extent(this.model, places);
    const links = this.model.links.filter((link) => this.body.bones.get(link.name)?.joint);
    const moving = extent({ ...this.model, links }, places);
    return links.length > 0 && moving.high[2] - moving.low[2] < 0.5 * (whole.high[2] - whole.low[2]) ? moving : whole;
  }

  dispose(): void {
    cancelAnimationFrame(this.frame);
    this.watch.disconnect();
    this.controls.dispose();
    this.canvas.removeEventListener("pointerdown", this.press, true);
    this.canvas.removeEventListener("pointermove", this.move);
    this.canvas.removeEventListener("pointerup", this.lift);
    this.canvas.removeEventListener("pointercancel", this.lift);
    this.scene.traverse((one) => {
      const mesh = one as Partial<Mesh>;
      mesh.geometry?.dispose();
      for (const material of [mesh.material ?? []].flat()) material.dispose();
    });
    this.renderer.dispose();
  }

  /** The middle of a joint on the screen, in pixels of the canvas: for tests and labels. */
  whereIs(joint: string): [number, number] | null {
    const bone = this.body.byJoint.get(joint);
    if (!bone) return null;
    const mesh = bone.meshes[0] ?? bone.hinge;
    return this.project(mesh.getWorldPosition(new Vector3()));
  }

  private addRings(): void {
    const radius = 0.062 * (this.size < this.wide ? 2 : 1) * this.size;
    for (const [joint, bone] of this.body.byJoint) {
      if (this.model.joints[joint]?.kind === "wheel" || !(joint in this.model.joints)) continue;
      const ring = new Mesh(new TorusGeometry(radius, 0.075 * radius, 10, 48), new MeshBasicMaterial({ color: this.colours.muted, transparent: true, opacity: 0.9 }));
      ring.quaternion.setFromUnitVectors(AXES["z"]!, new Vector3(...bone.link.axis));
      ring.userData["joint"] = joint;
      bone.hinge.add(ring);
      this.rings.set(joint, ring);
      this.paint(joint);
    }
  }

  private addFloor(): void {
    const ground = new Mesh(new PlaneGeometry(8 * this.wide, 8 * this.wide), new ShadowMaterial({ opacity: 0.28 }));
    ground.rotation.x = -Math.PI / 2;
    ground.receiveShadow = true;
    this.scene.add(ground);
    const lines = new LineBasicMaterial({ color: this.colours.muted, transparent: true, opacity: 0.28 });
    for (const part of [0.45, 0.8, 1.15]) {
      const circle = new CircleGeometry(part * this.wide, 96);
      const ring = new LineLoop(new BufferGeometry().setAttribute("position", new Float32BufferAttribute(circle.attributes["position"]!.array.slice(3), 3)), lines);
      ring.rotation.x = -Math.PI / 2;
      ring.position.y = 0.0005;
      this.scene.add(ring);
    }
    const ahead = new BufferGeometry().setAttribute("position", new Float32BufferAttribute([0.45, 0, 0, 0.62, 0, 0, 0.57, 0, 0.025, 0.62, 0, 0, 0.57, 0, -0.025, 0.62, 0, 0].map((value) => value * this.wide), 3));
    this.scene.add(new LineSegments(ahead, lines));
  }

  private addLight(): void {
    this.sun.position.set(1.6 * this.wide, 2.6 * this.wide, -1.1 * this.wide);
    this.sun.castShadow = true;
    this.sun.shadow.mapSize.set(1024, 1024);
    const camera = this.sun.shadow.camera;
    camera.left = camera.bottom = -1.1 * this.wide;
    camera.right = camera.top = 1.1 * this.wide;
    camera.far = 8 * this.wide;
    this.sun.shadow.bias = -0.0006;
    this.sun.shadow.radius = 4;
    const rim = new DirectionalLight(0xbfe8ff, 0.9);
    rim.position.set(-2 * this.wide, 1.4 * this.wide, 1.6 * this.wide);
    this.scene.add(this.sun, this.sky, rim);
  }

  private paint(joint: string): void {
    const ring = this.rings.get(joint);
    const tone = this.tones.get(joint) ?? "unread";
    const picked = joint !== "" && joint === this.selected;
    const { accent, good, warn, bad, muted } = this.colours;
    const colour = { near: good, held: good, moving: accent, loaded: bad, fault: bad, hot: warn, limp: muted, unread: muted, doubt: warn }[tone];
    if (ring) {
      ring.material.color.set(picked && !["loaded", "fault"].includes(tone) ? accent : colour);
      ring.material.opacity = picked ? 1 : tone === "limp" || tone === "unread" ? 0.5 : 0.85;
      ring.scale.setScalar(picked ? 1.22 : 1);
    }
    const red = tone === "loaded" || tone === "fault";
    for (const bone of this.body.bones.values()) {
      if (bone.joint !== joint) continue;
      for (const mesh of bone.meshes) {
        const material = mesh.material as MeshStandardMaterial;
        const own = mesh.userData["colour"] as Color;
        material.color.copy(own);
        if (red) material.color.lerp(new Color(bad), 0.7);
        material.emissive.set(red ? bad : picked ? accent : "#000000");
        material.emissiveIntensity = red ? 0.22 : picked ? 0.16 : 0;
      }
    }
    this.ask();
  }

  /** A fan that shows how far the chosen joint may go. */
  private drawArc(): void {
    this.arc?.removeFromParent();
    this.arc?.traverse((one) => (one as Partial<Mesh>).geometry?.dispose());
    this.arc = null;
    this.ask();
    const bone = this.body.byJoint.get(this.selected);
    const range = this.model.joints[this.selected];
    if (!bone || range?.lower == null || range.upper == null || range.kind !== "hinge") return;
    const arc = new Group();
    const radius = 0.16 * this.size;
    const fan = new Mesh(new CircleGeometry(radius, 48, range.lower, range.upper - range.lower), new MeshBasicMaterial({ color: this.colours.accent, transparent: true, opacity: 0.18, side: 2, depthWrite: false }));
    const ends = [range.lower, range.upper].flatMap((at) => [0, 0, 0, radius * Math.cos(at), radius * Math.sin(at), 0]);
    const edges = new LineSegments(new BufferGeometry().setAttribute("position", new Float32BufferAttribute(ends, 3)), new LineBasicMaterial({ color: this.colours.accent, transparent: true, opacity: 0.8 }));
    arc.add(fan, edges);
    const axis = new Vector3(...bone.link.axis);
    const limb = this.limb(bone).projectOnPlane(axis);
    if (limb.length() < 1e-6) limb.copy(Math.abs(axis.x) < 0.9 ? AXES["x"]! : AXES["y"]!).projectOnPlane(axis);
    limb.normalize();
    const third = new Vector3().crossVectors(axis, limb);
    arc.matrix.makeBasis(limb, third, axis);
    arc.quaternion.setFromRotationMatrix(arc.matrix);
    bone.group.add(arc);
    this.arc = arc;
  }

  /** Where the limb of a joint points to: the middle of what it moves. */
  private limb(bone: Bone): Vector3 {
    const sum = new Vector3();
    for (const mesh of bone.meshes) sum.add(mesh.position);
    if (sum.length() > 1e-3) return sum;
    const child = bone.link.name;
    const next = this.model.links.find((link) => link.parent === child);
    return next ? new Vector3(...next.origin_xyz) : sum;
  }

  private readonly press = (event: PointerEvent): void => {
    if (!event.isPrimary) return;
    const hit = this.hit(event);
    const joint = (hit?.object.userData["joint"] as string | undefined) ?? "";
    const range = this.model.joints[joint];
    const bone = this.body.byJoint.get(joint);
    const start = new Vector2(event.clientX, event.clientY);
    const from = this.wanted.get(joint);
    if (!hit || !bone || !range || range.kind === "wheel" || from === undefined) {
      this.held = { joint: "", held: null as never, from: 0, start, moved: false, pointer: event.pointerId };
      return;
    }
    const axis = new Vector3(...bone.link.axis).transformDirection(bone.group.matrixWorld);
    const centre = bone.group.getWorldPosition(new Vector3());
    const held: Held = {
      axis: axis.toArray() as Vec, centre: centre.toArray() as Vec, point: this.grip(hit.point, centre, axis), angle: this.shown.get(joint) ?? from,
      lower: range.lower ?? -3.1, upper: range.upper ?? 3.1, slides: range.kind === "slide",
    };
    this.held = { joint, held, from: held.angle, start, moved: false, pointer: event.pointerId };
    if (!this.mayDrag) return;
    this.controls.enabled = false;
    this.canvas.setPointerCapture(event.pointerId);
  };

  /** What is held, but never so near to the axis that nothing would move. */
  private grip(point: Vector3, centre: Vector3, axis: Vector3): Vec {
    const arm = point.clone().sub(centre).projectOnPlane(axis);
    const least = 0.05 * this.size;
    if (arm.length() >= least) return point.toArray() as Vec;
    if (arm.length() < 1e-6) arm.copy(AXES["y"]!).projectOnPlane(axis);
    if (arm.length() < 1e-6) arm.copy(AXES["x"]!).projectOnPlane(axis);
    return point.clone().add(arm.setLength(least)).toArray() as Vec;
  }

  private readonly move = (event: PointerEvent): void => {
    const one = this.held;
    if (!one || event.pointerId !== one.pointer) {
      if (event.pointerType === "mouse" && event.buttons === 0) this.canvas.style.cursor = this.hit(event) ? (this.mayDrag ? "grab" : "pointer") : "";
      return;
    }
    if (!one.moved && one.start.distanceTo(new Vector2(event.clientX, event.clientY)) < TAP_PX) return;
    if (!one.moved && one.joint && this.mayDrag) {
      this.hooks.onPick(one.joint);
      this.canvas.style.cursor = "grabbing";
    }
    one.moved = true;
    if (!one.joint || !this.mayDrag) return;
    const box = this.canvas.getBoundingClientRect();
    one.from = draggedTo(one.held, one.from, [event.clientX - box.left, event.clientY - box.top], (at) => this.project(new Vector3(...at)));
    if (!this.hooks.onDrag(one.joint, one.from)) this.lift(event);
  };

  private readonly lift = (event: PointerEvent): void => {
    const one = this.held;
    if (!one || event.pointerId !== one.pointer) return;
    this.held = null;
    this.controls.enabled = true;
    this.canvas.style.cursor = "";
    if (one.moved && one.joint && this.mayDrag) this.hooks.onDrop(one.joint);
    else if (!one.moved && event.type === "pointerup") this.hooks.onPick(one.joint);
  };

  private hit(event: PointerEvent) {
    const box = this.canvas.getBoundingClientRect();
    const at = new Vector2(((event.clientX - box.left) / box.width) * 2 - 1, 1 - ((event.clientY - box.top) / box.height) * 2);
    this.ray.setFromCamera(at, this.camera);
    const seen = [...this.body.bones.values()].flatMap((bone) => bone.meshes as Object3D[]);
    return this.ray.intersectObjects([...seen, ...this.rings.values()], false)[0];
  }

  private project(at: Vector3): [number, number] {
    const { x, y } = at.clone().project(this.camera);
    const { clientWidth: width, clientHeight: height } = this.canvas;
    return [((x + 1) / 2) * width, ((1 - y) / 2) * height];
  }

  private resize(): void {
    const [width, height] = [Math.max(1, this.canvas.clientWidth), Math.max(1, this.canvas.clientHeight)];
    const first = this.camera.aspect === 1;
    this.renderer.setPixelRatio(this.effort > 0 ? Math.min(2, devicePixelRatio) : 0.6);
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    if (first) this.look("front");
    this.ask();
  }

  /** Has it drawn with the next frame. At rest no frame is asked for. */
  private ask(): void {
    this.stale = true;
    if (this.frame) return;
    this.last = performance.now();
    this.frame = requestAnimationFrame(this.draw);
  }

  private readonly draw = (now: number): void => {
    const dt = Math.max(0, Math.min(200, now - this.last));
    this.last = now;
    const part = 1 - 0.5 ** (dt / HALF_MS);
    if (this.controls.update()) this.stale = true;
    if (this.follow(part)) this.stale = true;
    this.frame = this.stale ? requestAnimationFrame(this.draw) : 0;
    if (!this.stale || (this.effort === 0 && now - this.drawnAt < RARE_MS)) return;
    this.stale = false;
    this.drawnAt = now;
    this.slow = dt > SLOW_MS ? this.slow + 1 : 0;
    if (this.slow >= SLOW_FRAMES && this.effort > 0) this.ease();
    this.renderer.render(this.scene, this.camera);
  };

  /** Draws with less effort: without shadows first, then coarser. */
  private ease(): void {
    this.effort -= 1;
    this.slow = 0;
    this.sun.castShadow = false;
    if (this.effort === 0) this.resize();
  }

  /** Brings what is shown nearer to what was measured; says whether anything moved. */
  private follow(part: number): boolean {
    let changed = !this.posed;
    this.posed = true;
    for (const [joint, angle] of this.wanted) {
      const was = this.shown.get(joint) ?? angle;
      const is = Math.abs(angle - was) < 1e-4 ? angle : was + (angle - was) * part;
      if (is !== was) changed = true;
      this.shown.set(joint, is);
    }
    for (const axis of ["roll", "pitch"] as const) {
      const way = this.tilt[axis] - this.shownTilt[axis];
      if (Math.abs(way) < 2e-3) continue;
      this.shownTilt[axis] += way * part;
      changed = true;
    }
    if (!changed) return false;
    this.showGhosts();
    for (const [joint, angle] of this.shown) {
      turn(this.body.byJoint.get(joint), this.model, angle);
      turn(this.ghost.byJoint.get(joint), this.model, this.aims.get(joint) ?? angle);
    }
    this.stand();
    return true;
  }

  /** Shows where limbs are to go that are not there yet. */
  private showGhosts(): void {
    const going = [...this.aims].filter(([joint, aim]) => Math.abs(aim - (this.shown.get(joint) ?? aim)) > GHOST_RAD).map(([joint]) => joint);
    const carried = new Set<string>();
    for (const bone of this.ghost.bones.values()) {
      if (going.includes(bone.link.joint) || carried.has(bone.link.parent)) carried.add(bone.link.name);
      for (const mesh of bone.meshes) mesh.visible = carried.has(bone.link.name);
    }
  }

  /** Leans it as measured, on the floor; looks at all of it when it has fallen, and when it is up again. */
  private stand(): void {
    const { p, q: [w, x, y, z] } = this.leant();
    this.lifted.quaternion.set(x, y, z, w);
    this.lifted.position.set(...p);
    this.upright.updateMatrixWorld(true);
    const lies = Math.hypot(this.shownTilt.roll, this.shownTilt.pitch) > LIES_RAD;
    if (lies === this.lies) return;
    this.lies = lies;
    this.look(this.side);
  }

  private leant(): Place {
    return grounded(this.model, Object.fromEntries(this.shown), this.shownTilt.roll, this.shownTilt.pitch);
  }
}

const largest = (low: Vec, high: Vec): number => Math.max(high[2] - low[2], high[0] - low[0], high[1] - low[1], 0.1);

function turn(bone: Bone | undefined, model: BodyModel, angle: number): void {
  if (!bone) return;
  const [x, y, z] = bone.link.axis;
  if (model.joints[bone.link.joint]?.kind === "slide") bone.hinge.position.set(x * angle, y * angle, z * angle);
  else bone.hinge.quaternion.setFromAxisAngle(new Vector3(x, y, z), angle);
}
