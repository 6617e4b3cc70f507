#include "sim/world/ground_track.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "fsw/base/math.hpp"
#include "sim/world/parameter.hpp"

namespace ilp::world {
namespace {

constexpr std::array<std::string_view, 6> patterns = {"straight",  "lawn-mower",   "circle",
                                                      "rectangle", "figure-eight", "rosette"};

Vec2 turned(const Vec2& v, double angle) {
  const double c = det_cos(angle);
  const double s = det_sin(angle);
  return {c * v.x() - s * v.y(), s * v.x() + c * v.y()};
}

/// To the side (left for 1, right for -1) and back in the opposite direction, `spacing` beside the way before. Where
/// two quarters of a circle do not fit, the way swings out to the other side first: arcs by a, -(180 degrees + 2 a) and
/// a, with 4 r cos a - 2 r = spacing.
void turn_back(GroundTrack& track, double spacing, double radius, double side) {
  if (spacing >= 2 * radius) {
    track.arc(radius, side * pi / 2).line(spacing - 2 * radius).arc(radius, side * pi / 2);
    return;
  }
  const double cosine = (spacing + 2 * radius) / (4 * radius);
  const double out = det_atan2(std::sqrt(1 - cosine * cosine), cosine);
  track.arc(radius, -side * out).arc(radius, side * (pi + 2 * out)).arc(radius, -side * out);
}

/// A leg, a turn to the left, a leg and a turn to the right; then it begins again.
GroundTrack lawn_mower(const FlightParams& p) {
  GroundTrack track;
  for (const double side : {1.0, -1.0}) {
    track.line(p.pattern_length_m);
    turn_back(track, leg_spacing_m(p), p.pattern_turn_radius_m, side);
  }
  return track;
}

/// From the middle of a long side.
GroundTrack rectangle(const FlightParams& p) {
  const double r = p.pattern_turn_radius_m;
  const double length = p.pattern_length_m - 2 * r;
  const double width = p.pattern_width_m - 2 * r;
  GroundTrack track;
  track.line(0.5 * length).arc(r, pi / 2).line(width).arc(r, pi / 2).line(length);
  track.arc(r, pi / 2).line(width).arc(r, pi / 2).line(0.5 * length);
  return track;
}

/// Two circles and the tangents that cross between them, from the crossing.
GroundTrack figure_eight(const FlightParams& p) {
  const double r = 0.5 * p.pattern_width_m;
  const double to_centre = 0.5 * p.pattern_length_m - r;
  const double half = std::sqrt(to_centre * to_centre - r * r);
  const double round = pi + 2 * det_atan2(r, half);
  GroundTrack track;
  track.line(half).arc(r, round).line(2 * half).arc(r, -round).line(half);
  return track;
}

/// Straight through the start and around back through it, each time in another direction: the way turns by 180 degrees
/// and by the angle at which the start sees the arc's radius beside the end of the line, twice.
GroundTrack rosette(const FlightParams& p) {
  const double half = 0.5 * p.pattern_length_m;
  GroundTrack track;
  track.line(half).arc(p.pattern_turn_radius_m, pi + 2 * det_atan2(p.pattern_turn_radius_m, half)).line(half);
  return track;
}

}  // namespace

void GroundTrack::add(double length_m, double curvature) {
  if (!(length_m > 0)) return;
  end_.curvature = curvature;
  segments_.push_back({length_, length_m, end_});
  end_ = after(end_, length_m);
  length_ += length_m;
}

GroundTrack& GroundTrack::line(double length_m) {
  add(length_m, 0);
  return *this;
}

GroundTrack& GroundTrack::arc(double radius_m, double angle_rad) {
  add(radius_m * std::fabs(angle_rad), (angle_rad < 0 ? -1 : 1) / radius_m);
  return *this;
}

GroundTrack::Place GroundTrack::after(const Place& start, double way_m) {
  Place place = start;
  const Vec2 ahead(det_cos(start.heading_rad), det_sin(start.heading_rad));
  if (start.curvature == 0) {
    place.position += way_m * ahead;
    return place;
  }
  const double angle = start.curvature * way_m;
  const Vec2 left(-ahead.y(), ahead.x());
  place.position += (det_sin(angle) * ahead + (1 - det_cos(angle)) * left) / start.curvature;
  place.heading_rad += angle;
  return place;
}

GroundTrack::Place GroundTrack::at(double way_m) const {
  if (segments_.empty() || way_m < 0) return after({}, way_m);
  const double rounds = std::floor(way_m / length_);
  const double rest = way_m - rounds * length_;
  const auto next = std::upper_bound(segments_.begin(), segments_.end(), rest,
                                     [](double way, const Segment& segment) { return way < segment.begin_m; });
  const Segment& segment = *(next - 1);
  Place place = after(segment.start, rest - segment.begin_m);
  place.position = rounds * end_.position + turned(place.position, within_a_turn(rounds * end_.heading_rad));
  place.heading_rad += rounds * end_.heading_rad;
  return place;
}

double within_a_turn(double angle_rad) {
  return angle_rad - 2 * pi * std::floor(angle_rad / (2 * pi));
}

std::string pattern_names() {
  std::string names;
  for (const std::string_view name : patterns) {
    names += (names.empty() ? "" : name == patterns.back() ? " or " : ", ") + std::string(name);
  }
  return names;
}

bool is_pattern(const std::string& name) {
  return std::find(patterns.begin(), patterns.end(), name) != patterns.end();
}

double leg_spacing_m(const FlightParams& p) {
  return (1 - p.side_overlap) * p.altitude_m * p.camera.height / p.camera.fy;
}

GroundTrack ground_track(const FlightParams& p) {
  if (p.pattern == "lawn-mower") return lawn_mower(p);
  if (p.pattern == "circle") return GroundTrack().arc(0.5 * p.pattern_length_m, 2 * pi);
  if (p.pattern == "rectangle") return rectangle(p);
  if (p.pattern == "figure-eight") return figure_eight(p);
  if (p.pattern == "rosette") return rosette(p);
  return {};
}

std::string fault_of_pattern(const FlightParams& p) {
  const double shorter = std::min(p.pattern_length_m, p.pattern_width_m);
  if (p.pattern == "rectangle" && 2 * p.pattern_turn_radius_m > shorter) {
    return "pattern_turn_radius_m = " + number_text(p.pattern_turn_radius_m) + ": expected at most " +
           number_text(0.5 * shorter) + ", so that the corners fit into the rectangle";
  }
  if (p.pattern == "figure-eight" && !(p.pattern_length_m > 2 * p.pattern_width_m)) {
    return "pattern_length_m = " + number_text(p.pattern_length_m) + ": expected more than " +
           number_text(2 * p.pattern_width_m) + ", twice the width of the figure-eight";
  }
  return {};
}

}  // namespace ilp::world
