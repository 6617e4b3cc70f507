#include "tests/unit/ground/synthetic_flight.hpp"

#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <memory>
#include <stdexcept>

#include "fsw/base/crc.hpp"
#include "fsw/base/status.hpp"
#include "fsw/vision/codec/jpeg2000.hpp"
#include "fsw/vision/codec/metadata.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"
#include "fsw/vision/terrain/mask_coding.hpp"
#include "sim/ground/intake/record_file.hpp"

namespace ilp::test {
namespace {
namespace fs = std::filesystem;
using intake::RecordEntry;

constexpr double slope_x = 0.06, slope_y = -0.04, level = 1;
constexpr double depth_offset = 0.02, depth_step = 2e-5;
constexpr int border = 4;

void check(const Status& status) {
  if (!status.ok()) throw std::runtime_error(status_name(status.code));
}

void write_bytes(const fs::path& path, std::span<const std::uint8_t> bytes) {
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

std::string numbered(const char* prefix, std::int64_t id, const char* suffix) {
  char name[64];
  std::snprintf(name, sizeof(name), "%s%06lld%s", prefix, static_cast<long long>(id), suffix);
  return name;
}

Vec3 ground_point(const SyntheticFlight& flight, const SyntheticView& view, int x, int y) {
  const CameraModel& c = flight.camera;
  return view.centre + view.cam_from_world.transpose() *
                           (plane_depth(flight, view, x, y) * Vec3((x - c.cx) / c.fx, (y - c.cy) / c.fy, 1));
}

PoseRecord pose_record(const SyntheticView& view) {
  PoseRecord pose{.id = view.keyframe_id, .strip_id = view.strip_id, .state = PoseState::final};
  quaternion_from_rotation(view.cam_from_world, pose.q_cam_from_world);
  for (int i = 0; i < 3; ++i) pose.centre[i] = view.centre[i];
  for (double& s : pose.sigma) s = 0.01;
  pose.matches = 200;
  pose.inliers = 180;
  pose.rms_px = 0.2;
  pose.parallax_px = 30;
  return pose;
}

std::vector<std::uint8_t> structure_blob(const SyntheticFlight& flight, std::uint32_t& count) {
  std::vector<std::uint8_t> blob;
  const auto append = [&blob](const void* from, std::size_t bytes) {
    const auto* b = static_cast<const std::uint8_t*>(from);
    blob.insert(blob.end(), b, b + bytes);
  };
  count = 0;
  for (const Vec3& point : flight.points) {
    std::vector<StructureObservation> seen;
    for (const SyntheticView& view : flight.views) {
      const Vec2 p = colmap_pixel(flight.camera, view.cam_from_world, -(view.cam_from_world * view.centre), point);
      if (p.x() < 1 || p.y() < 1 || p.x() > flight.camera.width - 1 || p.y() > flight.camera.height - 1) continue;
      seen.push_back({view.keyframe_id, static_cast<float>(p.x() - 0.5), static_cast<float>(p.y() - 0.5)});
    }
    StructurePoint head{{point.x(), point.y(), point.z()}, 0.1F, static_cast<std::uint32_t>(seen.size())};
    append(&head, sizeof(head));
    for (const auto& o : seen) append(&o, sizeof(o));
    ++count;
  }
  return blob;
}

std::vector<std::uint8_t> mask_of(const SyntheticFlight& flight, std::size_t view, std::uint32_t& inside) {
  const CameraModel& c = flight.camera;
  std::vector<std::uint8_t> mask(static_cast<std::size_t>(c.width * c.height));
  inside = 0;
  for (int y = 0; y < c.height; ++y) {
    for (int x = 0; x < c.width; ++x) {
      if (!newly_seen(flight, view, x, y)) continue;
      mask[static_cast<std::size_t>(y * c.width + x)] = 255;
      ++inside;
    }
  }
  return mask;
}

TimeNs taken_at(const SyntheticFlight& flight, const SyntheticView& view) {
  return flight.begins_ns + view.keyframe_id * 2 * ns_per_s;
}

std::vector<std::uint8_t> product_file(const SyntheticFlight& flight, const SyntheticView& view, ProductKind kind,
                                       const std::vector<std::uint16_t>& samples,
                                       const std::vector<std::uint8_t>& mask) {
  std::array<std::uint8_t, limits::max_metadata_bytes> buffer{};
  MetadataWriter writer(buffer);
  const PoseRecord pose = pose_record(view);
  const CameraModel& c = flight.camera;
  writer.integer("keyframe", view.keyframe_id);
  writer.integer("strip", view.strip_id);
  writer.text("kind", name_of(kind));
  writer.text("frame_name", view.name);
  writer.integer("time_ns", taken_at(flight, view));
  writer.integer("width", c.width);
  writer.integer("height", c.height);
  const double camera[] = {c.fx, c.fy, c.cx, c.cy, c.k1, c.k2, c.p1, c.p2};
  writer.reals("camera", camera);
  writer.reals("q_cam_from_world", pose.q_cam_from_world);
  writer.reals("centre", pose.centre);
  writer.reals("sigma", pose.sigma);
  writer.integer("grant_bytes", 100000);
  if (kind == ProductKind::depth) {
    writer.real("depth_offset", depth_offset);
    writer.real("depth_step", depth_step);
  }
  check(writer.status());
  static const auto workspace = std::make_unique<Jpeg2000Workspace>();
  Jpeg2000Params params;
  params.max_bytes = 400000;
  params.lossless = true;
  params.region = kind == ProductKind::image ? RegionCoding::none : RegionCoding::drop_background;
  std::vector<std::uint8_t> file(params.max_bytes);
  Jpeg2000Product product;
  check(encode_jpeg2000({samples.data(), c.width, c.height}, kind == ProductKind::image ? 8 : 13,
                        {mask.data(), c.width, c.height}, params, writer.bytes(), *workspace, file, product));
  file.resize(product.bytes);
  return file;
}

void write_products(const SyntheticFlight& flight, std::size_t index, std::vector<RecordEntry>& entries,
                    const fs::path& folder) {
  const SyntheticView& view = flight.views[index];
  const CameraModel& c = flight.camera;
  std::uint32_t inside = 0;
  const std::vector<std::uint8_t> mask = mask_of(flight, index, inside);
  std::vector<std::uint16_t> grey(mask.size()), code(mask.size());
  for (int y = 0; y < c.height; ++y) {
    for (int x = 0; x < c.width; ++x) {
      const auto i = static_cast<std::size_t>(y * c.width + x);
      const Vec3 ground = ground_point(flight, view, x, y);
      grey[i] = static_cast<std::uint16_t>(plane_grey(ground.x(), ground.y()) + 0.5);
      if (mask[i] != 0) {
        code[i] = static_cast<std::uint16_t>((1 / plane_depth(flight, view, x, y) - depth_offset) / depth_step + 0.5);
      }
    }
  }
  std::vector<std::uint8_t> coded(max_mask_bytes(mask.size()));
  std::size_t coded_size = 0;
  check(encode_mask({mask.data(), c.width, c.height}, coded.data(), coded.size(), coded_size));
  coded.resize(coded_size);
  DepthRecord depth;
  depth.id = view.keyframe_id;
  depth.strip_id = view.strip_id;
  depth.width = c.width;
  depth.height = c.height;
  depth.offset = depth_offset;
  depth.step = depth_step;
  entries.push_back(intake::entry_of(depth));
  MaskRecord new_ground;
  new_ground.id = view.keyframe_id;
  new_ground.scope = MaskScope::flight;
  new_ground.width = c.width;
  new_ground.height = c.height;
  new_ground.newly_seen = inside;
  new_ground.code.bytes = static_cast<std::uint32_t>(coded.size());
  entries.push_back(intake::entry_of(new_ground, {coded}));
  for (const ProductKind kind : {ProductKind::image, ProductKind::depth}) {
    const bool is_image = kind == ProductKind::image;
    const auto file = product_file(flight, view, kind, is_image ? grey : code, mask);
    ProductRecord record;
    record.keyframe_id = view.keyframe_id;
    record.strip_id = view.strip_id;
    record.kind = kind;
    record.id = product_id(view.keyframe_id, kind);
    record.bytes = static_cast<std::uint32_t>(file.size());
    record.crc32 = crc32(file);
    record.grant_bytes = 100000;
    entries.push_back(intake::entry_of(record, {{}}));
    write_bytes(folder / numbered("product-", view.keyframe_id, is_image ? "-image.jp2" : "-depth.jp2"), file);
  }
}

}  // namespace

double plane_height(double x, double y) {
  return slope_x * x + slope_y * y + level;
}

double plane_grey(double x, double y) {
  return 128 + 60 * std::sin(1.3 * x + 0.4) * std::cos(0.9 * y);
}

SyntheticFlight make_flight(bool distorted) {
  SyntheticFlight flight;
  flight.camera = {128, 96, 120, 121, 63.2, 47.1, 0, 0, 0, 0};
  if (distorted) {
    flight.camera.k1 = -0.08;
    flight.camera.k2 = 0.02;
    flight.camera.p1 = 0.001;
    flight.camera.p2 = -0.002;
  }
  for (int i = 0; i < 5; ++i) {
    SyntheticView view;
    view.keyframe_id = i + 1;
    view.name = numbered("frame-", 10 * i, ".png");
    view.centre = Vec3(2.1 * i, 0.25 * i * (4 - i), 11 + 0.3 * i * i);
    Mat3 nadir;
    nadir << 1, 0, 0, 0, -1, 0, 0, 0, -1;
    view.cam_from_world = rotation_from_vector(Vec3(0.03 * i, 0.05 - 0.02 * i, 0.04 * i)) * nadir;
    flight.views.push_back(view);
  }
  for (int i = 0; i < 60; ++i) {
    const double x = -2 + 0.21 * i, y = 2.5 * std::sin(0.7 * i);
    flight.points.emplace_back(x, y, plane_height(x, y));
  }
  return flight;
}

Vec2 colmap_pixel(const CameraModel& c, const Mat3& rotation, const Vec3& translation, const Vec3& world) {
  const Vec3 p = rotation * world + translation;
  const double u = p.x() / p.z(), v = p.y() / p.z(), r2 = u * u + v * v;
  const double radial = c.k1 * r2 + c.k2 * r2 * r2;
  const double du = u * radial + 2 * c.p1 * u * v + c.p2 * (r2 + 2 * u * u);
  const double dv = v * radial + 2 * c.p2 * u * v + c.p1 * (r2 + 2 * v * v);
  return {c.fx * (u + du) + c.cx + 0.5, c.fy * (v + dv) + c.cy + 0.5};
}

double plane_depth(const SyntheticFlight& flight, const SyntheticView& view, int x, int y) {
  const CameraModel& c = flight.camera;
  const Vec3 ray = view.cam_from_world.transpose() * Vec3((x - c.cx) / c.fx, (y - c.cy) / c.fy, 1);
  // centre + z * ray on the plane
  return (plane_height(view.centre.x(), view.centre.y()) - view.centre.z()) /
         (ray.z() - slope_x * ray.x() - slope_y * ray.y());
}

bool newly_seen(const SyntheticFlight& flight, std::size_t view, int x, int y) {
  const CameraModel& c = flight.camera;
  const auto inside = [&c](double px, double py) {
    return px >= border && py >= border && px <= c.width - 1 - border && py <= c.height - 1 - border;
  };
  if (!inside(x, y)) return false;
  if (view == 0) return true;
  const SyntheticView& before = flight.views[view - 1];
  const Vec3 p = before.cam_from_world * (ground_point(flight, flight.views[view], x, y) - before.centre);
  return !inside(c.fx * p.x() / p.z() + c.cx, c.fy * p.y() / p.z() + c.cy);
}

void write_outbox(const SyntheticFlight& flight, const fs::path& folder) {
  fs::create_directories(folder);
  for (std::size_t i = 0; i < flight.views.size(); ++i) {
    const SyntheticView& view = flight.views[i];
    std::vector<RecordEntry> entries;
    entries.push_back(intake::entry_of(camera_record(flight.camera)));
    StripRecord strip{.id = view.strip_id, .last_keyframe_id = view.keyframe_id};
    entries.push_back(intake::entry_of(strip));
    KeyframeRecord keyframe;
    keyframe.time_ns = taken_at(flight, view);
    keyframe.id = view.keyframe_id;
    keyframe.frame_id = 10 * view.keyframe_id;
    keyframe.strip_id = view.strip_id;
    keyframe.index = static_cast<std::int32_t>(i);
    keyframe.overlap = 0.8;
    entries.push_back(intake::entry_of(keyframe));
    entries.push_back(intake::entry_of(pose_record(view)));
    if (i == 0) {
      StructureRecord structure{.id = view.keyframe_id, .strip_id = view.strip_id};
      auto blob = structure_blob(flight, structure.count);
      structure.points.bytes = static_cast<std::uint32_t>(blob.size());
      entries.push_back(intake::entry_of(structure, {std::move(blob)}));
    }
    if (!flight.camera.has_distortion()) write_products(flight, i, entries, folder);
    RichnessRecord richness{
        .id = view.keyframe_id, .strip_id = view.strip_id, .richness = 0.3 + 0.1 * static_cast<double>(i)};
    entries.push_back(intake::entry_of(richness));
    write_bytes(folder / numbered("records-", view.keyframe_id, ".ilp"), intake::write_record_file(entries));
  }
  EventRecord event;
  event.id = 1;
  event.time_ns = 5 * ns_per_s;
  event.code = static_cast<std::uint16_t>(StatusCode::frame_gap);
  event.severity = static_cast<std::uint8_t>(status_severity(StatusCode::frame_gap));
  event.a = 17;
  event.b = 3;
  std::strcpy(event.component, "acquisition");
  ComponentRecord component{.id = 1};
  std::strcpy(component.name, "acquisition");
  component.steps = 40;
  component.busy_ns = 2 * ns_per_s;
  const std::vector<RecordEntry> housekeeping{intake::entry_of(event), intake::entry_of(component)};
  write_bytes(folder / "events-000001.ilp", intake::write_record_file(housekeeping));
}

void write_truth(const SyntheticFlight& flight, const fs::path& folder, double scale, const Mat3& rotation,
                 const Vec3& translation) {
  fs::create_directories(folder / "depth");
  std::ofstream poses(folder / "poses.txt");
  poses.precision(17);
  poses << "# truth\n";
  const CameraModel& c = flight.camera;
  for (const SyntheticView& view : flight.views) {
    const Mat3 r = view.cam_from_world * rotation.transpose();
    const Vec3 centre = scale * (rotation * view.centre) + translation;
    poses << view.name << " " << c.width << " " << c.height << " " << c.fx << " " << c.fy << " " << c.cx << " " << c.cy;
    for (int i = 0; i < 9; ++i) poses << " " << r(i / 3, i % 3);
    poses << " " << centre.x() << " " << centre.y() << " " << centre.z() << "\n";
    // PFM, written here by hand: rows from the bottom.
    std::ofstream depth(folder / "depth" / (view.name.substr(0, view.name.size() - 4) + ".pfm"), std::ios::binary);
    depth << "Pf\n" << c.width << " " << c.height << "\n-1.0\n";
    for (int y = c.height - 1; y >= 0; --y) {
      for (int x = 0; x < c.width; ++x) {
        const auto z = static_cast<float>(scale * plane_depth(flight, view, x, y));
        depth.write(reinterpret_cast<const char*>(&z), sizeof(z));
      }
    }
  }
}

}  // namespace ilp::test
