#include "fsw/vision/navigation/strip_frame.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "fsw/base/math.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"
#include "fsw/vision/navigation/position_level.hpp"

namespace ilp::navigation {
namespace {

constexpr std::uint32_t least_measurements = 3;
// Two kinds of measurement contradict each other beyond this many sigmas of their difference and this share.
constexpr double contradiction_sigmas = 5;
constexpr double contradiction_share = 0.02;
// Where nothing says what is up, the first camera of the strip is taken to look down. One that is 0.1 rad off sees the
// ground farther away by this share.
constexpr double open_tilt_share = 0.005;

Use use_of(const RobustMean& mean) {
  return {mean.used, mean.refused};
}

/// Of the weighted mean of two values that are both known.
double joint_sigma(double a, double b) {
  return std::sqrt(a * a * b * b / (a * a + b * b));
}

/// Rotation by the shortest way from one unit vector to another.
Mat3 shortest_rotation(const Vec3& from, const Vec3& to) {
  const Vec3 axis = from.cross(to);
  const double sine = axis.norm();
  if (!(sine > 1e-12)) return from.dot(to) > 0 ? Mat3::Identity() : Mat3(Vec3(1, -1, -1).asDiagonal());
  return rotation_from_vector(axis * (det_atan2(sine, from.dot(to)) / sine));
}

Mat3 rotation_about_up(double angle) {
  return rotation_from_vector(Vec3(0, 0, angle));
}

/// The part of an angle within half a turn of another.
double near_angle(double angle, double reference) {
  const double turns = (angle - reference) / (2 * pi);
  return angle - 2 * pi * std::floor(turns + 0.5);
}

class Solver {
 public:
  explicit Solver(const MeasuredKeyframes& keyframes) : keyframes_(keyframes) {}

  StripFrame solve() {
    positions_contradict_ = positions_stand_still(keyframes_);
    if (positions_contradict_) frame_.verdict = StripFrameVerdict::positions_frozen;
    find_up();
    if (!positions_contradict_) level_by_track();
    find_heading_by_attitudes();
    compare_positions();
    find_scale();
    find_place();
    if (frozen_ > 0) frame_.positions = {0, frozen_};
    const bool any = frame_.scale_sigma > 0 || frame_.tilt_sigma_rad > 0 || frame_.heading_sigma_rad > 0;
    if (any && frame_.verdict == StripFrameVerdict::nothing_measured) frame_.verdict = StripFrameVerdict::ok;
    return frame_;
  }

 private:
  [[nodiscard]] static Mat3 level_from_strip_of(const MeasuredKeyframe& k) {
    return rotation_from_quaternion(k.q_cam_from_level).transpose() * rotation_from_quaternion(k.q_cam_from_strip);
  }

  [[nodiscard]] static Mat3 fix_level_from_strip_of(const MeasuredKeyframe& k) {
    return rotation_from_quaternion(k.fix.q_cam_from_level).transpose() * rotation_from_quaternion(k.q_cam_from_strip);
  }
  [[nodiscard]] static bool is_fixed(const MeasuredKeyframe& k) { return k.fix.ground_sigma_m[0] > 0; }

  /// The error of a mean over the fixes, with what they have in common, which no mean takes away. 0 stays.
  template <typename SigmaOf>
  [[nodiscard]] double with_shared(double sigma, SigmaOf sigma_of) const {
    double shared = 0, count = 0;
    for (const MeasuredKeyframe& k : keyframes_) {
      if (!is_fixed(k)) continue;
      shared += k.fix.shared * sigma_of(k) * sigma_of(k);
      ++count;
    }
    return sigma > 0 && count > 0 ? std::sqrt(sigma * sigma + shared / count) : sigma;
  }

