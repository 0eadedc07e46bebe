// SPDX-License-Identifier: Apache-2.0
// The point cloud with skeletons and fitted surfaces, which one can turn. Lengths are millimetres.
import {
  BufferGeometry, DataTexture, GLSL3, Group, Matrix4, PerspectiveCamera, Points, RawShaderMaterial, RedIntegerFormat, RGBAFormat, Scene,
  UnsignedByteType, UnsignedShortType, Vector2, Vector3, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { Capsules } from "./capsules.ts";
import type { DepthRange } from "./depth_range.ts";
import { handColours, kPaletteSize, rgbOf } from "./palette.ts";
import { kPointFragmentShader, kPointVertexShader } from "./point_shader.ts";
import { PointBudget } from "./point_budget.ts";
import type { Camera, FrameHeader, FrameImages, Point2, Point3 } from "./protocol.ts";
import { pixelSeenAt } from "./seen_pixel.ts";
import { confidenceOf, opacityOf, sizeOf } from "./skeleton.ts";

export type Viewpoint = "front" | "side" | "top" | "oblique";

/** Turn about the vertical, and rise above the horizontal [degrees], around the hand. */
const kViewpoints: Record<Viewpoint, [number, number]> = {
  front: [0, 0],
  side: [80, 8],
  top: [0, 80],
  oblique: [-32, 18],
};

/** What the view was aimed at by itself; it is aimed again where there is something better. */
const Sees = { nothing: 0, scene: 1, hand: 2 } as const;

const kFieldOfView_deg = 40;
const kBorder = 0.6;  // of the way from the middle of the view to its edges: a hand is seen whole within
const kPoints = 1_000_000;
const kPointsInSoftware = 80_000;  // a processor draws some two million points in a second
const kBackground = 0x11161c;

/** Where the picture is taken from, in the sensor's coordinates (x right, y down, z forward) [mm]. */
export interface SeenFrom {
  position: Point3;
  target: Point3;
  field_of_view_deg: number;  // of the height
}

export class CloudView {
  showsCloud = true;
  showsSkeleton = true;
  showsSurface = true;
  closeness = 1;  // how many times nearer than the sensor one looks from
  isCut = false;  // points beyond both ends of the colours are left out

  #canvas: HTMLCanvasElement;
  #renderer: WebGLRenderer;
  #camera = new PerspectiveCamera(kFieldOfView_deg, 1, 10, 30000);
  #controls: OrbitControls;
  #cloudScene = new Scene();
  #skeletonScene = new Scene();
  #surface = new Group();
  #points: Points<BufferGeometry, RawShaderMaterial>;
  #depth = depthTexture(1, 1, new Uint16Array(1));
  #bones = new Capsules({ around: 8, rings: 2 }, { transparent: true }, 0.35);
  #flesh = new Capsules({ around: 16, rings: 4 }, { colorWrite: false });
  #budget: PointBudget;
  #size = new Vector2();
  #aimedAt: number = Sees.nothing;
  #wasMoved = false;
  #images: FrameImages | null = null;
  #header: FrameHeader | null = null;
  #range: DepthRange | null = null;

  /** Throws where there is no WebGL 2. `changed` is called when the user has turned it. */
  constructor(canvas: HTMLCanvasElement, palette: Uint8Array, changed: () => void) {
    this.#canvas = canvas;
    const isSlow = isDrawnInSoftware();
    this.#budget = new PointBudget(isSlow ? kPointsInSoftware : kPoints);
    this.#renderer = new WebGLRenderer({ canvas, antialias: !isSlow, powerPreference: "high-performance" });
    this.#renderer.autoClear = false;
    this.#renderer.setClearColor(kBackground);
    this.#points = pointCloud(this.#depth, palette);
    this.#surface.add(this.#flesh.mesh, this.#flesh.meshWith({ colorWrite: true, transparent: true, depthWrite: false }));
    this.#surface.children.forEach((mesh, i) => { mesh.renderOrder = 1 + i; });
    // The sensor's y points down and its z away; three.js' y points up and its z towards the viewer.
    for (const scene of [this.#cloudScene, this.#skeletonScene]) scene.scale.set(1, -1, -1);
    this.#cloudScene.add(this.#points, this.#surface);
    this.#skeletonScene.add(this.#bones.mesh);
    this.#controls = new OrbitControls(this.#camera, canvas);
    this.#controls.minDistance = 40;
    this.#controls.maxDistance = 15000;
    this.#controls.addEventListener("start", () => { this.#wasMoved = true; });
    this.#controls.addEventListener("change", changed);
    this.look("oblique", [0, 0, 600]);
    this.#wasMoved = false;
  }

  /** Takes a new frame. */
  take(images: FrameImages, header: FrameHeader, bones: readonly [string, string][]): void {
    this.#images = images;
    this.#header = header;
    this.#takeDepth(images);
    this.#takeCamera(header.camera, header.depth_unit_mm);
    this.#takeHands(header, bones);
    this.#takeSurface(header);
    const sees = header.record.hands.length > 0 ? Sees.hand : Sees.scene;
    if (!this.#wasMoved && (sees > this.#aimedAt || this.#isHandLeaving(header))) this.#aim(header, images);
    this.#aimedAt = Math.max(sees, this.#aimedAt);
  }

  /** Forgets where the view was aimed: the next frame is aimed at anew. */
  forget(): void {
    this.#aimedAt = Sees.nothing;
  }

  /** To be called before each of the browser's pictures; true where it is to be drawn again, with more or fewer points. */
  tick(now_ms: number): boolean {
    if (!this.#budget.tick(now_ms)) return false;
    this.#setStride(this.#depth.image.width, this.#depth.image.height);
    return true;
  }

  draw(range: DepthRange): void {
    this.#fit();
    this.#range = range;
    const { uniforms } = this.#points.material;
    uniforms["range_mm"]!.value.set(range.near_mm, range.far_mm);
    uniforms["focal_px"]!.value = this.#canvas.height / (2 * Math.tan((kFieldOfView_deg * Math.PI) / 360));
    uniforms["is_cut"]!.value = this.isCut;
    this.#points.visible = this.showsCloud;
    this.#surface.visible = this.showsSurface;
    this.#renderer.clear();
    this.#renderer.render(this.#cloudScene, this.#camera);
    if (!this.showsSkeleton) return;
    this.#renderer.clearDepth();  // a skeleton lies below the skin: it is seen through the points before it
    this.#renderer.render(this.#skeletonScene, this.#camera);
  }

  /** Looks from a fixed side at `target`, or at what it looks at already. */
  look(from: Viewpoint, target?: Point3): void {
    if (target) this.#controls.target.set(target[0], -target[1], -target[2]);
    const at = this.#controls.target;
    const distance = Math.min(Math.max(-at.z, 200), 3000) / this.closeness;
    const [turn, rise] = kViewpoints[from].map((angle) => (angle * Math.PI) / 180) as [number, number];
    this.#camera.position.set(Math.sin(turn) * Math.cos(rise), Math.sin(rise), Math.cos(turn) * Math.cos(rise))
      .multiplyScalar(distance).add(at);
    this.#controls.update();
    this.#wasMoved = true;
  }

  /** Aims at the hands of a frame, or at what is in the middle of its image. */
  reset(header: FrameHeader | null, images: FrameImages): void {
    if (header) this.#aim(header, images);
    else this.look("oblique");
    this.#wasMoved = false;
  }

  /** Turns around what is looked at [degrees]: to the left, and up. */
  turn(left_deg: number, up_deg: number): void {
    this.#wasMoved = true;
    this.#controls.rotateLeft((left_deg * Math.PI) / 180);
    this.#controls.rotateUp((up_deg * Math.PI) / 180);
  }

  /** Moves what is looked at across the picture [px]. */
  pan(right: number, down: number): void {
    this.#wasMoved = true;
    this.#controls.pan(right, down);
  }

  zoom(factor: number): void {
    this.#wasMoved = true;
    this.#controls.dollyIn(1 / factor);
  }

  /** While something is dragged, the pointer does not turn the view. */
  hold(isHeld: boolean): void {
    this.#controls.enabled = !isHeld;
  }

  /** Where a point in the sensor's coordinates [mm] is seen on the canvas [CSS px]; null behind the viewer. */
  canvasAt([x, y, z]: Point3): Point2 | null {
    this.#camera.updateMatrixWorld();
    const seen = new Vector3(x, -y, -z).project(this.#camera);
    if (seen.z > 1) return null;
    return [((seen.x + 1) / 2) * this.#canvas.clientWidth, ((1 - seen.y) / 2) * this.#canvas.clientHeight];
  }

  /** Column and row of the measured point that is seen at a place of the canvas [CSS px]; null where there is none, or points are not shown. */
  pixelAt(x: number, y: number): Point2 | null {
    if (!this.showsCloud || !this.#images || !this.#header) return null;
    const { width, height, depth } = this.#images;
    const { camera, depth_unit_mm: unit_mm } = this.#header;
    const range = this.isCut ? this.#range : null;
    const isDrawn = (depth_mm: number): boolean => !range || (depth_mm >= range.near_mm && depth_mm <= range.far_mm);
    this.#camera.updateMatrixWorld();
    const clipFromSensor = new Matrix4().multiplyMatrices(this.#camera.projectionMatrix, this.#camera.matrixWorldInverse)
      .scale(new Vector3(1, -1, -1)).elements;
    return pixelSeenAt([x, y], { depth, width, height, unit_mm, camera, isDrawn },
      { width: this.#canvas.clientWidth, height: this.#canvas.clientHeight, clipFromSensor });
  }

  /** The point moved in the screen's plane by so much [CSS px]. */
  movedOnScreen([x, y, z]: Point3, right: number, down: number): Point3 {
    this.#camera.updateMatrixWorld();
    const at = new Vector3(x, -y, -z).project(this.#camera);
    at.x += (2 * right) / Math.max(1, this.#canvas.clientWidth);
    at.y -= (2 * down) / Math.max(1, this.#canvas.clientHeight);
    at.unproject(this.#camera);
    return [at.x, -at.y, -at.z];
  }

  seenFrom(): SeenFrom {
    const inSensor = (at: Vector3): Point3 => [at.x, -at.y, -at.z];
    return {
      position: inSensor(this.#camera.position),
      target: inSensor(this.#controls.target),
      field_of_view_deg: kFieldOfView_deg,
    };
  }

  #aim(header: FrameHeader, images: FrameImages): void {
    const centre = centreOfHands(header) ?? centreOfImage(header, images);
    if (!centre) return;
    this.look("oblique", centre);
    this.#wasMoved = false;
  }

  /** Whether the middle of the hands is near the border of what is seen, or outside. */
  #isHandLeaving(header: FrameHeader): boolean {
    const centre = centreOfHands(header);
    if (!centre) return false;
    this.#camera.updateMatrixWorld();
    const at = new Vector3(centre[0], -centre[1], -centre[2]).project(this.#camera);
    return Math.abs(at.x) > kBorder || Math.abs(at.y) > kBorder;
  }

  #fit(): void {
    const width = Math.max(1, this.#canvas.clientWidth);
    const height = Math.max(1, this.#canvas.clientHeight);
    const ratio = Math.min(window.devicePixelRatio, 2);
    this.#renderer.getSize(this.#size);
    if (this.#size.x === width && this.#size.y === height && this.#renderer.getPixelRatio() === ratio) return;
    this.#renderer.setPixelRatio(ratio);
    this.#renderer.setSize(width, height, false);
    this.#camera.aspect = width / height;
    this.#camera.updateProjectionMatrix();
  }

  #takeDepth(images: FrameImages): void {
    if (this.#depth.image.data !== images.depth || this.#depth.image.width !== images.width) {
      this.#depth.dispose();
      this.#depth = depthTexture(images.width, images.height, images.depth);
      this.#points.material.uniforms["depth_image"]!.value = this.#depth;
      this.#setStride(images.width, images.height);
    }
    this.#depth.needsUpdate = true;
  }

  /** Draws every pixel, or every second, third, ... column and row where all would be too many. */
  #setStride(width: number, height: number): void {
    const stride = Math.max(1, Math.ceil(Math.sqrt((width * height) / this.#budget.points)));
    this.#points.material.uniforms["stride"]!.value = stride;
    this.#points.geometry.setDrawRange(0, Math.ceil(width / stride) * Math.ceil(height / stride));
  }

  #takeCamera(camera: Camera, unit_mm: number): void {
    const { uniforms } = this.#points.material;
    const shift = camera.pixel_origin === "corner" ? 0.5 : 0;
    uniforms["lens"]!.value = [camera.fx, camera.fy, camera.cx - shift, camera.cy - shift];
    uniforms["depth_unit_mm"]!.value = unit_mm;
    uniforms["is_orthographic"]!.value = camera.model === "orthographic";
    uniforms["is_distorted"]!.value = camera.distortion.some((k) => k !== 0);
    const distortion = uniforms["distortion"]!.value as number[];
    for (let i = 0; i < 8; ++i) distortion[i] = camera.distortion[i] ?? 0;
  }

  #takeHands(header: FrameHeader, bones: readonly [string, string][]): void {
    const { hands } = header.record;
    const colours = handColours(hands);
    this.#bones.begin();
    hands.forEach((hand, i) => {
      const rgb = rgbOf(colours[i]!);
      for (const [from, to] of bones) {
        const a = hand.landmarks_mm[from];
        const b = hand.landmarks_mm[to];
        if (!a || !b) continue;
        const opacity = opacityOf(Math.min(confidenceOf(hand, from), confidenceOf(hand, to)));
        this.#bones.add(a[0], a[1], a[2], 1.7, b[0], b[1], b[2], 1.7, rgb, opacity);
      }
      for (const name in hand.landmarks_mm) {
        const at = hand.landmarks_mm[name];
        if (!at) continue;
        const confidence = confidenceOf(hand, name);
        const radius = 4 * sizeOf(confidence);
        this.#bones.add(at[0], at[1], at[2], radius, at[0], at[1], at[2], radius, rgb, opacityOf(confidence));
      }
    });
    this.#bones.end();
  }

  #takeSurface(header: FrameHeader): void {
    const colours = handColours(header.record.hands);
    this.#flesh.begin();
    header.surface.forEach((capsules, i) => {
      const rgb = rgbOf(colours[i] ?? "#f2f4f7");
      for (const c of capsules) this.#flesh.add(c[0]!, c[1]!, c[2]!, c[3]!, c[4]!, c[5]!, c[6]!, c[7]!, rgb, 0.34);
    });
    this.#flesh.end();
  }
}

/** True where no graphics processor draws: smooth edges and all points would cost too much then. Throws without WebGL 2. */
function isDrawnInSoftware(): boolean {
  const context = document.createElement("canvas").getContext("webgl2");
  if (!context) throw new Error("no WebGL 2");
  const name = context.getExtension("WEBGL_debug_renderer_info");
  const renderer = name ? String(context.getParameter(name.UNMASKED_RENDERER_WEBGL)) : "";
  context.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software/i.test(renderer);
}

function depthTexture(width: number, height: number, data: Uint16Array<ArrayBufferLike>): DataTexture {
  const texture = new DataTexture(data as Uint16Array<ArrayBuffer>, width, height, RedIntegerFormat, UnsignedShortType);
  texture.internalFormat = "R16UI";
  texture.unpackAlignment = 2;
  texture.needsUpdate = true;
  return texture;
}

function pointCloud(depth: DataTexture, palette: Uint8Array): Points<BufferGeometry, RawShaderMaterial> {
  const colours = new DataTexture(palette as Uint8Array<ArrayBuffer>, kPaletteSize, 1, RGBAFormat, UnsignedByteType);
  colours.needsUpdate = true;
  const material = new RawShaderMaterial({
    glslVersion: GLSL3, vertexShader: kPointVertexShader, fragmentShader: kPointFragmentShader,
    uniforms: {
      depth_image: { value: depth }, palette: { value: colours }, depth_unit_mm: { value: 1 }, lens: { value: [1, 1, 0, 0] },
      is_orthographic: { value: false }, is_distorted: { value: false }, distortion: { value: new Array<number>(8).fill(0) },
      range_mm: { value: new Vector2(300, 1500) }, focal_px: { value: 500 }, is_cut: { value: false }, stride: { value: 1 },
    },
  });
  const points = new Points(new BufferGeometry(), material);  // no attributes: a vertex is its number
  points.geometry.setDrawRange(0, 0);
  points.frustumCulled = false;
  return points;
}

function centreOfHands(header: FrameHeader): Point3 | null {
  const sum: Point3 = [0, 0, 0];
  let count = 0;
  for (const hand of header.record.hands) {
    for (const at of Object.values(hand.landmarks_mm)) {
      if (!at) continue;
      for (let i = 0; i < 3; ++i) sum[i]! += at[i]!;
      ++count;
    }
  }
  return count === 0 ? null : [sum[0] / count, sum[1] / count, sum[2] / count];
}

/** Straight ahead, as far as the middle of the image's depths. */
function centreOfImage(header: FrameHeader, images: FrameImages): Point3 | null {
  const measured: number[] = [];
  for (let i = 0; i < images.depth.length; i += 97) if (images.depth[i] !== 0) measured.push(images.depth[i]!);
  if (measured.length === 0) return null;
  measured.sort((a, b) => a - b);
  return [0, 0, measured[measured.length >> 1]! * header.depth_unit_mm];
}
