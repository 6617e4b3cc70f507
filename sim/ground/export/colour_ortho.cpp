#include "sim/ground/export/colour_ortho.hpp"

#include <cpl_string.h>
#include <gdal_priv.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <ostream>
#include <stdexcept>
#include <vector>

#include "fsw/vision/geometry/camera.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"
#include "sim/host/files.hpp"
#include "sim/host/gdal_session.hpp"
#include "sim/host/photograph.hpp"
#include "sim/host/strip.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::exports {
namespace {
namespace fs = std::filesystem;
using host::Raster;
using host::Rgb;

/// By the name under which they flew.
std::map<std::string, fs::path> photographs_by_name(const fs::path& folder) {
  if (!fs::is_directory(folder)) {
    throw std::runtime_error("--colour " + folder.string() + ": no such folder; name that of the colour photographs");
  }
  std::map<std::string, fs::path> files;
  for (const host::StripFrame& frame : host::list_strip(folder)) {
    files.emplace(host::image_key(frame.file.filename().string()), frame.file);
  }
  return files;
}

double luma(const std::array<double, 3>& colour) {
  return 0.299 * colour[0] + 0.587 * colour[1] + 0.114 * colour[2];
}

/// The mean of the photograph's pixels under a pixel of the image that flew.
std::array<double, 3> colour_at(const Raster<Rgb>& photograph, int binning, double x, double y) {
  const auto left = static_cast<std::int32_t>(std::lround((x + 0.5) * binning - 0.5 * binning));
  const auto top = static_cast<std::int32_t>(std::lround((y + 0.5) * binning - 0.5 * binning));
  std::array<double, 3> sum{};
  for (std::int32_t v = 0; v < binning; ++v) {
    for (std::int32_t u = 0; u < binning; ++u) {
      const Rgb& pixel =
          photograph.at(std::clamp(left + u, 0, photograph.width - 1), std::clamp(top + v, 0, photograph.height - 1));
      sum[0] += pixel.r;
      sum[1] += pixel.g;
      sum[2] += pixel.b;
    }
  }
  for (double& part : sum) part /= binning * binning;
  return sum;
}

/// The colour with the brightness of `grey`; from 1, because 0 says that nothing was seen.
Rgb with_brightness(const std::array<double, 3>& colour, std::uint8_t grey) {
  const double bright = std::max<double>(grey, 1), own = luma(colour);
  const auto part = [&](double value) {
    const double scaled = own >= 1 ? value * bright / own : bright;
    return static_cast<std::uint8_t>(std::clamp(std::lround(scaled), 1L, 255L));
  };
  return {part(colour[0]), part(colour[1]), part(colour[2])};
}

class Painter {
 public:
  Painter(const intake::Flight& flight, const ExportedStrip& strip, const fs::path& folder, std::ostream& messages)
      : flight_(flight), strip_(strip), files_(photographs_by_name(folder)), messages_(messages) {}

  /// Cells of one keyframe after the other, so that one photograph is in memory.
  Raster<Rgb> paint() {
    const map::GroundGrid& grid = *strip_.grid;
    Raster<Rgb> picture(grid.ortho.width, grid.ortho.height);
    std::vector<std::vector<std::size_t>> cells(strip_.strip.keyframes.size() + 1);
    for (std::size_t i = 0; i < grid.source.samples.size(); ++i) {
      if (!std::isfinite(grid.height.samples[i])) continue;
      const std::uint8_t grey = std::max<std::uint8_t>(grid.ortho.samples[i], 1);
      picture.samples[i] = {grey, grey, grey};
      const std::size_t source = grid.source.samples[i];
      if (source < cells.size()) cells[source].push_back(i);
    }
    for (std::size_t k = 1; k < cells.size(); ++k) {
      if (!cells[k].empty()) paint_keyframe(flight_.keyframes.at(strip_.strip.keyframes[k - 1]), cells[k], picture);
    }
    return picture;
  }
  [[nodiscard]] std::size_t used() const { return used_; }
  [[nodiscard]] std::size_t wanted() const { return wanted_; }