  struct Up {
    Vec3 up = Vec3(0, 0, 1);
    double sigma = 0;  ///< 0: not known
    Use use;
  };
  /// The tilts that attitudes say, about a first guess of what is up.
  template <typename LevelOf, typename SigmaOf>
  Up mean_up(LevelOf level_of, SigmaOf sigma_of, std::uint32_t least) const {
    Up found;
    Vec3 sum = Vec3::Zero();
    for (const MeasuredKeyframe& k : keyframes_) {
      if (sigma_of(k) > 0) sum += level_of(k).row(2).transpose();
    }
    if (!(sum.norm() > 0)) return found;
    Vec3 up = sum.normalized();
    RobustMean tilts[2];
    // The second turn starts from a guess without outliers.
    for (int turn = 0; turn < 2; ++turn) {
      const Mat3 guess = shortest_rotation(up, Vec3(0, 0, 1));
      for (int axis = 0; axis < 2; ++axis) {
        Measurements values;
        for (const MeasuredKeyframe& k : keyframes_) {
          if (!(sigma_of(k) > 0)) continue;
          const Vec3 seen = guess * level_of(k).row(2).transpose();
          static_cast<void>(values.push_back({seen[axis], sigma_of(k)}));
        }
        tilts[axis] = robust_mean(values);
      }
      const Vec3 mean(tilts[0].value, tilts[1].value, 0);
      up = (guess.transpose() * (mean + Vec3(0, 0, std::sqrt(std::max(0.0, 1 - mean.squaredNorm()))))).normalized();
    }
    found.use = use_of(tilts[0].used < tilts[1].used ? tilts[0] : tilts[1]);
    if (found.use.used < least) return found;
    found.up = up;
    found.sigma = std::sqrt(0.5 * (tilts[0].sigma * tilts[0].sigma + tilts[1].sigma * tilts[1].sigma));
    return found;
  }

  void find_up() {
    Up up = mean_up(
        level_from_strip_of, [](const MeasuredKeyframe& k) { return k.tilt_sigma_rad; }, least_measurements);
    frame_.attitudes = up.use;
    Up fixed = mean_up(
        fix_level_from_strip_of, [](const MeasuredKeyframe& k) { return is_fixed(k) ? k.fix.tilt_sigma_rad : 0; }, 1);
    if (fixed.sigma > 0) {
      fixed.sigma = with_shared(fixed.sigma, [](const MeasuredKeyframe& k) { return k.fix.tilt_sigma_rad; });
      const double allowed = std::sqrt(up.sigma * up.sigma + fixed.sigma * fixed.sigma);
      const bool agree = up.sigma > 0 && (up.up - fixed.up).norm() <= contradiction_sigmas * allowed;
      // The map is what the strip must agree with; a sensor may be off by a constant.
      if (up.sigma > 0 && !agree) frame_.attitudes = {0, up.use.used + up.use.refused};
      up_by_fixes_ = true;
      if (agree) {
        const double weight = fixed.sigma * fixed.sigma / (allowed * allowed);
        up = {(fixed.up + weight * (up.up - fixed.up)).normalized(), joint_sigma(up.sigma, fixed.sigma), up.use};
      } else {
        up = fixed;
      }
    }
    if (!(up.sigma > 0)) return;
    frame_.level_from_strip = shortest_rotation(up.up, Vec3(0, 0, 1));
    frame_.tilt_sigma_rad = up.sigma;
  }

  template <typename LevelOf, typename SigmaOf>
  RobustMean mean_heading(LevelOf level_of, SigmaOf sigma_of) const {
    Measurements headings;
    double reference = 0;
    for (const MeasuredKeyframe& k : keyframes_) {
      if (!(sigma_of(k) > 0)) continue;
      const Mat3 turn = level_of(k) * frame_.level_from_strip.transpose();
      const double angle = det_atan2(turn(1, 0) - turn(0, 1), turn(0, 0) + turn(1, 1));
      if (headings.empty()) reference = angle;
      static_cast<void>(headings.push_back({near_angle(angle, reference), sigma_of(k)}));
    }
    return robust_mean(headings);
  }

  /// Where no attitude says what is up, or a track in three dimensions contradicts it, the positions do, as far as
  /// their track turns. The map knows better than both.
  void level_by_track() {
    const PositionLevel level = level_by_positions(keyframes_);
    if (!level.known || up_by_fixes_) return;
    if (frame_.tilt_sigma_rad > 0) {
      const double apart = sigmas_from_level(level, frame_.level_from_strip, frame_.tilt_sigma_rad);
      if (apart <= contradiction_sigmas) return;
      attitudes_contradict_ = true;
      frame_.verdict = StripFrameVerdict::attitudes_contradict;
      frame_.attitudes = {0, frame_.attitudes.used + frame_.attitudes.refused};
    }
    frame_.level_from_strip = level.level_from_strip;
    frame_.tilt_sigma_rad = level.tilt_sigma_rad;
  }

