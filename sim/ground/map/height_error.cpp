#include "sim/ground/map/height_error.hpp"

#include <algorithm>
#include <cmath>

#include "sim/ground/intake/result_cache.hpp"

namespace ilp::map {
namespace {

/// Relative, of a strip's unit by the height of its first keyframe alone: of the height, of the median ground below,
/// and of what is up.
constexpr double one_height_sigma = 0.02;

}  // namespace

double HeightErrorParts::whole() const {
  return std::sqrt(matching * matching + poses * poses + scale * scale + tilt * tilt + place * place);
}

HeightErrorParts HeightErrors::parts(const Vec3& point, std::uint16_t source, double matching) const {
  HeightErrorParts parts;
  if (std::isfinite(matching)) parts.matching = matching;
  if (source > 0 && source <= keyframes.size()) {
    const OfKeyframe& keyframe = keyframes[source - 1U];
    const double by_depth = keyframe.depth_share * (keyframe.centre_z - point.z());
    parts.poses = std::sqrt(by_depth * by_depth + keyframe.centre_sigma_z * keyframe.centre_sigma_z);
  }
  const double x = point.x() - middle.x(), y = point.y() - middle.y();
  parts.scale = scale_sigma * std::fabs(point.z() - middle.z());
  parts.tilt = tilt_sigma_rad * std::sqrt(x * x + y * y);
  parts.place = place_sigma;
  return parts;
}

std::uint64_t HeightErrors::digest() const {
  intake::InputDigest digest("errors of heights 2");
  for (const OfKeyframe& k : keyframes)
    digest.add_value(k.centre_z).add_value(k.centre_sigma_z).add_value(k.depth_share);
  for (const double value : {middle.x(), middle.y(), middle.z(), scale_sigma, tilt_sigma_rad, place_sigma})
    digest.add_value(value);
  return digest.value();
}

HeightErrors height_errors_of(const intake::Flight& flight, const intake::Strip& strip) {
  HeightErrors errors;
  double count = 0;
  // A record may say anything.
  const auto stated = [](double sigma) { return std::isfinite(sigma) && sigma > 0 ? sigma : 0; };
  for (const std::int64_t id : strip.keyframes) {
    const intake::Keyframe& keyframe = flight.keyframes.at(id);
    HeightErrors::OfKeyframe& of = errors.keyframes.emplace_back();
    if (!keyframe.posed()) continue;
    const double(&centre)[3] = keyframe.pose->centre;
    errors.middle += Vec3(centre[0], centre[1], centre[2]);
    ++count;
    of.centre_z = centre[2];
    of.centre_sigma_z = stated(keyframe.pose->sigma[2]);
    if (keyframe.depth) of.depth_share = stated(keyframe.depth->pose_sigma);
  }
  if (count > 0) errors.middle /= count;
  if (strip.control) {
    errors.scale_sigma = stated(strip.control->scale_sigma);
    errors.tilt_sigma_rad = stated(strip.control->tilt_sigma_rad);
    errors.place_sigma = stated(strip.control->height_sigma_m);
    return errors;
  }
  if (!strip.frame) {
    const bool by_one_height = std::any_of(strip.keyframes.begin(), strip.keyframes.end(), [&](std::int64_t id) {
      const intake::Keyframe& keyframe = flight.keyframes.at(id);
      return keyframe.posed() && keyframe.pose->scale_source == ScaleSource::altimeter;
    });
    if (by_one_height) errors.scale_sigma = one_height_sigma;
    return errors;
  }
  errors.scale_sigma = stated(strip.frame->scale_sigma);
  errors.tilt_sigma_rad = stated(strip.frame->tilt_sigma_rad);
  if (errors.scale_sigma > 0) errors.place_sigma = stated(strip.frame->vertical_sigma_m);
  return errors;
}

}  // namespace ilp::map
