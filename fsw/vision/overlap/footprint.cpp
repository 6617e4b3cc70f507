#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "fsw/base/math.hpp"
#include "fsw/vision/overlap/centred_similarity.hpp"
#include "fsw/vision/overlap/overlap.hpp"

namespace ilp {
namespace {

struct Vertex {
  double x, y;
};

// A rectangle cut by ten half planes gains one vertex per cut; rounding adds at most half as many again.
struct Polygon {
  std::array<Vertex, 32> vertices;
  std::size_t count = 0;
};

// Keeps the part where line . (x, y, 1) >= 0 (I. Sutherland, G. Hodgman, "Reentrant polygon clipping", 1974).
Polygon clip(const Polygon& polygon, const double (&line)[3]) {
  Polygon kept;
  for (std::size_t i = 0; i < polygon.count; ++i) {
    const Vertex& p = polygon.vertices[i];
    const Vertex& q = polygon.vertices[(i + 1) % polygon.count];
    const double side_p = line[0] * p.x + line[1] * p.y + line[2];
    const double side_q = line[0] * q.x + line[1] * q.y + line[2];
    if (side_p >= 0) kept.vertices[kept.count++] = p;
    if ((side_p > 0 && side_q < 0) || (side_p < 0 && side_q > 0)) {
      const double t = side_p / (side_p - side_q);
      kept.vertices[kept.count++] = {p.x + t * (q.x - p.x), p.y + t * (q.y - p.y)};
    }
  }
  return kept;
}

double area(const Polygon& polygon) {
  double twice = 0;
  for (std::size_t i = 0; i < polygon.count; ++i) {
    const Vertex& p = polygon.vertices[i];
    const Vertex& q = polygon.vertices[(i + 1) % polygon.count];
    twice += p.x * q.y - q.x * p.y;
  }
  return 0.5 * std::fabs(twice);
}

Polygon whole_image(std::int32_t width, std::int32_t height) {
  const double right = width - 0.5, bottom = height - 0.5;
  return {{{{-0.5, -0.5}, {right, -0.5}, {right, bottom}, {-0.5, bottom}}}, 4};
}

/// Keeps the part that the homography maps into the image.
Polygon cut_to_image(Polygon polygon, std::int32_t width, std::int32_t height, const double (&h)[9]) {
  const double right = width - 0.5, bottom = height - 0.5;
  // The borders of b seen in image a: a line l of b is the line H^T l of a. Positive on b's inside; the first is
  // infinity.
  const double borders[5][3] = {{0, 0, 1}, {1, 0, 0.5}, {0, 1, 0.5}, {-1, 0, right}, {0, -1, bottom}};
  for (const double(&l)[3] : borders) {
    const double line[3] = {h[0] * l[0] + h[3] * l[1] + h[6] * l[2], h[1] * l[0] + h[4] * l[1] + h[7] * l[2],
                            h[2] * l[0] + h[5] * l[1] + h[8] * l[2]};
    polygon = clip(polygon, line);
  }
  return polygon;
}

}  // namespace

double footprint_overlap_of_plane(std::int32_t width, std::int32_t height, const double (&b_from_a)[9]) {
  if (width <= 0 || height <= 0) return 0;
  const Polygon image = whole_image(width, height);
  return area(cut_to_image(image, width, height, b_from_a)) / area(image);
}

double footprint_shared_by_three(std::int32_t width, std::int32_t height, const double (&b_from_a)[9],
                                 const double (&c_from_b)[9]) {
  if (width <= 0 || height <= 0) return 0;
  double c_from_a[9];
  compose_planes(c_from_b, b_from_a, c_from_a);
  const Polygon image = whole_image(width, height);
  const Polygon in_b = cut_to_image(image, width, height, b_from_a);
  return area(cut_to_image(in_b, width, height, c_from_a)) / area(image);
}

double footprint_overlap(std::int32_t width, std::int32_t height, const Similarity2& b_from_a) {
  const double c = b_from_a.scale * det_cos(b_from_a.rotation_rad);
  const double s = b_from_a.scale * det_sin(b_from_a.rotation_rad);
  const double h[9] = {c, -s, b_from_a.shift_x_px, s, c, b_from_a.shift_y_px, 0, 0, 1};
  return footprint_overlap_of_plane(width, height, h);
}

Similarity2 similarity_at_centre(std::int32_t width, std::int32_t height, const double (&h)[9]) {
  const double cx = 0.5 * (width - 1), cy = 0.5 * (height - 1);
  const double w = 1 / (h[6] * cx + h[7] * cy + h[8]);
  const double x = (h[0] * cx + h[1] * cy + h[2]) * w;
  const double y = (h[3] * cx + h[4] * cy + h[5]) * w;
  const double dx_dx = (h[0] - x * h[6]) * w, dx_dy = (h[1] - x * h[7]) * w;
  const double dy_dx = (h[3] - y * h[6]) * w, dy_dy = (h[4] - y * h[7]) * w;
  return about_origin({0.5 * (dx_dx + dy_dy), 0.5 * (dy_dx - dx_dy), x - cx, y - cy}, width, height);
}

double view_turn_of_plane(std::int32_t width, std::int32_t height, const double (&h)[9]) {
  const double along_x = h[6] * (width - 1), along_y = h[7] * (height - 1);
  const double corners[4] = {h[8], h[8] + along_x, h[8] + along_y, h[8] + along_x + along_y};
  const double least = *std::min_element(corners, corners + 4);
  const double most = *std::max_element(corners, corners + 4);
  return least > 0 ? most / least : std::numeric_limits<double>::infinity();
}

bool invert_plane(const double (&h)[9], double (&a_from_b)[9]) {
  const double cofactors[9] = {h[4] * h[8] - h[5] * h[7], h[2] * h[7] - h[1] * h[8], h[1] * h[5] - h[2] * h[4],
                               h[5] * h[6] - h[3] * h[8], h[0] * h[8] - h[2] * h[6], h[2] * h[3] - h[0] * h[5],
                               h[3] * h[7] - h[4] * h[6], h[1] * h[6] - h[0] * h[7], h[0] * h[4] - h[1] * h[3]};
  const double determinant = h[0] * cofactors[0] + h[1] * cofactors[3] + h[2] * cofactors[6];
  if (!(std::fabs(determinant) > 1e-12 * std::fabs(h[8])) || std::fabs(cofactors[8]) < 1e-12) return false;
  for (int i = 0; i < 9; ++i) a_from_b[i] = cofactors[i] / cofactors[8];
  return true;
}

void compose_planes(const double (&c_from_b)[9], const double (&b_from_a)[9], double (&c_from_a)[9]) {
  double product[9];
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      double sum = 0;
      for (int k = 0; k < 3; ++k) sum += c_from_b[3 * row + k] * b_from_a[3 * k + column];
      product[3 * row + column] = sum;
    }
  }
  const double scale = std::fabs(product[8]) > 1e-9 ? 1 / product[8] : 1;
  for (int i = 0; i < 9; ++i) c_from_a[i] = product[i] * scale;
}

}  // namespace ilp