  void find_heading_by_attitudes() {
    if (!(frame_.tilt_sigma_rad > 0) || attitudes_contradict_) return;
    const RobustMean heading = mean_heading(
        level_from_strip_of, [](const MeasuredKeyframe& k) { return k.tilt_sigma_rad > 0 ? k.heading_sigma_rad : 0; });
    if (heading.used < least_measurements) return;
    heading_ = heading.value;
    frame_.heading_sigma_rad = heading.sigma;
  }

  /// Two ends of a way: where the strip has them, and where a measurement has, with its horizontal error.
  struct WayEnd {
    Vec3 seen, reported;
    double sigma = 0;
  };
  struct Ways {
    RobustMean lengths, directions;
  };
  using WayEnds = FixedVector<const MeasuredKeyframe*, max_values>;

  /// Length and direction of the ways between positions half the strip apart, against those of the images.
  void compare_positions() {
    WayEnds placed;
    for (const MeasuredKeyframe& k : keyframes_) {
      if (k.horizontal_sigma_m > 0) static_cast<void>(placed.push_back(&k));
    }
    if (positions_contradict_) frozen_ = static_cast<std::uint32_t>(placed.size());
    if (placed.size() >= 4 && !positions_contradict_) {
      const Ways ways = measure_ways(placed, [](const MeasuredKeyframe& k) {
        return WayEnd{vector_of(k.centre), vector_of(k.place_m), k.horizontal_sigma_m};
      });
      by_positions_ = ways.lengths;
      way_ = ways.directions;
      if (by_positions_.used < least_measurements) {
        by_positions_ = {};
        way_ = {};
      }
    }
    compare_fixes();
    turn_to_north();
  }

  template <typename EndOf>
  Ways measure_ways(const WayEnds& placed, EndOf end_of) const {
    Measurements lengths, directions;
    double reference = 0;
    const std::size_t half = placed.size() / 2;
    for (std::size_t i = 0; i + half < placed.size(); ++i) {
      const WayEnd a = end_of(*placed[i]), b = end_of(*placed[i + half]);
      const Vec3 seen = frame_.level_from_strip * (b.seen - a.seen);
      const Vec3 reported = b.reported - a.reported;
      const double units = std::sqrt(seen.x() * seen.x() + seen.y() * seen.y());
      const double metres = std::sqrt(reported.x() * reported.x() + reported.y() * reported.y());
      const double sigma = std::sqrt(a.sigma * a.sigma + b.sigma * b.sigma);
      // A way that is no longer than its error says nothing, and a hover none at all.
      if (!(metres > contradiction_sigmas * sigma) || !(units > 0)) continue;
      const double angle = det_atan2(reported.y(), reported.x()) - det_atan2(seen.y(), seen.x());
      if (directions.empty()) reference = angle;
      static_cast<void>(lengths.push_back({metres / units, sigma / units}));
      static_cast<void>(directions.push_back({near_angle(angle, reference), sigma / metres}));
    }
    return {robust_mean(lengths), robust_mean(directions)};
  }

  /// The ground point of a fix in the strip.
  [[nodiscard]] static Vec3 ground_in_strip(const MeasuredKeyframe& k, double depth) {
    return vector_of(k.centre) + depth * rotation_from_quaternion(k.q_cam_from_strip).row(2).transpose();
  }
  [[nodiscard]] static double horizontal_sigma(const FixMeasurement& fix) {
    return std::max(fix.ground_sigma_m[0], fix.ground_sigma_m[1]);
  }

