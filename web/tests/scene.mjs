// SPDX-License-Identifier: Apache-2.0
// A scene that is computed: a wall, a hand of balls before it, and landmarks that are known. Nothing in it is symmetric.

export const camera = { model: "projective", width: 320, height: 240, fx: 280, fy: 284, cx: 156.5, cy: 122.25, pixel_origin: "centre" };
export const kWall_mm = 900;

const fingers = {
  thumb: ["cmc", "mcp", "ip", "tip"], index: ["mcp", "pip", "dip", "tip"], middle: ["mcp", "pip", "dip", "tip"],
  ring: ["mcp", "pip", "dip", "tip"], little: ["mcp", "pip", "dip", "tip"],
};
const layout = {  // [base x, base y, step x, step y] around the wrist [mm]; y points down
  thumb: [-28, -24, -15, -19], index: [-24, -84, -5, -25], middle: [-2, -89, 0, -28], ring: [19, -83, 5, -24], little: [37, -71, 9, -18],
};

export const bones = Object.entries(fingers).flatMap(([finger, parts]) => parts.map((part, i) =>
  [i === 0 ? "wrist" : `${finger}_${parts[i - 1]}`, `${finger}_${part}`]));
export const landmarks = ["wrist", "palm", ...Object.entries(fingers).flatMap(([finger, parts]) => parts.map((part) => `${finger}_${part}`))];

export const info = {
  version: "0.2.0", source: "synthetic:scene?rate=30", camera, convention: "knuckle22", landmarks, bones, pipeline: "pipelines/track.toml",
  recording: { file: null, frames: 0, dropped: 0 }, can_record: true,
};

export function project([x, y, z], c = camera) {
  const [u, v] = c.model === "orthographic" ? [x, y] : [x / z, y / z];
  return [c.fx * u + c.cx, c.fy * v + c.cy];
}

function unproject(column, row, depth_mm, c) {
  const scale = c.model === "orthographic" ? 1 : depth_mm;
  return [((column - c.cx) / c.fx) * scale, ((row - c.cy) / c.fy) * scale, depth_mm];
}

/** A hand whose wrist is at a place [mm]; left hands are mirrored. */
export function makeHand({ id = 1, side = "right", wrist = [30, 75, 450], score = 0.82, curl = 0, camera: c = camera } = {}) {
  const mirror = side === "left" ? -1 : 1;
  const points = { wrist, palm: [wrist[0], wrist[1] - 45, wrist[2] + 2] };
  for (const [finger, parts] of Object.entries(fingers)) {
    const [x, y, dx, dy] = layout[finger];
    parts.forEach((part, i) => {
      points[`${finger}_${part}`] = [wrist[0] + mirror * (x + i * dx), wrist[1] + y + i * dy * (1 - curl), wrist[2] - 8 * i * curl];
    });
  }
  const names = landmarks;
  return {
    id, side, score,
    landmarks_mm: Object.fromEntries(names.map((name) => [name, points[name]])),
    landmarks_px: Object.fromEntries(names.map((name) => [name, project(points[name], c)])),
    confidence: Object.fromEntries(names.map((name, i) => [name, 0.95 - 0.02 * i])),
  };
}

/** Capsules around a hand's bones [mm]. */
export function surfaceOf(hand) {
  return bones.map(([from, to]) => [...hand.landmarks_mm[from], 9, ...hand.landmarks_mm[to], 7.5]);
}

/** Balls [x, y, z, radius] that stand for the flesh of hands. */
function ballsOf(hands) {
  return hands.flatMap((hand) => bones.flatMap(([from, to]) => {
    const [a, b] = [hand.landmarks_mm[from], hand.landmarks_mm[to]];
    const steps = from === "wrist" ? 9 : 3;
    return Array.from({ length: steps }, (_, i) => a.map((value, k) => value + ((b[k] - value) * i) / (steps - 1)).concat(from === "wrist" ? 12 : 8.5));
  }));
}

/** Depth of balls before a wall that leans, in millimetres; the upper left corner is not measured. */
export function renderDepth(balls, c = camera) {
  const depth = new Uint16Array(c.width * c.height);
  for (let row = 0; row < c.height; ++row) {
    for (let column = 0; column < c.width; ++column) {
      depth[row * c.width + column] = row < 24 && column < 40 ? 0 : Math.round(kWall_mm + 0.6 * (column - c.cx));
    }
  }
  for (const [x, y, z, radius] of balls) {
    const [u, v] = project([x, y, z], c);
    const reach = Math.ceil((c.model === "orthographic" ? c.fx : c.fx / (z - radius)) * radius) + 2;
    for (let row = Math.max(0, Math.floor(v - reach)); row <= Math.min(c.height - 1, v + reach); ++row) {
      for (let column = Math.max(0, Math.floor(u - reach)); column <= Math.min(c.width - 1, u + reach); ++column) {
        const [px, py] = unproject(column, row, z, c);
        const off = (px - x) ** 2 + (py - y) ** 2;
        if (off > radius ** 2) continue;
        const nearest = z - Math.sqrt(radius ** 2 - off);
        const i = row * c.width + column;
        if (depth[i] === 0 || nearest < depth[i]) depth[i] = Math.round(nearest);
      }
    }
  }
  return depth;
}

/** A header of /api/frames for hands. */
export function makeHeader({ frame = 0, hands = [], status = "", c = camera, infrared = false, surface = null, latency_ms = 7.5 } = {}) {
  return {
    record: { frame, name: String(frame).padStart(6, "0"), time_s: frame / 30, status, hands, latency_ms },
    camera: c, width: c.width, height: c.height, depth_unit_mm: 1, infrared,
    surface: surface ?? hands.map(surfaceOf), recording: { file: null, frames: 0, dropped: 0 }, arrived: frame + 1, passed_over: 0,
  };
}

export function depthOf(hands, c = camera, more = []) {
  return renderDepth([...ballsOf(hands), ...more], c);
}

export function makeInfrared(depth) {
  return depth.map((count) => (count === 0 ? 0 : Math.min(60000, 2.4e8 / count ** 1.5)));
}
