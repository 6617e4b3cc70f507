#include "fsw/vision/navigation/strip_frame.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "fsw/base/math.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"
#include "fsw/vision/navigation/position_level.hpp"

namespace ilp::navigation {
namespace {

constexpr std::uint32_t least_measurements = 3;
// Two kinds of measurement contradict each other beyond this many sigmas of their difference and this share.
constexpr double contradiction_sigmas = 5;
constexpr double contradiction_share = 0.02;

Vec3 vector_of(const double (&v)[3]) {
  return {v[0], v[1], v[2]};
}

Use use_of(const RobustMean& mean) {
  return {mean.used, mean.refused};
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
    find_up();
    if (!(frame_.tilt_sigma_rad > 0)) level_by_track();
    find_heading_by_attitudes();
    compare_positions();
    find_scale();
    find_place();
    const bool any = frame_.scale_sigma > 0 || frame_.tilt_sigma_rad > 0 || frame_.heading_sigma_rad > 0;
    if (any && frame_.verdict == StripFrameVerdict::nothing_measured) frame_.verdict = StripFrameVerdict::ok;
    return frame_;
  }

 private:
  [[nodiscard]] static Mat3 level_from_strip_of(const MeasuredKeyframe& k) {
    return rotation_from_quaternion(k.q_cam_from_level).transpose() * rotation_from_quaternion(k.q_cam_from_strip);
  }

  /// The tilts that the attitudes say, about a first guess of what is up.
  void find_up() {
    Vec3 sum = Vec3::Zero();
    for (const MeasuredKeyframe& k : keyframes_) {
      if (k.tilt_sigma_rad > 0) sum += level_from_strip_of(k).row(2).transpose();
    }
    if (!(sum.norm() > 0)) return;
    Vec3 up = sum.normalized();
    RobustMean tilts[2];
    // The second turn starts from a guess without outliers.
    for (int turn = 0; turn < 2; ++turn) {
      const Mat3 guess = shortest_rotation(up, Vec3(0, 0, 1));
      for (int axis = 0; axis < 2; ++axis) {
        Measurements values;
        for (const MeasuredKeyframe& k : keyframes_) {
          if (!(k.tilt_sigma_rad > 0)) continue;
          const Vec3 seen = guess * level_from_strip_of(k).row(2).transpose();
          static_cast<void>(values.push_back({seen[axis], k.tilt_sigma_rad}));
        }
        tilts[axis] = robust_mean(values);
      }
      const Vec3 mean(tilts[0].value, tilts[1].value, 0);
      up = (guess.transpose() * (mean + Vec3(0, 0, std::sqrt(std::max(0.0, 1 - mean.squaredNorm()))))).normalized();
    }
    frame_.attitudes = use_of(tilts[0].used < tilts[1].used ? tilts[0] : tilts[1]);
    if (frame_.attitudes.used < least_measurements) return;
    frame_.level_from_strip = shortest_rotation(up, Vec3(0, 0, 1));
    frame_.tilt_sigma_rad = std::sqrt(0.5 * (tilts[0].sigma * tilts[0].sigma + tilts[1].sigma * tilts[1].sigma));
  }

  /// Where no attitude says what is up, the positions do, as far as their track turns.
  void level_by_track() {
    const PositionLevel level = level_by_positions(keyframes_);
    if (!level.known) return;
    frame_.level_from_strip = level.level_from_strip;
    frame_.tilt_sigma_rad = level.tilt_sigma_rad;
  }

  void find_heading_by_attitudes() {
    if (!(frame_.tilt_sigma_rad > 0)) return;
    Measurements headings;
    double reference = 0;
    for (const MeasuredKeyframe& k : keyframes_) {
      if (!(k.tilt_sigma_rad > 0) || !(k.heading_sigma_rad > 0)) continue;
      const Mat3 turn = level_from_strip_of(k) * frame_.level_from_strip.transpose();
      const double angle = det_atan2(turn(1, 0) - turn(0, 1), turn(0, 0) + turn(1, 1));
      if (headings.empty()) reference = angle;
      static_cast<void>(headings.push_back({near_angle(angle, reference), k.heading_sigma_rad}));
    }
    const RobustMean heading = robust_mean(headings);
    if (heading.used < least_measurements) return;
    heading_ = heading.value;
    frame_.heading_sigma_rad = heading.sigma;
  }

  /// Length and direction of the ways between positions half the strip apart, against those of the images.
  void compare_positions() {
    FixedVector<const MeasuredKeyframe*, max_values> placed;
    for (const MeasuredKeyframe& k : keyframes_) {
      if (k.horizontal_sigma_m > 0) static_cast<void>(placed.push_back(&k));
    }
    const std::size_t half = placed.size() / 2;
    if (half >= 2) measure_ways(placed, half);
    turn_to_north();
  }

