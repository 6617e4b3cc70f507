#include "sim/ground/export/strip_exports.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

#include "sim/ground/export/footprint.hpp"
#include "sim/ground/export/gltf_writer.hpp"
#include "sim/ground/export/point_cloud.hpp"
#include "sim/ground/export/raster_export.hpp"
#include "sim/ground/export/track_export.hpp"
#include "sim/ground/intake/keyframe_rasters.hpp"
#include "sim/ground/map/grid_surface.hpp"
#include "sim/host/files.hpp"
#include "sim/host/image_io.hpp"
#include "sim/host/picture.hpp"

namespace ilp::exports {
namespace fs = std::filesystem;
namespace {

/// Points come sorted by keyframe, so the cached image is mostly the one that is needed.
class GreyReader {
 public:
  explicit GreyReader(const intake::Flight& flight) : flight_(flight) {}
  std::optional<std::uint8_t> operator()(std::int64_t id, double x, double y) {
    if (id != at_) {
      const auto keyframe = flight_.keyframes.find(id);
      image_ = keyframe == flight_.keyframes.end() ? host::Raster<std::uint8_t>()
                                                   : intake::decode_products(keyframe->second).rasters.image;
      at_ = id;
    }
    const double column = std::floor(x + 0.5), row = std::floor(y + 0.5);
    if (!(column >= 0) || !(row >= 0) || column >= image_.width || row >= image_.height) return std::nullopt;
    return image_.at(static_cast<std::int32_t>(column), static_cast<std::int32_t>(row));
  }