  /// The same between the ground points of fixes, and what the fixes' attitudes and distances say.
  void compare_fixes() {
    WayEnds fixed;
    Measurements ratios;
    for (const MeasuredKeyframe& k : keyframes_) {
      if (!is_fixed(k) || !(k.fix.depth > 0)) continue;
      static_cast<void>(fixed.push_back(&k));
      const FixMeasurement& fix = k.fix;
      const double ratio = fix.distance_m / fix.depth;
      const double error =
          std::sqrt(fix.distance_sigma_m * fix.distance_sigma_m + ratio * ratio * fix.depth_sigma * fix.depth_sigma);
      if (ratio > 0 && error > 0) static_cast<void>(ratios.push_back({ratio, error / fix.depth}));
    }
    Ways ways;
    if (fixed.size() >= 2) {
      ways = measure_ways(fixed, [](const MeasuredKeyframe& k) {
        return WayEnd{ground_in_strip(k, k.fix.depth), vector_of(k.fix.ground_m), horizontal_sigma(k.fix)};
      });
    }
    by_fixes_ = joined(ways.lengths, robust_mean(ratios));
    if (!(frame_.tilt_sigma_rad > 0)) return;
    RobustMean heading = mean_heading(
        fix_level_from_strip_of, [](const MeasuredKeyframe& k) { return is_fixed(k) ? k.fix.heading_sigma_rad : 0; });
    heading.value = near_angle(heading.value, ways.directions.value);
    heading.sigma = with_shared(heading.sigma, [](const MeasuredKeyframe& k) { return k.fix.heading_sigma_rad; });
    fix_heading_ = joined(ways.directions, heading);
  }

  /// Of two means of one quantity the weighted one; the first where they contradict each other.
  [[nodiscard]] static RobustMean joined(const RobustMean& a, const RobustMean& b) {
    if (a.used == 0) return b;
    if (b.used == 0) return a;
    const double allowed = std::sqrt(a.sigma * a.sigma + b.sigma * b.sigma);
    if (std::fabs(a.value - b.value) > contradiction_sigmas * allowed) return a;
    RobustMean mean = a;
    mean.value = a.value + a.sigma * a.sigma / (allowed * allowed) * (b.value - a.value);
    mean.sigma = joint_sigma(a.sigma, b.sigma);
    return mean;
  }

  void turn_to_north() {
    if (way_.used > 0) {
      const double sigma = way_.sigma;
      const double difference = near_angle(heading_, way_.value) - way_.value;
      const double allowed = std::sqrt(sigma * sigma + frame_.heading_sigma_rad * frame_.heading_sigma_rad);
      const bool known = frame_.heading_sigma_rad > 0;
      if (known && std::fabs(difference) > contradiction_sigmas * allowed) {
        frame_.verdict = StripFrameVerdict::headings_contradict;
      }
      // A track over ground is what the map must agree with; a compass may be off by a constant.
      const double weight =
          known && frame_.verdict != StripFrameVerdict::headings_contradict ? sigma * sigma / (allowed * allowed) : 0;
      heading_ = way_.value + weight * difference;
      frame_.heading_sigma_rad = sigma * std::sqrt(1 - weight);
    }
    turn_by_fixes();
    if (frame_.heading_sigma_rad > 0) frame_.level_from_strip = rotation_about_up(heading_) * frame_.level_from_strip;
  }

  /// A heading that contradicts the map gives way to it. Against a track of positions nobody knows which is right.
  void turn_by_fixes() {
    if (fix_heading_.used == 0) return;
    const double sigma = frame_.heading_sigma_rad;
    const double difference = near_angle(heading_, fix_heading_.value) - fix_heading_.value;
    const double allowed = std::sqrt(sigma * sigma + fix_heading_.sigma * fix_heading_.sigma);
    if (sigma > 0 && std::fabs(difference) > contradiction_sigmas * allowed) {
      frame_.verdict = way_.used > 0 ? StripFrameVerdict::fixes_contradict : StripFrameVerdict::headings_contradict;
      if (way_.used > 0) {
        frame_.heading_sigma_rad = 0;
        return;
      }
    }
    const bool agree = sigma > 0 && frame_.verdict != StripFrameVerdict::headings_contradict;
    const double weight = agree ? fix_heading_.sigma * fix_heading_.sigma / (allowed * allowed) : 0;
    heading_ = fix_heading_.value + weight * difference;
    frame_.heading_sigma_rad = fix_heading_.sigma * std::sqrt(1 - weight);
  }