  void measure_ways(const FixedVector<const MeasuredKeyframe*, max_values>& placed, std::size_t half) {
    Measurements lengths, directions;
    double reference = 0;
    for (std::size_t i = 0; i + half < placed.size(); ++i) {
      const MeasuredKeyframe &a = *placed[i], &b = *placed[i + half];
      const Vec3 seen = frame_.level_from_strip * (vector_of(b.centre) - vector_of(a.centre));
      const Vec3 told = vector_of(b.place_m) - vector_of(a.place_m);
      const double units = std::sqrt(seen.x() * seen.x() + seen.y() * seen.y());
      const double metres = std::sqrt(told.x() * told.x() + told.y() * told.y());
      const double sigma =
          std::sqrt(a.horizontal_sigma_m * a.horizontal_sigma_m + b.horizontal_sigma_m * b.horizontal_sigma_m);
      // A way that is no longer than its error says nothing, and a hover none at all.
      if (!(metres > contradiction_sigmas * sigma) || !(units > 0)) continue;
      const double angle = det_atan2(told.y(), told.x()) - det_atan2(seen.y(), seen.x());
      if (directions.empty()) reference = angle;
      static_cast<void>(lengths.push_back({metres / units, sigma / units}));
      static_cast<void>(directions.push_back({near_angle(angle, reference), sigma / metres}));
    }
    by_positions_ = robust_mean(lengths);
    way_ = robust_mean(directions);
    if (by_positions_.used < least_measurements) {
      by_positions_ = {};
      way_ = {};
    }
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
    if (frame_.heading_sigma_rad > 0) frame_.level_from_strip = rotation_about_up(heading_) * frame_.level_from_strip;
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
    const RobustMean mean = robust_mean(ratios);
    frame_.heights = use_of(mean);
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
    const RobustMean kinds[] = {scale_by_heights(), by_positions_, scale_by_velocities()};
    Use* const uses[] = {&frame_.heights, &frame_.positions, &frame_.velocities};
    frame_.positions = use_of(by_positions_);
    std::array<bool, 3> agrees{};
    std::uint32_t present = 0, agreeing = 0;
    for (std::size_t i = 0; i < 3; ++i) present += kinds[i].used >= least_measurements ? 1 : 0;
    for (std::size_t i = 0; i < 3; ++i) {
      if (kinds[i].used < least_measurements) continue;
      agrees[i] = present == 1;
      for (std::size_t k = 0; k < 3; ++k) {
        if (k == i || kinds[k].used < least_measurements) continue;
        agrees[i] = agrees[i] || !contradict(kinds[i], kinds[k]);
      }
      agreeing += agrees[i] ? 1 : 0;
    }
    if (agreeing < present) frame_.verdict = StripFrameVerdict::scales_contradict;
    double weights = 0, sum = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      if (!agrees[i]) {
        positions_contradict_ = positions_contradict_ || (i == 1 && kinds[i].used >= least_measurements);
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
    // Without its scale and its heading a strip has no place, and none by positions that contradict.
    if (!(frame_.scale_sigma > 0) || !(frame_.heading_sigma_rad > 0) || positions_contradict_) return;
    RobustMean place[3];
    for (int axis = 0; axis < 3; ++axis) {
      Measurements offsets;
      for (const MeasuredKeyframe& k : keyframes_) {
        const double sigma = axis < 2 ? k.horizontal_sigma_m : k.vertical_sigma_m;
        if (!(sigma > 0)) continue;
        const Vec3 from_origin = frame_.metres_per_unit * (frame_.level_from_strip * vector_of(k.centre));
        static_cast<void>(offsets.push_back({k.place_m[axis] - from_origin[axis], sigma}));
      }
      place[axis] = robust_mean(offsets);
    }
    if (place[0].used == 0 || place[1].used == 0) return;
    for (int axis = 0; axis < 3; ++axis) frame_.origin_m[axis] = place[axis].value;
    frame_.horizontal_sigma_m = std::max(place[0].sigma, place[1].sigma);
    frame_.vertical_sigma_m = place[2].sigma;
    frame_.positions = use_of(place[0].used < place[1].used ? place[0] : place[1]);
  }

  const MeasuredKeyframes& keyframes_;
  StripFrame frame_;
  double heading_ = 0;       ///< angle about up from the levelled strip to the level frame
  RobustMean by_positions_;  ///< metres per unit
  RobustMean way_;           ///< heading
  bool positions_contradict_ = false;
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

StripFrame estimate_strip_frame(const MeasuredKeyframes& keyframes) {
  return Solver(keyframes).solve();
}

}  // namespace ilp::navigation
