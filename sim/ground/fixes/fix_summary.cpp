#include "sim/ground/fixes/fix_summary.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/shared/local_plane.hpp"
#include "fsw/shared/measured_keyframe.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"

namespace ilp::fixes {
namespace {

using navigation::MeasuredKeyframe;
using navigation::MeasuredKeyframes;
using navigation::StripFrame;

/// A strip's keyframes with poses, on the plane of its map.
struct Measured {
  const intake::Keyframe* keyframe = nullptr;
  MeasuredKeyframe by_vehicle;      ///< without its fix
  navigation::FixMeasurement seen;  ///< the fix, also one that does not count; empty without one on this map
  bool accepted = false;
};

/// The same without what the vehicle measured.
MeasuredKeyframe fix_alone(const Measured& measured) {
  MeasuredKeyframe out;
  const MeasuredKeyframe& from = measured.by_vehicle;
  out.keyframe_id = from.keyframe_id;
  out.time_ns = from.time_ns;
  std::copy_n(from.centre, 3, out.centre);
  std::copy_n(from.q_cam_from_strip, 4, out.q_cam_from_strip);
  out.fix = measured.seen;
  return out;
}

/// The fix that says which map: the first one that counts, else the newest record.
const FixRecord* leading_fix(const intake::Flight& flight, const intake::Strip& strip) {
  const FixRecord* newest = nullptr;
  for (const std::int64_t id : strip.keyframes) {
    const auto& fix = flight.keyframes.at(id).fix;
    if (!fix) continue;
    newest = &*fix;
    if (fix->state == FixState::accepted) return newest;
  }
  return newest;
}

std::vector<Measured> measure(const intake::Flight& flight, const intake::Strip& strip, const FixRecord& lead) {
  const BodyPlace origin = map_origin_of(lead);
  std::vector<Measured> all;
  for (const std::int64_t id : strip.keyframes) {
    const intake::Keyframe& keyframe = flight.keyframes.at(id);
    if (!keyframe.posed()) continue;
    Measured one;
    one.keyframe = &keyframe;
    const NavigationRecord navigation = keyframe.navigation.value_or(NavigationRecord{});
    one.by_vehicle = measured_keyframe(*keyframe.pose, navigation, lead.body, origin);
    if (has_place(navigation, lead.body))
      plane_from_place(lead.body, origin, place_of(navigation), one.by_vehicle.place_m);
    const auto& fix = keyframe.fix;
    if (fix && fix->verdict == MapVerdict::fixed && fix->map_id == lead.map_id) {
      FixRecord counted = *fix;
      counted.state = FixState::accepted;
      one.seen = fix_measurement(counted, origin);
      one.accepted = fix->state == FixState::accepted && one.seen.ground_sigma_m[0] > 0;
    }
    all.push_back(one);
  }
  return all;
}

/// The ground point in the strip's world; nothing where its distance is not known there.
std::optional<Vec3> ground_in_strip(const Measured& measured, const StripFrame& frame) {
  double depth = measured.seen.depth;
  if (!(depth > 0) && frame.scale_sigma > 0) depth = measured.seen.distance_m / frame.metres_per_unit;
  if (!(depth > 0)) return std::nullopt;
  const Vec3 axis = rotation_from_quaternion(measured.by_vehicle.q_cam_from_strip).row(2);
  return vector_of(measured.by_vehicle.centre) + depth * axis;
}

std::optional<double> distance(const Measured& measured, const std::optional<Vec3>& place) {
  if (!place || !(measured.seen.ground_sigma_m[0] > 0)) return std::nullopt;
  return (place->head<2>() - vector_of(measured.seen.ground_m).head<2>()).norm();
}

bool is_placed_by_fixes(const StripFrame& frame) {
  return frame.fixed_sigma_m[0] > 0 && frame.scale_sigma > 0 && frame.tilt_sigma_rad > 0 && frame.heading_sigma_rad > 0;
}

bool is_placed_by_vehicle(const StripFrame& frame) {
  return frame.horizontal_sigma_m > 0 && frame.scale_sigma > 0 && frame.tilt_sigma_rad > 0 &&
         frame.heading_sigma_rad > 0;
}

Vec3 place_by_vehicle(const StripFrame& frame, const Vec3& point) {
  return frame.origin_m + frame.metres_per_unit * (frame.level_from_strip * point);
}

struct Frames {
  StripFrame vehicle, first, all;
};

Frames frames_of(const std::vector<Measured>& measured) {
  MeasuredKeyframes vehicle, first, all;
  for (const Measured& one : measured) {
    navigation::add_thinned(one.by_vehicle, vehicle);
    if (!one.accepted) continue;
    if (first.size() < first_fixes) (void)first.push_back(fix_alone(one));
    navigation::add_thinned(fix_alone(one), all);
  }
  return {navigation::estimate_strip_frame(vehicle), navigation::estimate_strip_frame(first),
          navigation::estimate_strip_frame(all)};
}

void compare(const Measured& measured, const Frames& frames, KeyframeFix& out) {
  if (is_placed_by_vehicle(frames.vehicle)) {
    if (const auto ground = ground_in_strip(measured, frames.vehicle))
      out.off_by_vehicle_m = distance(measured, place_by_vehicle(frames.vehicle, *ground));
  }
  if (is_placed_by_fixes(frames.first)) {
    if (const auto ground = ground_in_strip(measured, frames.first)) {
      const navigation::FixedPlace at = navigation::place_by_fixes(frames.first, *ground);
      out.off_by_first_m = distance(measured, at.place_m);
      out.off_by_first_sigma_m = std::hypot(at.sigma_m[0], at.sigma_m[1]);
    }
  }
  if (!is_placed_by_fixes(frames.all)) return;
  if (const auto ground = ground_in_strip(measured, frames.all))
    out.off_by_all_m = distance(measured, navigation::place_by_fixes(frames.all, *ground).place_m);
}

std::vector<Vec3> track_by(const StripFrame& frame, const std::vector<Measured>& measured) {
  std::vector<Vec3> track;
  if (!is_placed_by_fixes(frame)) return track;
  for (const Measured& one : measured)
    track.push_back(navigation::place_by_fixes(frame, vector_of(one.by_vehicle.centre)).place_m);
  return track;
}

std::vector<Vec3> track_by_vehicle(const StripFrame& frame, const std::vector<Measured>& measured) {
  std::vector<Vec3> track;
  if (!is_placed_by_vehicle(frame)) return track;
  for (const Measured& one : measured) track.push_back(place_by_vehicle(frame, vector_of(one.by_vehicle.centre)));
  return track;
}

/// Of the fixes that count; by the first ones, of those after them.
void sum_up(StripFixes& strip) {
  std::vector<double> vehicle, first, all;
  std::size_t accepted = 0;
  for (const KeyframeFix& one : strip.keyframes) {
    strip.registered += was_registered(one.fix) ? 1U : 0U;
    strip.fixed += one.fix.verdict == MapVerdict::fixed ? 1U : 0U;
    if (one.fix.state != FixState::accepted) continue;
    ++accepted;
    if (one.off_by_vehicle_m) vehicle.push_back(*one.off_by_vehicle_m);
    if (one.off_by_first_m && accepted > first_fixes) first.push_back(*one.off_by_first_m);
    if (one.off_by_all_m) all.push_back(*one.off_by_all_m);
  }
  strip.accepted = accepted;
  strip.off_by_vehicle = host::summarise(vehicle);
  strip.off_by_first = host::summarise(first);
  strip.off_by_all = host::summarise(all);
}

StripFixes strip_fixes(const intake::Flight& flight, const intake::Strip& strip, const FixRecord& lead) {
  StripFixes out;
  out.strip_id = strip.id;
  out.map_id = lead.map_id;
  out.map_sigma_m = lead.map_sigma_m;
  const std::vector<Measured> measured = measure(flight, strip, lead);
  const Frames frames = frames_of(measured);
  std::map<std::int64_t, const Measured*> by_id;
  for (const Measured& one : measured) by_id[one.keyframe->id] = &one;
  for (const std::int64_t id : strip.keyframes) {
    const auto& fix = flight.keyframes.at(id).fix;
    if (!fix) continue;
    KeyframeFix& one = out.keyframes.emplace_back();
    one.fix = *fix;
    if (const auto found = by_id.find(id); found != by_id.end()) compare(*found->second, frames, one);
  }
  out.track_by_vehicle = track_by_vehicle(frames.vehicle, measured);
  out.track_by_all = track_by(frames.all, measured);
  sum_up(out);
  if (out.accepted > first_fixes) out.track_by_first = track_by(frames.first, measured);
  return out;
}

}  // namespace

ErrorEllipse ellipse_of(const FixRecord& fix) {
  const double(&c)[3] = fix.ground_covariance;
  const double mean = 0.5 * (c[0] + c[2]), half = 0.5 * (c[0] - c[2]);
  const double radius = std::hypot(half, c[1]);
  return {std::sqrt(std::max(0.0, mean + radius)), std::sqrt(std::max(0.0, mean - radius)),
          0.5 * std::atan2(c[1], half)};
}

bool was_registered(const FixRecord& fix) {
  return fix.pixel_m > 0;
}

FixSummary fixes_of(const intake::Flight& flight) {
  FixSummary summary;
  for (const auto& [id, strip] : flight.strips) {
    const FixRecord* const lead = leading_fix(flight, strip);
    if (lead == nullptr) continue;
    const StripFixes& fixes = summary.strips.emplace_back(strip_fixes(flight, strip, *lead));
    summary.keyframes += fixes.keyframes.size();
    summary.registered += fixes.registered;
    summary.fixed += fixes.fixed;
    summary.accepted += fixes.accepted;
    for (const KeyframeFix& one : fixes.keyframes) {
      ++summary.verdicts[one.fix.verdict];
      if (one.fix.verdict == MapVerdict::fixed) ++summary.senses[one.fix.sense];
    }
  }
  return summary;
}

}  // namespace ilp::fixes
