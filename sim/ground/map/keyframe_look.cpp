#include "sim/ground/map/keyframe_look.hpp"

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
             KeyframeLook& look) {
  std::vector<double> depths;
  for (const float d : rasters.inverse_depth.samples) {
    if (d > 0) depths.push_back(1.0 / d);
  }
  look.depth_pixels = depths.size();
  if (depths.empty()) return;
  look.median_depth = host::median(std::move(depths));
  if (!has_surface(keyframe)) return;
  const SurfaceMesh surface = keyframe_surface(keyframe, rasters, {}, rays);
  if (surface.vertices.empty()) return;
  look.ground_step = look.median_depth / keyframe.camera.fx;
  constexpr double slanted = 8;
  look.bounds =
      robust_bounds(surface, slanted * look.ground_step * std::max(keyframe.camera.width, keyframe.camera.height));
}

void draw(const intake::KeyframeRasters& rasters, std::int32_t width, KeyframeLook& look) {
  if (!rasters.image.empty()) look.image = host::png_bytes(host::shrink(rasters.image, width, host::mean_grey));
  if (!rasters.mask.empty()) look.mask = host::png_bytes(host::shrink(rasters.mask, width, host::mean_grey));
  if (rasters.inverse_depth.empty()) return;
  const host::Raster<float> depth = host::shrink(rasters.inverse_depth, width, host::mean_depth);
  const host::ValueRange range = host::display_range(depth);
  look.depth = host::png_bytes(host::colour_mapped(depth, range));
  look.nearest = range.low;
  look.farthest = range.high;
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

std::int32_t look_width_px(std::size_t keyframes) {
  // Steps, so that one keyframe more does not change all pictures.
  return keyframes <= 140 ? 240 : keyframes <= 560 ? 120 : keyframes <= 2240 ? 60 : 30;
}

KeyframeLook look_at(const intake::Keyframe& keyframe, const intake::KeyframeRasters& rasters, std::int32_t width_px,
                     PixelRays& rays) {
  KeyframeLook look;
  look.digest = keyframe_digest(keyframe);
  measure(keyframe, rasters, rays, look);
  draw(rasters, width_px, look);
  return look;
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

std::vector<std::uint8_t> bytes_of(const KeyframeLook& look) {
  const MapBounds& b = look.bounds;
  const json told = {{"digest", look.digest},
                     {"faults", look.faults},
                     {"depth_pixels", look.depth_pixels},
                     {"median_depth", look.median_depth},
                     {"ground_step", look.ground_step},
                     {"bounds", {b.x_low, b.x_high, b.y_low, b.y_high}},
                     {"image", json::binary(look.image)},
                     {"mask", json::binary(look.mask)},
                     {"depth", json::binary(look.depth)},
                     {"range", {look.nearest, look.farthest}}};
  return json::to_cbor(told);
}

std::optional<KeyframeLook> look_from(std::span<const std::uint8_t> bytes) {
  try {
    const json told = json::from_cbor(bytes.begin(), bytes.end());
    KeyframeLook look;
    told.at("digest").get_to(look.digest);
    told.at("faults").get_to(look.faults);
    told.at("depth_pixels").get_to(look.depth_pixels);
    told.at("median_depth").get_to(look.median_depth);
    told.at("ground_step").get_to(look.ground_step);
    const json& bounds = told.at("bounds");
    bounds.at(0).get_to(look.bounds.x_low);
    bounds.at(1).get_to(look.bounds.x_high);
    bounds.at(2).get_to(look.bounds.y_low);
    bounds.at(3).get_to(look.bounds.y_high);
    look.image = told.at("image").get_binary();
    look.mask = told.at("mask").get_binary();
    look.depth = told.at("depth").get_binary();
    told.at("range").at(0).get_to(look.nearest);
    told.at("range").at(1).get_to(look.farthest);
    return look;
  } catch (const json::exception&) {
    return std::nullopt;
  }
}

}  // namespace ilp::map
