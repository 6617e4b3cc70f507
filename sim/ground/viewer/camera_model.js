// Where a keyframe's camera sees a place (fsw/base/geometry.hpp; pixel centres at integers).

const rotation = ([w, x, y, z]) => [
  1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),
  2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
  2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y),
];

/// camera_from_world, row by row.
export function rotationOf(keyframe) {
  keyframe.rotation ??= rotation(keyframe.pose.q);
  return keyframe.rotation;
}

/// { u, v } in pixels, or null where the place is not in the picture.
export function project(keyframe, x, y, z) {
  if (!keyframe.pose) return null;
  const r = rotationOf(keyframe);
  const [cx, cy, cz] = keyframe.pose.centre;
  const [dx, dy, dz] = [x - cx, y - cy, z - cz];
  const depth = r[6] * dx + r[7] * dy + r[8] * dz;
  if (!(depth > 0)) return null;
  const a = (r[0] * dx + r[1] * dy + r[2] * dz) / depth;
  const b = (r[3] * dx + r[4] * dy + r[5] * dz) / depth;
  const [width, height, fx, fy, px, py, k1, k2, p1, p2, k3 = 0, k4 = 0, k5 = 0, k6 = 0, fisheye = 0] =
    keyframe.camera;
  // Far outside the picture the distortion turns back into it.
  const [far_x, far_y] = fisheye ? [4 * fx, 4 * fy] : [width, height];
  if (Math.abs(a * fx) > far_x || Math.abs(b * fy) > far_y) return null;
  const q = a * a + b * b;
  let radial = (1 + q * (k1 + q * (k2 + q * k3))) / (1 + q * (k4 + q * (k5 + q * k6)));
  if (fisheye) {
    const r = Math.sqrt(q), angle = Math.atan(r), s = angle * angle;
    radial = r > 0 ? angle * (1 + s * (k1 + s * (k2 + s * (k3 + s * k4)))) / r : 1;
  }
  const u = fx * (a * radial + 2 * p1 * a * b + p2 * (q + 2 * a * a)) + px;
  const v = fy * (b * radial + p1 * (q + 2 * b * b) + 2 * p2 * a * b) + py;
  if (u < -0.5 || v < -0.5 || u > width - 0.5 || v > height - 0.5) return null;
  return { u, v };
}

/// Those of the strip's keyframes that have the place in their picture, nearest first.
export function seenBy(strip, x, y, z) {
  const found = [];
  for (const keyframe of strip.members) {
    const pixel = project(keyframe, x, y, z);
    if (!pixel) continue;
    const [cx, cy] = keyframe.pose.centre;
    found.push({ keyframe, pixel, far: Math.hypot(x - cx, y - cy) });
  }
  return found.sort((p, q) => p.far - q.far);
}