 private:
  const intake::Flight& flight_;
  std::int64_t at_ = 0;
  host::Raster<std::uint8_t> image_;
};

/// As the other files have it: in map coordinates.
map::SurfaceMesh on_the_map(map::SurfaceMesh mesh, const Georeference& place) {
  for (map::SurfaceVertex& vertex : mesh.vertices) {
    const Vec3 point = place.map_from_world(Vec3(vertex.x, vertex.y, vertex.z));
    vertex.x = static_cast<float>(point.x());
    vertex.y = static_cast<float>(point.y());
    vertex.z = static_cast<float>(point.z());
    vertex.sigma *= static_cast<float>(place.scale);
  }
  return mesh;
}

void export_surface(const map::Mosaic& mosaic, const Georeference& place, std::size_t max_vertices,
                    const fs::path& folder, ExportedStrip& strip) {
  strip.stride = map::stride_for(*strip.grid, max_vertices);
  const map::SurfaceMesh mesh = map::grid_surface(*strip.grid, strip.stride, {});
  strip.vertices = mesh.vertices.size();
  strip.faces = mesh.faces.size();
  const std::string name = "model" + strip.suffix;
  const std::string comment = "strip " + std::to_string(strip.strip.id) + ", unit: " + place.unit;
  host::update_file(folder / (name + ".ply"), ply_bytes(on_the_map(mesh, place), comment));
  strip.map_files.push_back(name + ".ply");
  if (mesh.faces.empty()) return;
  constexpr std::int32_t texture_side_px = 4096;
  const host::Raster<std::uint8_t> texture = read_ortho(folder / ("ortho" + strip.suffix + ".tif"), texture_side_px);
  host::update_file(folder / (name + ".glb"),
                    [&](std::ostream& out) { write_gltf(mesh, mosaic.geometry, texture, place, out); });
  strip.map_files.push_back(name + ".glb");
}

void export_points(const intake::Flight& flight, const Georeference& place, const fs::path& folder,
                   ExportedStrip& strip) {
  GreyReader grey(flight);
  const std::vector<std::uint8_t> points = point_cloud_ply(flight, strip.strip, place, std::ref(grey));
  if (points.empty()) return;
  const std::string name = "points" + strip.suffix + ".ply";
  host::update_file(folder / name, points);
  strip.files.push_back(name);
}

void export_footprints(const intake::Flight& flight, const Georeference& place, const fs::path& folder,
                       ExportedStrip& strip) {
  std::map<std::int64_t, std::vector<Vec3>> outlines;
  for (const std::int64_t id : strip.strip.keyframes) {
    std::vector<Vec3> outline = footprint_of(flight.keyframes.at(id), strip);
    if (!outline.empty()) outlines[id] = std::move(outline);
  }
  if (write_footprints(flight, strip.strip, outlines, place, strip.suffix, folder)) {
    strip.files.push_back("footprints" + strip.suffix + ".geojson");
  }
}

double relief_at(const ExportedStrip& strip, double x, double y) {
  const map::GroundGrid& grid = *strip.grid;
  const double column = std::floor(grid.column_of(x) + 0.5), row = std::floor(grid.row_of(y) + 0.5);
  if (!(column >= 0) || !(row >= 0) || column >= grid.height.width || row >= grid.height.height) return 0;
  const float z = grid.height.at(static_cast<std::int32_t>(column), static_cast<std::int32_t>(row));
  return std::isfinite(z) ? z - strip.plane.at(x, y) : 0;
}

constexpr float nothing = std::numeric_limits<float>::infinity();

host::Raster<float> depth_of(const host::Raster<float>& inverse) {
  host::Raster<float> depth(inverse.width, inverse.height, nothing);
  for (std::size_t i = 0; i < inverse.samples.size(); ++i) {
    if (inverse.samples[i] > 0) depth.samples[i] = 1 / inverse.samples[i];
  }
  return depth;
}

// North-up: cell centres, rows downwards.
std::string world_file(const map::GroundGrid& grid) {
  std::array<char, 160> text{};
  std::snprintf(text.data(), text.size(), "%.12g\n0\n0\n%.12g\n%.12g\n%.12g\n", grid.cell, -grid.cell, grid.x0,
                grid.y0);
  return text.data();
}

void write_map(host::Raster<float> map, const std::filesystem::path& path) {
  for (float& value : map.samples) {
    if (!std::isfinite(value)) value = nothing;
  }
  host::update_file(path, host::pfm_bytes(map.view()));
}

}  // namespace

std::vector<Vec3> footprint_of(const intake::Keyframe& keyframe, const ExportedStrip& strip) {
  if (!strip.grid || !keyframe.posed()) return {};
  const auto relief = [&](double x, double y) { return relief_at(strip, x, y); };
  return footprint(keyframe.camera, pose_of(*keyframe.pose), strip.plane, relief);
}

void export_track(const intake::Flight& flight, const Georeference& place, const fs::path& folder,
                  ExportedStrip& strip) {
  strip.georeference = place;
  strip.place = place.sentence;
  if (write_track(flight, strip.strip, place, strip.suffix, folder)) {
    strip.files.push_back("track" + strip.suffix + ".geojson");
  }
}

void export_map(const map::Mosaic& mosaic, const Georeference& place, std::size_t max_vertices, const fs::path& folder,
                intake::ResultCache* kept, ExportedStrip& strip) {
  strip.map_files = write_rasters(mosaic, place, strip.suffix, folder, kept);
  export_surface(mosaic, place, max_vertices, folder, strip);
  strip.files.insert(strip.files.end(), strip.map_files.begin(), strip.map_files.end());
}

void export_points_and_footprints(const intake::Flight& flight, const Georeference& place, const fs::path& folder,
                                  ExportedStrip& strip) {
  export_points(flight, place, folder, strip);
  export_footprints(flight, place, folder, strip);
}

void export_keyframe(std::int64_t id, const intake::KeyframeRasters& rasters, const std::filesystem::path& folder) {
  const std::string base = host::six_digits(id);
  if (!rasters.image.empty()) host::update_file(folder / (base + "-image.png"), host::png_bytes(rasters.image));
  if (!rasters.mask.empty()) host::update_file(folder / (base + "-mask.png"), host::png_bytes(rasters.mask));
  if (rasters.inverse_depth.empty()) return;
  const host::Raster<float> depth = depth_of(rasters.inverse_depth);
  host::update_file(folder / (base + "-depth.png"),
                    host::png_bytes(host::colour_mapped(depth, host::display_range(depth))));
  host::update_file(folder / (base + "-depth.pfm"), host::pfm_bytes(depth.view()));
}

bool keyframe_is_exported(const intake::Keyframe& keyframe, const std::filesystem::path& folder) {
  const std::string base = host::six_digits(keyframe.id);
  const auto there = [&](const char* suffix) {
    std::error_code error;
    return std::filesystem::exists(folder / (base + suffix), error);
  };
  if (keyframe.has_image() && !there("-image.png")) return false;
  if (keyframe.has_mask() && !there("-mask.png")) return false;
  return !keyframe.has_depth() || (there("-depth.png") && there("-depth.pfm"));
}

void export_grid(const map::GroundGrid& grid, const std::string& suffix, const std::filesystem::path& folder) {
  write_map(grid.height, folder / ("height" + suffix + ".pfm"));
  write_map(grid.estimated_sigma(), folder / ("sigma" + suffix + ".pfm"));
  host::Raster<std::uint8_t> ortho = grid.ortho;
  for (std::size_t i = 0; i < ortho.samples.size(); ++i) {
    if (grid.source.samples[i] != 0) ortho.samples[i] = std::max<std::uint8_t>(ortho.samples[i], 1);
  }
  host::update_file(folder / ("ortho" + suffix + ".png"), host::png_bytes_where_seen(ortho));
  host::update_file(folder / ("ortho" + suffix + ".pgw"), world_file(grid));
  host::Raster<std::uint8_t> count(grid.count.width, grid.count.height);
  for (std::size_t i = 0; i < count.samples.size(); ++i) {
    count.samples[i] = static_cast<std::uint8_t>(std::min<int>(grid.count.samples[i], 255));
  }
  host::update_file(folder / ("count" + suffix + ".png"), host::png_bytes(count));
}

}  // namespace ilp::exports