  RobustMean scale_by_heights() {
    Measurements ratios;
    for (const MeasuredKeyframe& k : keyframes_) {
      if (!(k.height_sigma_m > 0) || !(k.ground_distance > 0)) continue;
      const double ratio = k.height_m / k.ground_distance;
      const double sigma2 =
          k.height_sigma_m * k.height_sigma_m + ratio * ratio * k.ground_distance_sigma * k.ground_distance_sigma;
      static_cast<void>(ratios.push_back({ratio, std::sqrt(sigma2) / k.ground_distance}));
    }
    RobustMean mean = robust_mean(ratios);
    frame_.heights = use_of(mean);
    const double by_tilt = frame_.tilt_sigma_rad > 0 ? 0 : open_tilt_share * mean.value;
    mean.sigma = std::sqrt(mean.sigma * mean.sigma + by_tilt * by_tilt);
    return mean;
  }

  RobustMean scale_by_velocities() {
    Measurements ratios;
    const MeasuredKeyframe* before = nullptr;
    for (const MeasuredKeyframe& k : keyframes_) {
      if (!(k.velocity_sigma_m_s > 0)) continue;
      if (before != nullptr) {
        const Vec3 mean = 0.5 * (vector_of(before->velocity_m_s) + vector_of(k.velocity_m_s));
        const double speed = mean.norm();
        const double units = (vector_of(k.centre) - vector_of(before->centre)).norm();
        const double seconds = static_cast<double>(k.time_ns - before->time_ns) / 1e9;
        if (speed > contradiction_sigmas * k.velocity_sigma_m_s && units > 0) {
          static_cast<void>(ratios.push_back({speed * seconds / units, k.velocity_sigma_m_s * seconds / units}));
        }
      }
      before = &k;
    }
    const RobustMean mean = robust_mean(ratios);
    frame_.velocities = use_of(mean);
    return mean;
  }

  static bool contradict(const RobustMean& a, const RobustMean& b) {
    const double difference = std::fabs(a.value - b.value);
    return difference > contradiction_sigmas * std::sqrt(a.sigma * a.sigma + b.sigma * b.sigma) &&
           difference > contradiction_share * std::min(a.value, b.value);
  }

  /// The mean of the kinds that agree. Of three kinds one may stand alone; of two that contradict each other nobody
  /// knows which is right.
  void find_scale() {
    const RobustMean kinds[] = {scale_by_heights(), by_positions_, scale_by_velocities(), by_fixes_};
    constexpr std::size_t count = std::size(kinds);
    constexpr std::uint32_t least[count] = {least_measurements, least_measurements, least_measurements, 1};
    Use* const uses[count] = {&frame_.heights, &frame_.positions, &frame_.velocities, &frame_.fixes};
    frame_.positions = use_of(by_positions_);
    frame_.fixes = use_of(by_fixes_);
    std::array<bool, count> agrees{};
    std::uint32_t present = 0, agreeing = 0;
    for (std::size_t i = 0; i < count; ++i) present += kinds[i].used >= least[i] ? 1 : 0;
    for (std::size_t i = 0; i < count; ++i) {
      if (kinds[i].used < least[i]) continue;
      agrees[i] = present == 1;
      for (std::size_t k = 0; k < count; ++k) {
        if (k == i || kinds[k].used < least[k]) continue;
        agrees[i] = agrees[i] || !contradict(kinds[i], kinds[k]);
      }
      agreeing += agrees[i] ? 1 : 0;
    }
    if (agreeing < present) frame_.verdict = StripFrameVerdict::scales_contradict;
    double weights = 0, sum = 0;
    for (std::size_t i = 0; i < count; ++i) {
      if (!agrees[i]) {
        positions_contradict_ = positions_contradict_ || (i == 1 && kinds[i].used >= least[i]);
        fixes_contradict_ = fixes_contradict_ || (i == 3 && kinds[i].used >= least[i]);
        *uses[i] = {0, uses[i]->used + uses[i]->refused};
        continue;
      }
      const double weight = 1 / (kinds[i].sigma * kinds[i].sigma);
      weights += weight;
      sum += weight * kinds[i].value;
    }
    if (!(weights > 0)) return;
    frame_.metres_per_unit = sum / weights;
    frame_.scale_sigma = std::sqrt(1 / weights) / frame_.metres_per_unit;
  }

