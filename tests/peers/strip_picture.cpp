// strip-picture: cameras and points of a COLMAP text model from the side and from above, as SVG.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <limits>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "sim/host/alignment.hpp"
#include "sim/host/reference_cameras.hpp"
#include "sim/tools/lab/colmap_reader.hpp"

namespace ilp {
namespace {

constexpr const char* usage =
    "usage: strip-picture MODEL REFERENCE OUT.svg\n"
    "  MODEL      folder with cameras.txt, images.txt, points3D.txt\n"
    "  REFERENCE  poses, a line per image: name width height fx fy cx cy R(3x3) C(3), z up\n";

constexpr double width_px = 840;
constexpr double margin_px = 46;
constexpr double gap_px = 34;
constexpr int shades = 6;
constexpr const char* shade_colours[shades] = {"#30507a", "#3f7fa6", "#4aa58f", "#8fb858", "#d3ad3c", "#c9682f"};

struct PosedCamera {
  Vec3 centre, reference;
  Vec3 corners[4];  ///< where the rays of the image's corners meet the mean height of the points
};

struct Scene {
  std::vector<PosedCamera> cameras;  ///< in the order of their names
  std::vector<Vec3> points;
  double ground = 0;  ///< median height of the points
};

/// Model in the reference's frame, turned about the vertical so that the flight goes along x.
Scene make_scene(const lab::ColmapModel& model, const std::vector<host::ReferenceCamera>& references) {
  std::map<std::string, const host::ReferenceCamera*> by_name;
  for (const host::ReferenceCamera& reference : references) by_name[reference.name] = &reference;
  std::map<std::string, const lab::ColmapImage*> images;
  for (const lab::ColmapImage& image : model.images) images[image.name] = &image;
  std::vector<Vec3> centres, true_centres;
  std::vector<Mat3> attitudes, true_attitudes;
  for (const auto& [name, image] : images) {
    if (by_name.count(name) == 0) throw std::runtime_error("the reference has no image " + name);
    centres.push_back(inverse(image->cam_from_world).translation);
    attitudes.push_back(image->cam_from_world.rotation);
    true_centres.push_back(by_name[name]->centre);
    true_attitudes.push_back(by_name[name]->cam_from_world);
  }
  const auto aligned = host::align_cameras(centres, attitudes, true_centres, true_attitudes, 1);
  if (!aligned) throw std::runtime_error("too few posed images to align");

  const Vec3 way = true_centres.back() - true_centres.front();
  const double length = std::hypot(way.x(), way.y());
  if (!(length > 0)) throw std::runtime_error("the flight has no horizontal direction");
  Mat3 turn = Mat3::Identity();
  turn << way.x() / length, way.y() / length, 0, -way.y() / length, way.x() / length, 0, 0, 0, 1;

  Scene scene;
  std::vector<double> heights;
  for (const auto& [id, point] : model.points) {
    scene.points.push_back(turn * (*aligned * point));
    heights.push_back(scene.points.back().z());
  }
  if (heights.empty()) throw std::runtime_error("the model has no points");
  std::nth_element(heights.begin(), heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 2), heights.end());
  scene.ground = heights[heights.size() / 2];
  for (std::size_t i = 0; i < centres.size(); ++i) {
    PosedCamera camera{turn * (*aligned * centres[i]), turn * true_centres[i], {}};
    const CameraModel& k = model.camera;
    const Mat3 world_from_cam = turn * aligned->rotation * attitudes[i].transpose();
    for (int corner = 0; corner < 4; ++corner) {
      const double u = corner == 0 || corner == 3 ? -0.5 : k.width - 0.5, v = corner < 2 ? -0.5 : k.height - 0.5;
      const Vec3 ray = world_from_cam * Vec3((u - k.cx) / k.fx, (v - k.cy) / k.fy, 1);
      camera.corners[corner] = camera.centre + ray * ((scene.ground - camera.centre.z()) / ray.z());
    }
    scene.cameras.push_back(camera);
  }
  return scene;
}

struct Range {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  void take(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  [[nodiscard]] double size() const { return high - low; }
};

/// Maps x and one other axis (1 across, 2 up) to picture px.
struct Panel {
  double px_per_unit, x_low, other_high, top;
  int axis;
  [[nodiscard]] double x(const Vec3& p) const { return margin_px + (p.x() - x_low) * px_per_unit; }
  [[nodiscard]] double y(const Vec3& p) const { return top + (other_high - p[axis]) * px_per_unit; }
};

std::string text(const char* format, double a, double b) {
  char buffer[160];
  std::snprintf(buffer, sizeof(buffer), format, a, b);
  return buffer;
}

void draw_points(const Scene& scene, const Panel& panel, std::ostream& out) {
  Range heights;
  std::vector<double> sorted;
  for (const Vec3& point : scene.points) sorted.push_back(point.z());
  std::sort(sorted.begin(), sorted.end());
  heights.take(sorted[sorted.size() / 50]);
  heights.take(sorted[sorted.size() - 1 - sorted.size() / 50]);
  std::string paths[shades];
  for (const Vec3& point : scene.points) {
    const double share = (point.z() - heights.low) / std::max(heights.size(), 1e-9);
    const int shade = std::clamp(static_cast<int>(share * shades), 0, shades - 1);
    paths[shade] += text("M%.0f %.0fh0", panel.x(point), panel.y(point));
  }
  for (int shade = 0; shade < shades; ++shade) {
    out << "<path class=\"p\" stroke=\"" << shade_colours[shade] << "\" d=\"" << paths[shade] << "\"/>\n";
  }
}

void draw_cameras(const Scene& scene, const Panel& panel, std::ostream& out) {
  std::string views, track;
  for (const PosedCamera& camera : scene.cameras) {
    const char* step = "M%.1f %.1f";
    if (panel.axis == 1) {
      for (const Vec3& corner : camera.corners) {
        views += text(step, panel.x(corner), panel.y(corner));
        step = "L%.1f %.1f";
      }
      views += "Z";
    } else {
      Range seen;
      for (const Vec3& corner : camera.corners) seen.take(corner.x());
      views += text("M%.1f %.1f", panel.x(Vec3(seen.low, 0, 0)), panel.y(Vec3(0, 0, scene.ground)));
      views += text("L%.1f %.1f", panel.x(camera.centre), panel.y(camera.centre));
      views += text("L%.1f %.1f", panel.x(Vec3(seen.high, 0, 0)), panel.y(Vec3(0, 0, scene.ground)));
    }
    track += text(track.empty() ? "M%.1f %.1f" : "L%.1f %.1f", panel.x(camera.centre), panel.y(camera.centre));
  }
  out << "<path class=\"v\" d=\"" << views << "\"/>\n<path class=\"t\" d=\"" << track << "\"/>\n";
  for (const PosedCamera& camera : scene.cameras) {
    out << text("<circle class=\"c\" cx=\"%.1f\" cy=\"%.1f\" r=\"2.5\"/>", panel.x(camera.centre),
                panel.y(camera.centre))
        << text("<circle class=\"r\" cx=\"%.1f\" cy=\"%.1f\" r=\"6\"/>\n", panel.x(camera.reference),
                panel.y(camera.reference));
  }
}

void draw_scale(const Panel& panel, double bottom, std::ostream& out) {
  const double metres = 10, length = metres * panel.px_per_unit;
  out << text("<path class=\"t\" d=\"M%.1f %.1f", margin_px, bottom) << text("h%.1f\"/>", length, 0)
      << text("<text x=\"%.1f\" y=\"%.1f\">10 m</text>\n", margin_px + length + 8, bottom + 4);
}

void draw(const Scene& scene, std::ostream& out) {
  Range along, across, up;
  for (const PosedCamera& camera : scene.cameras) {
    for (const Vec3& corner : camera.corners) {
      along.take(corner.x());
      across.take(corner.y());
    }
    up.take(camera.centre.z());
  }
  std::vector<double> heights;
  for (const Vec3& point : scene.points) heights.push_back(point.z());
  up.take(*std::min_element(heights.begin(), heights.end()));
  const double scale = (width_px - 2 * margin_px) / along.size();
  const Panel side{scale, along.low, up.high, margin_px, 2};
  const Panel plan{scale, along.low, across.high, margin_px + up.size() * scale + gap_px + margin_px, 1};
  const double height = plan.top + across.size() * scale + margin_px;
  out << text("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %.0f %.0f\" ", width_px, height)
      << "font-family=\"sans-serif\" font-size=\"13\">\n"
         "<style>.p{stroke-width:1.6;stroke-linecap:round;fill:none}.v{fill:none;stroke:#888;stroke-width:.7}"
         ".t{fill:none;stroke:#222;stroke-width:1.6}.c{fill:#222}.r{fill:none;stroke:#c0182b;stroke-width:1.3}"
         "</style>\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n";
  out << text("<text x=\"%.0f\" y=\"%.0f\">", margin_px, 24) << "From the side: " << scene.cameras.size()
      << " cameras (dots; rings: reference), " << scene.points.size() << " points, coloured by height</text>\n";
  out << text("<text x=\"%.0f\" y=\"%.0f\">From above: the outline of every image on the ground</text>\n", margin_px,
              plan.top - 14);
  for (const Panel& panel : {side, plan}) {
    draw_points(scene, panel, out);
    draw_cameras(scene, panel, out);
  }
  draw_scale(plan, height - 18, out);
  out << "</svg>\n";
}

}  // namespace
}  // namespace ilp

int main(int argc, char** argv) {
  if (argc != 4) {
    std::cerr << ilp::usage;
    return 2;
  }
  try {
    const ilp::Scene scene =
        ilp::make_scene(ilp::lab::read_colmap_model(argv[1]), ilp::host::read_reference_cameras(argv[2]));
    std::ofstream out(argv[3]);
    ilp::draw(scene, out);
    out.flush();
    if (!out) throw std::runtime_error(std::string("cannot write ") + argv[3]);
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "strip-picture: " << error.what() << "\n";
    return 1;
  }
}
