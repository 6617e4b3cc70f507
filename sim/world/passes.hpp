// Motion of a flight in several passes: each repeats the pattern, possibly rotated, at another height or in other
// light, after a pause.
#pragma once

#include <cstdint>
#include <vector>

#include "sim/world/flight_params.hpp"
#include "sim/world/ground_track.hpp"

namespace ilp::world {

/// A function of time at an instant: value and derivatives.
struct Course {
  double value = 0, rate = 0, acceleration = 0;
};

class Passes {
 public:
  /// Motion of the vehicle at an instant. The axes are along the drift and to its left.
  struct Motion {
    /// Position from the start, m. The accelerations do not include the transition from pass to pass, so that it does
    /// not make the gondola swing.
    Course along, across;
    Course yaw;     ///< rad, relative to the drift's heading
    Course height;  ///< factor on the altitude
  };

  /// `params` must be valid (flight_params.hpp), with unused motions set to 0.
  explicit Passes(const FlightParams& params);

  [[nodiscard]] Motion at(double time_s) const;
  /// Index of the pass, from 0. It changes in the middle of a pause.
  [[nodiscard]] int pass_at(double time_s) const;

 private:
  struct Clock {
    int pass = 0;
    double time_s = 0;  ///< since the pass began
  };
  [[nodiscard]] Clock clock_at(double time_s) const;
  [[nodiscard]] Motion in_pass(int pass, double time_s) const;

  FlightParams params_;
  GroundTrack track_;
  double flown_s_ = 0;  ///< duration of a pass without its pause
  Vec2 middle_ = Vec2::Zero();
};

/// Time in s of the frame with this index, from 0. Frames in the gap count too.
[[nodiscard]] double time_of_frame_s(const FlightParams& flight, int frame);
/// Number of frames of a pass; the last pass may have fewer.
[[nodiscard]] int frames_of_a_pass(const FlightParams& flight);

}  // namespace ilp::world
