// Horizontal tracks of straight lines and arcs, for the patterns of flights.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "fsw/vision/geometry/types.hpp"
#include "sim/world/flight_params.hpp"

namespace ilp::world {

/// A track that begins at the origin in the direction of x. Headings are counterclockwise from x and not limited to one
/// turn.
class GroundTrack {
 public:
  struct Place {
    Vec2 position = Vec2::Zero();  ///< m
    double heading_rad = 0;
    double curvature = 0;  ///< 1 / m, positive to the left
  };

  /// Appends a straight line.
  GroundTrack& line(double length_m);
  /// Appends a turn to the left, or to the right for a negative angle. The radius must be positive.
  GroundTrack& arc(double radius_m, double angle_rad);

  /// Length of all segments, m.
  [[nodiscard]] double length() const { return length_; }
  /// Position after `way_m` metres along the track. After its end the track repeats from the end point in the final
  /// direction. Before its start, and without segments, it is a straight line. A track that is repeated must end at the
  /// origin or in the direction in which it began.
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

/// The equivalent angle in [0, 2 pi).
[[nodiscard]] double within_a_turn(double angle_rad);

/// The names of the patterns as text for messages.
[[nodiscard]] std::string pattern_names();
[[nodiscard]] bool is_pattern(const std::string& name);

/// Distance between the legs of a lawn-mower, m: the width of level ground in the image across the drift, times 1 -
/// side_overlap.
[[nodiscard]] double leg_spacing_m(const FlightParams& flight);

/// The pattern of a flight with valid parameters (flight_params.hpp).
[[nodiscard]] GroundTrack ground_track(const FlightParams& flight);

/// What is wrong with the lengths of the pattern, and what was expected; empty for a valid pattern.
[[nodiscard]] std::string fault_of_pattern(const FlightParams& flight);

}  // namespace ilp::world
