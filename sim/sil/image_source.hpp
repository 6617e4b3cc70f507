// Where the images of a simulated flight come from: a rendered world, a folder, or a video stream.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "fsw/base/geometry.hpp"
#include "hal/camera/camera.hpp"
#include "sim/world/scenario.hpp"

namespace ilp::sil {

struct SourceOptions {
  std::string images;
  std::string y4m;
  double frame_rate_hz = 0;  ///< of a video whose header states none; 0: not given
  std::string camera;
  std::string navigation;     ///< file of the vehicle's measurements
  double exif_sigma_m = 5;    ///< of positions in EXIF that state no error; 0: they are not used
  bool exif_oblique = false;  ///< such images do not look straight down
  std::string out;
  world::Scenario scenario;  ///< what is rendered when neither images nor a video are named
  bool triggered = false;    ///< a simulated camera exposes when commanded, not at the scenario's regular times
  bool real_time = false;    ///< a simulated camera exposes when commanded and else at the regular times, as they come
  bool sets_exposure = false;    ///< a simulated camera renders each image when it is exposed, as the flight has set it
  bool camera_known = true;      ///< false: a simulated camera's intrinsics are nominal ones that are off
  std::uint64_t seed = 1;        ///< of how far off they are
  double field_of_view_rad = 1;  ///< of images without a camera file
  bool resume = false;
  std::size_t threads = 0;  ///< that render; 0: as many as the host has
};

/// A camera with its intrinsics, and how many frames it will give (0: unknown).
class ImageSource {
 public:
  ImageSource() = default;
  ImageSource(const ImageSource&) = delete;
  ImageSource& operator=(const ImageSource&) = delete;
  virtual ~ImageSource() = default;
  virtual Camera& camera() = 0;
  /// Writes, after the flight, what the source still has to write.
  virtual void finish() {}
  /// After the flight: what ended the images before their end; empty otherwise.
  [[nodiscard]] virtual std::string fault() const { return {}; }

  CameraModel model;
  bool camera_known = true;  ///< false: the images came without intrinsics, or the options say so; they are nominal
  std::optional<double> field_of_view_sigma_rad;  ///< of nominal intrinsics, where the images state them
  std::size_t frames = 0;
  std::string description;
  std::vector<std::string> notes;  ///< what was said of the images and the measurements before the flight
  int binning = 1;                 ///< so many pixels of the photographs, in x and in y, are one that flies
  std::string navigation;          ///< file of the vehicle's measurements; empty: none
  Body body = Body::none;          ///< of its positions, where the source knows it
};

/// Renders the scenario into OUT/flight, showing its progress on standard error.
void render_scenario(const SourceOptions& options);

/// Renders the scenario first when no source is named, unless it resumes: then the images are there. std::runtime_error
/// or std::invalid_argument says what is wrong and what was expected.
std::unique_ptr<ImageSource> open_source(const SourceOptions& options);

}  // namespace ilp::sil