  void find_place() {
    // Without its scale and its heading a strip has no place, and none by what contradicts.
    if (!(frame_.scale_sigma > 0) || !(frame_.heading_sigma_rad > 0)) return;
    RobustMean place[3], fixed[3];
    if (!positions_contradict_) place_by_positions(place);
    if (!fixes_contradict_) place_by_fixes(fixed);
    const bool placed = place[0].used != 0 && place[1].used != 0;
    if (!placed && fixed[0].used == 0) return;
    if (placed && fixed[0].used != 0 && places_contradict(place, fixed)) {
      frame_.verdict = StripFrameVerdict::fixes_contradict;
      frame_.positions = {0, frame_.positions.used + frame_.positions.refused};
      frame_.fixes = {0, frame_.fixes.used + frame_.fixes.refused};
      return;
    }
    if (placed) {
      // A position counts as refused where one of its components is.
      const bool by_height = place[2].used > 0 && place[2].refused > std::max(place[0].refused, place[1].refused);
      frame_.positions = use_of(by_height ? place[2] : place[0].used < place[1].used ? place[0] : place[1]);
    }
    for (int axis = 0; axis < 3; ++axis) {
      place[axis] = placed ? joined(place[axis], fixed[axis]) : fixed[axis];
      frame_.origin_m[axis] = place[axis].value;
    }
    frame_.horizontal_sigma_m = std::max(place[0].sigma, place[1].sigma);
    frame_.vertical_sigma_m = place[2].sigma;
  }

  /// The origin by the positions, with the errors of scale and heading over the way from their middle to it.
  void place_by_positions(RobustMean (&place)[3]) {
    for (int axis = 0; axis < 3; ++axis) {
      Measurements offsets;
      Vec3 middle = Vec3::Zero();
      for (const MeasuredKeyframe& k : keyframes_) {
        const double sigma = axis < 2 ? k.horizontal_sigma_m : k.vertical_sigma_m;
        if (!(sigma > 0)) continue;
        const Vec3 from_origin = frame_.metres_per_unit * (frame_.level_from_strip * vector_of(k.centre));
        middle += from_origin;
        static_cast<void>(offsets.push_back({k.place_m[axis] - from_origin[axis], sigma}));
      }
      place[axis] = robust_mean(offsets);
      if (offsets.empty()) continue;
      middle /= static_cast<double>(offsets.size());
      const double scaled = frame_.scale_sigma * middle[axis];
      const double turned = axis < 2 ? frame_.heading_sigma_rad * middle[1 - axis] : 0;
      place[axis].sigma = std::sqrt(place[axis].sigma * place[axis].sigma + scaled * scaled + turned * turned);
    }
  }

  /// The origin by the fixes, with the errors of heading, tilt and scale over the way to it, and that of the map.
  void place_by_fixes(RobustMean (&place)[3]) {
    // Without a depth of its own, the distance on the map gives that of the ground point.
    const auto ground_of = [this](const MeasuredKeyframe& k) {
      return ground_in_strip(k, k.fix.depth > 0 ? k.fix.depth : k.fix.distance_m / frame_.metres_per_unit);
    };
    Vec3 middle = Vec3::Zero();
    double count = 0, map_sigma = 0;
    for (const MeasuredKeyframe& k : keyframes_) {
      if (!is_fixed(k)) continue;
      middle += ground_of(k);
      map_sigma = std::max(map_sigma, k.fix.map_sigma_m);
      ++count;
    }
    if (!(count > 0)) return;
    middle /= count;
    for (int axis = 0; axis < 3; ++axis) {
      Measurements offsets;
      for (const MeasuredKeyframe& k : keyframes_) {
        if (!is_fixed(k)) continue;
        const Vec3 from_middle = frame_.metres_per_unit * (frame_.level_from_strip * (ground_of(k) - middle));
        static_cast<void>(offsets.push_back({k.fix.ground_m[axis] - from_middle[axis], k.fix.ground_sigma_m[axis]}));
      }
      place[axis] = robust_mean(offsets);
      frame_.fixed_place_m[axis] = place[axis].value;
      frame_.fixed_sigma_m[axis] =
          axis < 2
              ? with_shared(place[axis].sigma, [axis](const MeasuredKeyframe& k) { return k.fix.ground_sigma_m[axis]; })
              : place[axis].sigma;
    }
    frame_.fixed_ground = middle;
    frame_.fixes = use_of(place[0].used < place[1].used ? place[0] : place[1]);
    const FixedPlace origin = navigation::place_by_fixes(frame_, Vec3::Zero());
    for (int axis = 0; axis < 3; ++axis) {
      const double common = axis < 2 ? map_sigma : 0;
      place[axis].value = origin.place_m[axis];
      place[axis].sigma = std::sqrt(origin.sigma_m[axis] * origin.sigma_m[axis] + common * common);
    }
  }

