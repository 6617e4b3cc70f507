// The viewer's page of a made-up flight of two strips: viewer_sample FILE KEYFRAMES

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <iostream>

#include "sim/ground/viewer/viewer_page.hpp"
#include "sim/host/files.hpp"

namespace {

using namespace ilp;

constexpr double spacing = 1, altitude = 5, field = 320;

double relief(double x, double y) {
  double z = 0, size = 0.8;
  for (double f = 0.35; f < 9; f *= 2.03, size *= 0.47)
    z += size * std::sin(f * x + 1.3 * f) * std::cos(1.1 * f * y - f);
  return z;
}

host::Raster<std::uint8_t> picture(double x, double y) {
  host::Raster<std::uint8_t> image(320, 240);
  for (std::int32_t v = 0; v < image.height; ++v) {
    for (std::int32_t u = 0; u < image.width; ++u) {
      const double slope =
          relief(x + (u - 160) / 64.0, y - (v - 120) / 64.0) - relief(x + (u - 161) / 64.0, y - (v - 120) / 64.0);
      image.at(u, v) = static_cast<std::uint8_t>(std::clamp(128 + 2500 * slope, 0.0, 255.0));
    }
  }
  return image;
}

intake::Keyframe keyframe(std::int64_t id, std::int64_t strip, double x, double y) {
  intake::Keyframe k;
  k.id = id;
  k.strip_id = strip;
  k.name = "frame-" + std::to_string(id) + ".png";
  k.camera = CameraModel{};
  k.camera.width = 320;
  k.camera.height = 240;
  k.camera.fx = k.camera.fy = field;
  k.camera.cx = 159.5;
  k.camera.cy = 119.5;
  KeyframeRecord record;
  record.id = id;
  record.frame_id = 4 * id;
  record.time_ns = id * 8000000000;
  record.index = static_cast<std::int32_t>(id);
  record.overlap = 0.8 + 0.03 * std::sin(0.7 * static_cast<double>(id));
  k.record = record;
  PoseRecord pose{.id = id, .state = PoseState::final};
  pose.q_cam_from_world[0] = 0;  // half a turn about x: the camera looks down, its x is the world's
  pose.q_cam_from_world[1] = 1;
  pose.centre[0] = x;
  pose.centre[1] = y;
  pose.centre[2] = altitude + 0.2 * std::sin(0.1 * static_cast<double>(id));
  for (int i = 0; i < 3; ++i) pose.sigma[i] = 1e-4 * (1 + i) * std::sqrt(static_cast<double>(id));
  k.pose = pose;
  RichnessRecord richness{.richness = 0.5 + 0.4 * std::sin(0.9 * static_cast<double>(id))};
  k.richness = richness;
  k.image = picture(x, y);
  k.products[1] = intake::ProductAccount{"product-" + std::to_string(id) + "-image.jp2", 8000, 9000,
                                         ProductScheme::lossy_region, 3};
  return k;
}

map::GroundGrid grid_over(double x0, double x1, double y, std::size_t keyframes) {
  map::GroundGrid grid;
  grid.cell = 0.02;
  grid.x0 = x0 - 2;
  grid.y0 = y + 2;
  const auto width = static_cast<std::int32_t>((x1 - x0 + 4) / grid.cell),
             height = static_cast<std::int32_t>(4 / grid.cell);
  grid.height = host::Raster<float>(width, height);
  grid.sigma = host::Raster<float>(width, height, 0.01F);
  grid.ortho = host::Raster<std::uint8_t>(width, height);
  grid.count = host::Raster<std::uint16_t>(width, height, 1);
  grid.source = host::Raster<std::uint16_t>(width, height);
  for (std::int32_t j = 0; j < height; ++j) {
    for (std::int32_t i = 0; i < width; ++i) {
      const double x = grid.x0 + i * grid.cell, v = grid.y0 - j * grid.cell;
      const bool hole = std::hypot(x - x0 - 6, v - y) < 0.5;
      grid.height.at(i, j) = hole ? std::nanf("") : static_cast<float>(relief(x, v));
      grid.ortho.at(i, j) =
          static_cast<std::uint8_t>(std::clamp(128 + 1200 * (relief(x, v) - relief(x - grid.cell, v)), 1.0, 255.0));
      const auto place =
          static_cast<std::size_t>(std::clamp((x - x0) / spacing + 0.5, 0.0, static_cast<double>(keyframes - 1)));
      grid.source.at(i, j) = static_cast<std::uint16_t>(place + 1);
    }
  }
  return grid;
}

void add_strip(report::Report& report, std::int64_t id, std::int64_t first, std::int64_t last, double y) {
  report::StripResult result;
  result.strip.id = id;
  result.strip.record = StripRecord{id, first, last, StripEnd::end_of_flight};
  for (std::int64_t k = first; k <= last; ++k) {
    report.flight.keyframes[k] = keyframe(k, id, spacing * static_cast<double>(k - first), y);
    result.strip.keyframes.push_back(k);
  }
  const double length = spacing * static_cast<double>(last - first);
  result.grid = grid_over(0, length, y, result.strip.keyframes.size());
  result.track_length = length;
  result.flying_height = altitude;
  report.flight.strips[id] = result.strip;
  report.strips.push_back(std::move(result));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  try {
    const std::int64_t keyframes = std::max(20, std::atoi(argv[2]));
    report::Report report;
    report.title = "Made up </script><script>alert(1)</script>";
    report.target_overlap = 0.8;
    add_strip(report, 1, 1, keyframes - 8, 0);
    add_strip(report, 2, keyframes - 7, keyframes, 0.7);
    for (std::int64_t i = 1; i <= 40; ++i) {
      EventRecord event;
      event.id = i;
      event.time_ns = i * keyframes * 200000000;
      event.code = static_cast<std::uint16_t>(i);
      event.severity = static_cast<std::uint8_t>(i % 4);
      std::snprintf(event.component, sizeof event.component, "component %d", static_cast<int>(i % 5));
      report.flight.events.push_back(event);
    }
    const auto link = [&](std::int64_t place, std::int64_t newer, LinkVerdict verdict) {
      LinkRecord record{.id = 8 * newer, .keyframe_id = newer, .place_id = place, .verdict = verdict};
      report.flight.links.push_back(record);
    };
    for (std::int64_t i = 1; i <= 4; ++i) link(i, i + 8, LinkVerdict::linked);
    link(2, 15, LinkVerdict::contradicts_poses);
    link(3, 30, LinkVerdict::images_only);
    link(4, keyframes, LinkVerdict::linked);  // in another strip
    map::PixelRays rays;
    for (const auto& [id, k] : report.flight.keyframes) {
      report.quick_looks[id] = map::quick_look_at(k, k, map::quick_look_width_px(report.flight.keyframes.size()), rays);
    }
    if (viewer::viewer_available()) {
      host::update_file(argv[1], [&](std::ostream& page) { viewer::write_viewer_html(report, page); });
    }
    return 0;
  } catch (const std::exception& error) {
    std::cerr << error.what() << "\n";
    return 1;
  }
}
