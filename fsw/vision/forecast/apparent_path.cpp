#include "fsw/vision/forecast/apparent_path.hpp"

#include "fsw/base/math.hpp"
#include "fsw/vision/overlap/centred_similarity.hpp"
#include "fsw/vision/overlap/overlap.hpp"

namespace ilp {
namespace {

struct Complex {
  double re = 0, im = 0;
};
Complex operator-(Complex a, Complex b) {
  return {a.re - b.re, a.im - b.im};
}
Complex operator*(Complex a, Complex b) {
  return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
}
Complex operator/(Complex a, Complex b) {
  const double n = 1 / (b.re * b.re + b.im * b.im);
  return {(a.re * b.re + a.im * b.im) * n, (a.im * b.re - a.re * b.im) * n};
}

}  // namespace

void begin_path(TimeNs keyframe_ns, ApparentPath& path) {
  path = {};
  path.keyframe.time_ns = keyframe_ns;
  static_cast<void>(path.points.push_back(path.keyframe));
}

bool extend_path(std::int32_t width, std::int32_t height, TimeNs frame_ns, const Similarity2& frame_from_keyframe,
                 bool time_trusted, ApparentPath& path) {
  if (path.points.empty() || frame_ns <= path.points.back().time_ns || !(frame_from_keyframe.scale > 0)) return false;
  const Complex m{frame_from_keyframe.scale * det_cos(frame_from_keyframe.rotation_rad),
                  frame_from_keyframe.scale * det_sin(frame_from_keyframe.rotation_rad)};
  const Complex centre{0.5 * (width - 1), 0.5 * (height - 1)};
  const Complex moved = m * centre;
  const Complex d{moved.re + frame_from_keyframe.shift_x_px - centre.re,
                  moved.im + frame_from_keyframe.shift_y_px - centre.im};
  const Complex m_key{path.keyframe.m_re, path.keyframe.m_im};
  // The frame's centre in the keyframe, then in the first image.
  const Complex p = Complex{path.keyframe.p_x, path.keyframe.p_y} - (d / m) / m_key;
  const Complex m_first = m * m_key;
  if (path.points.full()) {
    path.points.erase(0);
    path.points[0].time_trusted = true;
  }
  PathPoint point;
  point.time_ns = frame_ns;
  point.p_x = p.re;
  point.p_y = p.im;
  point.m_re = m_first.re;
  point.m_im = m_first.im;
  point.time_trusted = time_trusted;
  return path.points.push_back(point);
}

bool select_place(TimeNs keyframe_ns, ApparentPath& path) {
  for (const PathPoint& point : path.points) {
    if (point.time_ns != keyframe_ns) continue;
    path.keyframe = point;
    return true;
  }
  return false;
}

bool set_tilt(TimeNs frame_ns, double tilt_x_px, double tilt_y_px, ApparentPath& path) {
  for (PathPoint& point : path.points) {
    if (point.time_ns != frame_ns) continue;
    point.tilt_x = tilt_x_px;
    point.tilt_y = tilt_y_px;
    point.tilt_known = true;
    return true;
  }
  return false;
}

double overlap_of_places(std::int32_t width, std::int32_t height, const PathPoint& keyframe, double p_x, double p_y,
                         double m_re, double m_im) {
  const Complex m{m_re, m_im};
  const Complex turn = m / Complex{keyframe.m_re, keyframe.m_im};
  const Complex d = m * (Complex{keyframe.p_x, keyframe.p_y} - Complex{p_x, p_y});
  return footprint_overlap(width, height, about_origin({turn.re, turn.im, d.re, d.im}, width, height));
}

}  // namespace ilp