  [[nodiscard]] static bool places_contradict(const RobustMean (&a)[3], const RobustMean (&b)[3]) {
    for (int axis = 0; axis < 2; ++axis) {
      const double allowed = std::sqrt(a[axis].sigma * a[axis].sigma + b[axis].sigma * b[axis].sigma);
      if (std::fabs(a[axis].value - b[axis].value) > contradiction_sigmas * allowed) return true;
    }
    return false;
  }

  const MeasuredKeyframes& keyframes_;
  StripFrame frame_;
  double heading_ = 0;       ///< angle about up from the levelled strip to the level frame
  RobustMean by_positions_;  ///< metres per unit
  RobustMean way_;           ///< heading
  RobustMean by_fixes_;      ///< metres per unit
  RobustMean fix_heading_;
  std::uint32_t frozen_ = 0;  ///< positions, all of them where they stand still
  bool positions_contradict_ = false, fixes_contradict_ = false, attitudes_contradict_ = false, up_by_fixes_ = false;
};

}  // namespace

void add_thinned(const MeasuredKeyframe& keyframe, MeasuredKeyframes& keyframes) {
  if (keyframes.full()) {
    const std::size_t half = keyframes.size() / 2;
    for (std::size_t i = 0; i < half; ++i) keyframes[i] = keyframes[2 * i];
    static_cast<void>(keyframes.resize(half));
  }
  static_cast<void>(keyframes.push_back(keyframe));
}

FixedPlace place_by_fixes(const StripFrame& frame, const Vec3& point) {
  const Vec3 lever = frame.metres_per_unit * (frame.level_from_strip * (point - frame.fixed_ground));
  const double scaled = frame.scale_sigma * frame.scale_sigma;
  const double turned = frame.heading_sigma_rad * frame.heading_sigma_rad;
  const double tilted = frame.tilt_sigma_rad * frame.tilt_sigma_rad;
  const double across2 = lever.x() * lever.x() + lever.y() * lever.y(), up2 = lever.z() * lever.z();
  FixedPlace at;
  at.place_m = frame.fixed_place_m + lever;
  for (int axis = 0; axis < 3; ++axis) {
    const double by_lever = axis < 2 ? (scaled + turned) * across2 + tilted * up2 : scaled * up2 + tilted * across2;
    at.sigma_m[axis] = std::sqrt(frame.fixed_sigma_m[axis] * frame.fixed_sigma_m[axis] + by_lever);
  }
  return at;
}

void level_sigmas(const Mat3& covariance, const Mat3& cam_from_level, double& tilt_sigma_rad,
                  double& heading_sigma_rad) {
  const Vec3 up = cam_from_level.col(2);
  const double about_up = std::max(0.0, up.dot(covariance * up));
  heading_sigma_rad = std::sqrt(about_up);
  tilt_sigma_rad = std::sqrt(std::max(0.0, 0.5 * (covariance.trace() - about_up)));
}

StripFrame estimate_strip_frame(const MeasuredKeyframes& keyframes) {
  return Solver(keyframes).solve();
}

}  // namespace ilp::navigation
