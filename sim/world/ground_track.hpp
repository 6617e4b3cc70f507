// Ways over level ground made of straight lines and arcs: what a flight's pattern looks like from above.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "fsw/vision/geometry/types.hpp"
#include "sim/world/flight_params.hpp"

namespace ilp::world {

/// Begins at the origin in the direction of x. Headings grow without bound, counterclockwise from x.
class GroundTrack {
 public:
  struct Place {
    Vec2 position = Vec2::Zero();  ///< m
    double heading_rad = 0;
    double curvature = 0;  ///< 1 / m, positive to the left
  };

  GroundTrack& line(double length_m);
  /// A turn to the left, or to the right by a negative angle. The radius is positive.
  GroundTrack& arc(double radius_m, double angle_rad);

  /// Length of all pieces, m.
  [[nodiscard]] double length() const { return length_; }
  /// Where the way leads after this many metres. Beyond its end it begins again from there, in the direction in which
  /// it ended; before its start, and where there are no pieces, it is straight. A way that is flown more than once must
  /// return to the origin or end in the direction in which it began.
  [[nodiscard]] Place at(double way_m) const;

 private:
  struct Segment {
    double begin_m = 0, length_m = 0;
    Place start;
  };
  void add(double length_m, double curvature);
  [[nodiscard]] static Place after(const Place& start, double way_m);

  std::vector<Segment> segments_;
  double length_ = 0;
  Place end_;
};

/// The same direction from 0 to 2 pi.
[[nodiscard]] double within_a_turn(double angle_rad);

/// The names of the patterns, for messages: straight, lawn-mower and so on.
[[nodiscard]] std::string pattern_names();
[[nodiscard]] bool is_pattern(const std::string& name);

/// Distance of a lawn-mower's legs, m: the width of level ground that the image shows across the drift, less the side
/// overlap.
[[nodiscard]] double leg_spacing_m(const FlightParams& flight);

/// The pattern of a flight with valid parameters (flight_params.hpp).
[[nodiscard]] GroundTrack ground_track(const FlightParams& flight);

/// What is wrong with the lengths of the pattern and was expected instead; empty for a pattern that can be flown.
[[nodiscard]] std::string fault_of_pattern(const FlightParams& flight);

}  // namespace ilp::world
