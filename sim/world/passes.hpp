// The passes of a flight: the same pattern again, turned, at another height or in other light, with a pause between.
#pragma once

#include <cstdint>
#include <vector>

#include "sim/world/flight_params.hpp"
#include "sim/world/ground_track.hpp"

namespace ilp::world {

/// A number that changes with time.
struct Course {
  double value = 0, rate = 0, acceleration = 0;
};

class Passes {
 public:
  /// What the passes make of the flight at an instant. The axes are along the drift and to the left of it.
  struct Motion {
    /// m from the start. Their accelerations leave out how the vehicle comes from one pass to the next: what hangs
    /// below it is not shaken by that.
    Course along, across;
    Course yaw;     ///< rad, besides the drift's heading
    Course height;  ///< factor on the altitude
  };

  /// Parameters as they are flown (flight_params.hpp), valid.
  explicit Passes(const FlightParams& params);

  [[nodiscard]] Motion at(double time_s) const;
  /// Counted from 0; it changes in the middle of a pause.
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
  double flown_s_ = 0;  ///< of one pass; the pause follows
  Vec2 middle_ = Vec2::Zero();
};

/// Instants at which the camera may take a frame, s; one for each frame, gaps not left out.
[[nodiscard]] double time_of_frame_s(const FlightParams& flight, int frame);
/// Frames of each pass but perhaps the last.
[[nodiscard]] int frames_of_a_pass(const FlightParams& flight);

}  // namespace ilp::world
