// SPDX-License-Identifier: Apache-2.0
// Which pixel of the depth image is seen at a place of the point cloud: what a click on a point means.
import type { Camera, Point2, Point3 } from "./protocol.ts";

const kReach_px = 6;  // of points around the pointer
const kOneSurface = 0.02;  // of the distance from the viewer: points that are as near as this to the nearest belong to what is seen

/** A depth image, and the points of it that are drawn. */
export interface DrawnPoints {
  depth: Uint16Array<ArrayBufferLike>;  // counts; 0: not measured
  width: number;
  height: number;
  unit_mm: number;
  camera: Camera;
  isDrawn: (depth_mm: number) => boolean;
}

/** A canvas [CSS px], and where points in the sensor's coordinates are seen on it: columns of a 4 x 4 matrix, to clip space. */
export interface Canvas {
  width: number;
  height: number;
  clipFromSensor: ArrayLike<number>;
}

/** Column and row of the measured point that is seen at (x, y): of the nearest surface, the one nearest to the pointer; null where there is none. */
export function pixelSeenAt([x, y]: Point2, points: DrawnPoints, canvas: Canvas): Point2 | null {
  const near: { pixel: Point2; off: number; away: number }[] = [];
  for (let row = 0, i = 0; row < points.height; ++row) {
    for (let column = 0; column < points.width; ++column, ++i) {
      const depth_mm = points.depth[i]! * points.unit_mm;
      if (depth_mm === 0 || !points.isDrawn(depth_mm)) continue;
      const [u, v, away] = seen(inSensor(column, row, depth_mm, points.camera), canvas);
      const off = Math.hypot(u - x, v - y);
      if (away > 0 && off <= kReach_px) near.push({ pixel: [column, row], off, away });
    }
  }
  const nearest = Math.min(...near.map(({ away }) => away));
  const onSurface = near.filter(({ away }) => away <= (1 + kOneSurface) * nearest);
  return onSurface.sort((a, b) => a.off - b.off)[0]?.pixel ?? null;
}

/** Where a point is seen [CSS px], and how far away along the line of sight; not above 0 behind the viewer. */
function seen([x, y, z]: Point3, { width, height, clipFromSensor: m }: Canvas): Point3 {
  const along = (i: number): number => m[i]! * x + m[i + 4]! * y + m[i + 8]! * z + m[i + 12]!;
  const away = along(3);
  return [((along(0) / away + 1) / 2) * width, ((1 - along(1) / away) / 2) * height, away];
}

/** As the points' shader has it. */
export function inSensor(column: number, row: number, depth_mm: number, camera: Camera): Point3 {
  const shift = camera.pixel_origin === "corner" ? 0.5 : 0;
  const plane: Point2 = [(column - (camera.cx - shift)) / camera.fx, (row - (camera.cy - shift)) / camera.fy];
  if (camera.model === "orthographic") return [plane[0], plane[1], depth_mm];
  const [x, y] = camera.distortion.some((k) => k !== 0) ? undistorted(plane, camera.distortion) : plane;
  return [x * depth_mm, y * depth_mm, depth_mm];
}

/** OpenCV's k1, k2, p1, p2, k3, k4, k5, k6, as far as there are any. */
function distorted([x, y]: Point2, k: readonly number[]): Point2 {
  const [k1 = 0, k2 = 0, p1 = 0, p2 = 0, k3 = 0, k4 = 0, k5 = 0, k6 = 0] = k;
  const r2 = x * x + y * y;
  const radial = (1 + r2 * (k1 + r2 * (k2 + r2 * k3))) / (1 + r2 * (k4 + r2 * (k5 + r2 * k6)));
  return [x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x), y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y];
}

/** The inverse, by fixed-point iteration: lenses bend little. */
function undistorted(target: Point2, k: readonly number[]): Point2 {
  let at = target;
  for (let i = 0; i < 8; ++i) {
    const [x, y] = distorted(at, k);
    at = [at[0] + target[0] - x, at[1] + target[1] - y];
  }
  return at;
}
