#include "fsw/localisation/fix_book.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/vision/geometry/rigid_transform.hpp"

namespace ilp {
namespace {

constexpr double drift_between_fixes = 0.01;  // of the way between two fixes
constexpr double most_agreeing_px = 16;       // however uncertain the way between them is

void add(const navigation::MeasuredKeyframe& fix, FixBook& book) {
  if (book.fixes.full()) book.fixes.erase(0);
  static_cast<void>(book.fixes.push_back(fix));
}

}  // namespace

navigation::StripFrame frame_by_fixes(const FixBook& book, navigation::MeasuredKeyframes& scratch) {
  scratch.clear();
  for (const navigation::MeasuredKeyframe& fix : book.fixes) static_cast<void>(scratch.push_back(fix));
  return navigation::estimate_strip_frame(scratch);
}

FixDistance distance_by_odometry(const navigation::MeasuredKeyframe& other, const navigation::MeasuredKeyframe& fix,
                                 navigation::MeasuredKeyframes& scratch) {
  scratch.clear();
  static_cast<void>(scratch.push_back(other));
  const navigation::StripFrame frame = navigation::estimate_strip_frame(scratch);
  constexpr double nowhere = 1e300;
  if (!(frame.fixed_sigma_m[0] > 0) || !(frame.scale_sigma > 0)) return {nowhere, 0};
  const double depth = fix.fix.depth > 0 ? fix.fix.depth : fix.fix.distance_m / frame.metres_per_unit;
  const Vec3 axis = rotation_from_quaternion(fix.q_cam_from_strip).row(2);
  const navigation::FixedPlace at = navigation::place_by_fixes(frame, vector_of(fix.centre) + depth * axis);
  const Vec3 way = frame.metres_per_unit * (vector_of(fix.centre) - vector_of(other.centre));
  const double dx = at.place_m.x() - fix.fix.ground_m[0], dy = at.place_m.y() - fix.fix.ground_m[1];
  const double drift = drift_between_fixes * way.norm();
  return {
      std::sqrt(dx * dx + dy * dy),
      std::sqrt(at.sigma_m[0] * at.sigma_m[0] + fix.fix.ground_sigma_m[0] * fix.fix.ground_sigma_m[0] + drift * drift)};
}

FixState judge_fix(const navigation::MeasuredKeyframe& fix, double pixel_m, bool wants_second, FixBook& book,
                   navigation::MeasuredKeyframes& scratch) {
  if (!wants_second) {
    book.has_unconfirmed = 0;
    book.rejected = 0;
    add(fix, book);
    return FixState::accepted;
  }
  if (book.has_unconfirmed != 0) {
    const FixDistance between = distance_by_odometry(book.unconfirmed, fix, scratch);
    if (between.metres <= std::clamp(3 * between.sigma, agreeing_fixes_px * pixel_m, most_agreeing_px * pixel_m)) {
      // Both stand against all before them.
      book.fixes.clear();
      add(book.unconfirmed, book);
      add(fix, book);
      book.has_unconfirmed = 0;
      book.rejected = 0;
      return FixState::accepted;
    }
  }
  book.unconfirmed = fix;
  book.has_unconfirmed = 1;
  ++book.rejected;
  return FixState::unconfirmed;
}

}  // namespace ilp