 private:
  void paint_keyframe(const intake::Keyframe& keyframe, const std::vector<std::size_t>& cells, Raster<Rgb>& picture) {
    ++wanted_;
    const auto file = files_.find(host::image_key(keyframe.name));
    if (!keyframe.pose || file == files_.end()) return;
    Raster<Rgb> photograph;
    try {
      photograph = host::read_colours(file->second);
    } catch (const std::exception& fault) {
      messages_ << "colours: " << fault.what() << "\n";
      return;
    }
    const CameraModel& camera = keyframe.camera;
    const int binning = std::max(1, photograph.width / std::max(camera.width, 1));
    if (photograph.width / binning != camera.width || photograph.height / binning != camera.height) {
      messages_ << "colours: " << file->second.string() << " has "
                << host::size_text(photograph.width, photograph.height) << " pixels, expected "
                << host::size_text(camera.width, camera.height) << " or a multiple\n";
      return;
    }
    ++used_;
    const Mat3 cam_from_world = rotation_from_quaternion(keyframe.pose->q_cam_from_world);
    const Vec3 centre(keyframe.pose->centre[0], keyframe.pose->centre[1], keyframe.pose->centre[2]);
    const map::GroundGrid& grid = *strip_.grid;
    for (const std::size_t i : cells) {
      const auto columns = static_cast<std::size_t>(grid.ortho.width);
      const double x = grid.x0 + static_cast<double>(i % columns) * grid.cell;
      const double y = grid.y0 - static_cast<double>(i / columns) * grid.cell;
      const Vec3 ray = cam_from_world * (Vec3(x, y, grid.height.samples[i]) - centre);
      if (!(ray.z() > 0)) continue;
      const Vec2 pixel = pixel_from_normalised(camera, Vec2(ray.x() / ray.z(), ray.y() / ray.z()));
      const bool inside = pixel.x() > -1 && pixel.y() > -1 && pixel.x() < camera.width && pixel.y() < camera.height;
      if (!inside) continue;
      picture.samples[i] = with_brightness(colour_at(photograph, binning, pixel.x(), pixel.y()), grid.ortho.samples[i]);
    }
  }

  const intake::Flight& flight_;
  const ExportedStrip& strip_;
  std::map<std::string, fs::path> files_;
  std::ostream& messages_;
  std::size_t used_ = 0, wanted_ = 0;
};

void write_picture(const Raster<Rgb>& picture, const Georeference& place, const map::GroundGrid& grid,
                   const fs::path& file) {
  const host::GdalSession gdal;
  CPLStringList options;
  options.SetNameValue("TILED", "YES");
  options.SetNameValue("COMPRESS", "DEFLATE");
  options.SetNameValue("PREDICTOR", "2");
  options.SetNameValue("PHOTOMETRIC", "RGB");
  const host::Dataset dataset(GetGDALDriverManager()->GetDriverByName("GTiff")->Create(
      file.c_str(), picture.width, picture.height, 3, GDT_Byte, options.List()));
  if (!dataset) throw host::gdal_error("cannot write " + file.string());
  std::array<double, 6> transform = geotransform(place, {grid.x0, grid.y0, grid.cell, picture.width, picture.height});
  const std::string crs = place.raster_crs();
  bool written = dataset->SetGeoTransform(transform.data()) == CE_None &&
                 (crs.empty() || dataset->SetProjection(crs.c_str()) == CE_None);
  std::vector<std::uint8_t> samples(picture.samples.size());
  for (int band = 1; band <= 3 && written; ++band) {
    std::transform(picture.samples.begin(), picture.samples.end(), samples.begin(), [band](const Rgb& c) {
      return band == 1 ? c.r : band == 2 ? c.g : c.b;
    });
    GDALRasterBand* const raster = dataset->GetRasterBand(band);
    written = raster->SetNoDataValue(0) == CE_None &&
              raster->RasterIO(GF_Write, 0, 0, picture.width, picture.height, samples.data(), picture.width,
                               picture.height, GDT_Byte, 0, 0, nullptr) == CE_None;
  }
  CPLErrorReset();
  dataset->FlushCache(false);
  if (!written || CPLGetLastErrorType() == CE_Failure) throw host::gdal_error("cannot write " + file.string());
}

}  // namespace

void write_colour_ortho(const intake::Flight& flight, const Georeference& place, const fs::path& photographs,
                        const fs::path& folder, ExportedStrip& strip, std::ostream& messages) {
  if (!strip.grid) return;
  Painter painter(flight, strip, photographs, messages);
  const Raster<Rgb> picture = painter.paint();
  if (painter.used() == 0) {
    messages << "colours: none of the photographs in " << photographs.string() << " fits a keyframe of strip "
             << strip.strip.id << "; they have the names of the images that flew, and their size or a multiple of it\n";
    return;
  }
  const std::string name = "colour" + strip.suffix + ".tif";
  write_picture(picture, place, *strip.grid, folder / name);
  strip.files.push_back(name);
  if (flight.camera && flight.camera->readout_s != 0)
    messages << "colours: the photographs of a rolling shutter are used as they were read, displaced by some pixels\n";
  messages << "colours of " << painter.used() << " of " << painter.wanted()
           << " keyframes: " << (folder / name).string() << "\n";
}

}  // namespace ilp::exports
