#include "sim/host/colmap_text.hpp"

#include <cstdio>

#include "sim/host/files.hpp"

namespace ilp::host {
namespace {

std::string text_of(double value, const char* format = " %.17g") {
  std::array<char, 40> buffer{};
  std::snprintf(buffer.data(), buffer.size(), format, value);
  return buffer.data();
}

std::string images_text(const ColmapText& model) {
  std::string text =
      "# Image list with two lines of data per image:\n"
      "#   IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n#   POINTS2D[] as (X, Y, POINT3D_ID)\n";
  for (const ColmapView& view : model.views) {
    text += std::to_string(view.id);
    for (const double q : view.q_cam_from_world) text += text_of(q);
    for (int i = 0; i < 3; ++i) text += text_of(view.translation[i]);
    text += " 1 " + view.name + "\n";
    const char* first = "%.9g";
    for (const ColmapObservation& o : view.seen) {
      text += text_of(o.x + 0.5, first) + text_of(o.y + 0.5, " %.9g") + " " + std::to_string(o.point + 1);
      first = " %.9g";
    }
    text += "\n";
  }
  return text;
}

std::string points_text(const ColmapText& model) {
  std::string text =
      "# 3D point list with one line of data per point:\n"
      "#   POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, POINT2D_IDX)\n";
  for (std::size_t i = 0; i < model.points.size(); ++i) {
    const ColmapPoint& point = model.points[i];
    text += std::to_string(i + 1);
    for (int axis = 0; axis < 3; ++axis) text += text_of(point.position[axis]);
    const std::string grey = " " + std::to_string(point.grey);
    text += grey + grey + grey + text_of(point.error_px, " %.6g");
    for (const auto& [view, index] : point.track) text += " " + std::to_string(view) + " " + std::to_string(index);
    text += "\n";
  }
  return text;
}

}  // namespace

void write_colmap_text(const ColmapText& model, const std::filesystem::path& folder) {
  write_file(folder / "images.txt", images_text(model));
  write_file(folder / "points3D.txt", points_text(model));
}

}  // namespace ilp::host
