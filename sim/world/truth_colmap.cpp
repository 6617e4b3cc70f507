#include "sim/world/truth_colmap.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <stdexcept>
#include <utility>

#include "fsw/vision/geometry/rigid_transform.hpp"
#include "sim/host/colmap_camera.hpp"

namespace ilp::world {
namespace {

constexpr std::int32_t candidates_per_row = 24;

struct Observation {
  Vec2 pixel;
  std::size_t point = 0;
};

struct TruePoint {
  Vec3 position;
  std::vector<std::pair<std::size_t, std::size_t>> track;  // frame, index of its observation
};

struct Model {
  std::vector<std::vector<Observation>> images;
  std::vector<TruePoint> points;
};

std::string text_of(double value) {
  std::array<char, 40> buffer{};
  std::snprintf(buffer.data(), buffer.size(), " %.17g", value);
  return buffer.data();
}

void add_point(std::span<const TrueFrame> frames, std::size_t first, const Vec3& position, Model& model) {
  std::vector<std::pair<std::size_t, Vec2>> seen;
  for (std::size_t k = first; k < frames.size(); ++k) {
    Vec2 pixel;
    double depth = 0;
    if (sees(frames[k], position) && project(frames[k], position, pixel, depth)) seen.emplace_back(k, pixel);
  }
  if (seen.size() < 2) return;
  TruePoint point{position, {}};
  for (const auto& [frame, pixel] : seen) {
    point.track.emplace_back(frame, model.images[frame].size());
    model.images[frame].push_back({pixel, model.points.size()});
  }
  model.points.push_back(std::move(point));
}

Model build(std::span<const TrueFrame> frames) {
  Model model;
  model.images.resize(frames.size());
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const TrueFrame& frame = frames[k];
    const std::int32_t step = std::max(1, frame.columns / candidates_per_row);
    for (std::int32_t j = step / 2; j < frame.rows; j += step) {
      for (std::int32_t i = step / 2; i < frame.columns; i += step) {
        const Vec3& position = frame.ground[frame.index(i, j)];
        const auto earlier = frames.first(k);
        const bool known = std::any_of(earlier.rbegin(), earlier.rend(),
                                       [&](const TrueFrame& other) { return sees(other, position); });
        if (position.allFinite() && !known) add_point(frames, k, position, model);
      }
    }
  }
  return model;
}

std::string images_text(std::span<const TrueFrame> frames, const std::vector<std::string>& names, const Model& model) {
  std::string text =
      "# Image list with two lines of data per image:\n"
      "#   IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n#   POINTS2D[] as (X, Y, POINT3D_ID)\n";
  for (std::size_t k = 0; k < frames.size(); ++k) {
    double q[4];
    quaternion_from_rotation(frames[k].cam_from_world, q);
    const Vec3 t = -(frames[k].cam_from_world * frames[k].centre);
    text += std::to_string(k + 1);
    for (const double value : q) text += text_of(value);
    for (int i = 0; i < 3; ++i) text += text_of(t[i]);
    text += " 1 " + names[k] + "\n";
    for (std::size_t i = 0; i < model.images[k].size(); ++i) {
      const Observation& o = model.images[k][i];
      std::array<char, 96> line{};
      std::snprintf(line.data(), line.size(), "%s%.9g %.9g %zu", i > 0 ? " " : "", o.pixel.x() + 0.5, o.pixel.y() + 0.5,
                    o.point + 1);
      text += line.data();
    }
    text += "\n";
  }
  return text;
}

std::string points_text(const Model& model) {
  std::string text =
      "# 3D point list with one line of data per point:\n"
      "#   POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, POINT2D_IDX)\n";
  for (std::size_t i = 0; i < model.points.size(); ++i) {
    text += std::to_string(i + 1);
    for (int axis = 0; axis < 3; ++axis) text += text_of(model.points[i].position[axis]);
    text += " 128 128 128 0";
    for (const auto& [frame, index] : model.points[i].track) {
      text += " " + std::to_string(frame + 1) + " " + std::to_string(index);
    }
    text += "\n";
  }
  return text;
}

void write_text(const std::filesystem::path& path, const std::string& text) {
  std::ofstream out(path, std::ios::binary);
  out << text;
  if (!out.flush()) throw std::runtime_error(path.string() + ": cannot be written");
}

}  // namespace

void write_true_colmap_model(std::span<const TrueFrame> frames, const std::vector<std::string>& names,
                             const std::filesystem::path& folder) {
  if (frames.empty() || frames.size() != names.size()) {
    throw std::invalid_argument("a model of " + std::to_string(frames.size()) + " frames with " +
                                std::to_string(names.size()) + " names; expected as many, and at least one");
  }
  const Model model = build(frames);
  std::filesystem::create_directories(folder);
  host::write_colmap_camera(folder / "cameras.txt", frames.front().camera);
  write_text(folder / "images.txt", images_text(frames, names, model));
  write_text(folder / "points3D.txt", points_text(model));
}

}  // namespace ilp::world
