#include "sim/ground/map/keyframe_quick_look.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "sim/host/digest.hpp"
#include "sim/host/picture.hpp"
#include "sim/host/statistics.hpp"

namespace ilp::map {
namespace {

using nlohmann::json;

// A handful of wild points must not blow up the map: beyond the central 99.6 % only a small margin is kept, and
// nothing beyond what a very slanted view would show.
void robust_interval(std::vector<double> values, double longest, double& low, double& high) {
  const double q_low = host::percentile(values, 0.002), q_high = host::percentile(values, 0.998),
               middle = host::percentile(values, 0.5);
  const double margin = 0.03 * (q_high - q_low);
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  low = std::max({*least, q_low - margin, middle - longest});
  high = std::min({*most, q_high + margin, middle + longest});
}

MapBounds robust_bounds(const SurfaceMesh& surface, double longest) {
  std::vector<double> x, y;
  for (std::size_t i = 0; i < surface.vertices.size(); i += 7) {
    x.push_back(surface.vertices[i].x);
    y.push_back(surface.vertices[i].y);
  }
  MapBounds bounds;
  robust_interval(std::move(x), longest, bounds.x_low, bounds.x_high);
  robust_interval(std::move(y), longest, bounds.y_low, bounds.y_high);
  return bounds;
}

void measure(const intake::Keyframe& keyframe, const intake::KeyframeRasters& rasters, PixelRays& rays,
             KeyframeQuickLook& quick_look) {
  std::vector<double> depths;
  for (const float d : rasters.inverse_depth.samples) {
    if (d > 0) depths.push_back(1.0 / d);
  }
  quick_look.depth_pixels = depths.size();
  if (depths.empty()) return;
  quick_look.median_depth = host::median(std::move(depths));
  if (!has_surface(keyframe)) return;
  const SurfaceMesh surface = keyframe_surface(keyframe, rasters, {}, rays);
  if (surface.vertices.empty()) return;
  quick_look.ground_step = quick_look.median_depth / keyframe.camera.fx;
  constexpr double slanted = 8;
  quick_look.bounds = robust_bounds(
      surface, slanted * quick_look.ground_step * std::max(keyframe.camera.width, keyframe.camera.height));
}

void draw(const intake::KeyframeRasters& rasters, std::int32_t width, KeyframeQuickLook& quick_look) {
  if (!rasters.image.empty()) quick_look.image = host::png_bytes(host::shrink(rasters.image, width, host::mean_grey));
  if (!rasters.mask.empty()) quick_look.mask = host::png_bytes(host::shrink(rasters.mask, width, host::mean_grey));
  if (rasters.inverse_depth.empty()) return;
  const host::Raster<float> depth = host::shrink(rasters.inverse_depth, width, host::mean_depth);
  const host::ValueRange range = host::display_range(depth);
  quick_look.depth = host::png_bytes(host::colour_mapped(depth, range));
  quick_look.nearest = range.low;
  quick_look.farthest = range.high;
}

template <typename T>
void add(const T& value, std::uint64_t& state) {
  state = host::digest({reinterpret_cast<const char*>(&value), sizeof(value)}, state);
}

void add(const std::vector<std::uint8_t>& bytes, std::uint64_t& state) {
  add(bytes.size(), state);
  state = host::digest({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, state);
}

}  // namespace

std::int32_t quick_look_width_px(std::size_t keyframes) {
  // Steps, so that one keyframe more does not change all pictures.
  return keyframes <= 140 ? 240 : keyframes <= 560 ? 120 : keyframes <= 2240 ? 60 : 30;
}

KeyframeQuickLook quick_look_at(const intake::Keyframe& keyframe, const intake::KeyframeRasters& rasters,
                                std::int32_t width_px, PixelRays& rays) {
  KeyframeQuickLook quick_look;
  quick_look.digest = keyframe_digest(keyframe);
  measure(keyframe, rasters, rays, quick_look);
  draw(rasters, width_px, quick_look);
  return quick_look;
}

std::uint64_t keyframe_digest(const intake::Keyframe& keyframe) {
  std::uint64_t state = host::digest("keyframe 1");
  add(keyframe.id, state);
  for (const intake::CodedFile& file : keyframe.product_files) add(file.bytes(), state);
  add(keyframe.coded_mask.bytes(), state);
  add(keyframe.mask_width, state);
  add(keyframe.mask_height, state);
  const CameraModel& c = keyframe.camera;
  const CameraNumbers numbers = camera_numbers(c);
  for (const double value : numbers.span()) add(value, state);
  add(c.width, state);
  add(c.height, state);
  add(keyframe.depth_scale, state);
  add(keyframe.posed(), state);
  if (keyframe.posed()) {
    for (const double value : keyframe.pose->q_cam_from_world) add(value, state);
    for (const double value : keyframe.pose->centre) add(value, state);
  }
  return state;
}

std::vector<std::uint8_t> bytes_of(const KeyframeQuickLook& quick_look) {
  const MapBounds& b = quick_look.bounds;
  const json stored = {{"digest", quick_look.digest},
                       {"faults", quick_look.faults},
                       {"depth_pixels", quick_look.depth_pixels},
                       {"median_depth", quick_look.median_depth},
                       {"ground_step", quick_look.ground_step},
                       {"bounds", {b.x_low, b.x_high, b.y_low, b.y_high}},
                       {"image", json::binary(quick_look.image)},
                       {"mask", json::binary(quick_look.mask)},
                       {"depth", json::binary(quick_look.depth)},
                       {"range", {quick_look.nearest, quick_look.farthest}}};
  return json::to_cbor(stored);
}

std::optional<KeyframeQuickLook> quick_look_from(std::span<const std::uint8_t> bytes) {
  try {
    const json stored = json::from_cbor(bytes.begin(), bytes.end());
    KeyframeQuickLook quick_look;
    stored.at("digest").get_to(quick_look.digest);
    stored.at("faults").get_to(quick_look.faults);
    stored.at("depth_pixels").get_to(quick_look.depth_pixels);
    stored.at("median_depth").get_to(quick_look.median_depth);
    stored.at("ground_step").get_to(quick_look.ground_step);
    const json& bounds = stored.at("bounds");
    bounds.at(0).get_to(quick_look.bounds.x_low);
    bounds.at(1).get_to(quick_look.bounds.x_high);
    bounds.at(2).get_to(quick_look.bounds.y_low);
    bounds.at(3).get_to(quick_look.bounds.y_high);
    quick_look.image = stored.at("image").get_binary();
    quick_look.mask = stored.at("mask").get_binary();
    quick_look.depth = stored.at("depth").get_binary();
    stored.at("range").at(0).get_to(quick_look.nearest);
    stored.at("range").at(1).get_to(quick_look.farthest);
    return quick_look;
  } catch (const json::exception&) {
    return std::nullopt;
  }
}

}  // namespace ilp::map
