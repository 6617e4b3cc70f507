// Opens the source of images of a simulated flight: a rendered world, a folder, or a video stream.
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
  std::string images;            ///< folder; empty: none
  std::string y4m;               ///< video file; empty: none
  double frame_rate_hz = 0;      ///< of a video whose header states none; 0: not given
  std::string camera;            ///< camera file; empty: none
  std::string navigation;        ///< file of the vehicle's measurements
  double exif_sigma_m = 5;       ///< of EXIF positions without an error; 0: no EXIF positions are used
  bool exif_oblique = false;     ///< images with EXIF positions do not look straight down
  std::string out;               ///< folder of the flight
  world::Scenario scenario;      ///< rendered if neither `images` nor `y4m` is named
  bool triggered = false;        ///< the simulated camera exposes on command, not at the scenario's regular times
  bool real_time = false;        ///< the simulated camera exposes on command and at the regular times, in real time
  bool sets_exposure = false;    ///< the simulated camera renders each image when exposed, with the flight's setting
  bool camera_known = true;      ///< false: the flight gets nominal intrinsics with errors
  std::uint64_t seed = 1;        ///< of these errors
  double field_of_view_rad = 1;  ///< of images without a camera file
  bool resume = false;
  std::size_t threads = 0;  ///< for rendering; 0: one per core
};

/// A camera with its intrinsics and a description for messages.
class ImageSource {
 public:
  ImageSource() = default;
  ImageSource(const ImageSource&) = delete;
  ImageSource& operator=(const ImageSource&) = delete;
  virtual ~ImageSource() = default;
  virtual Camera& camera() = 0;
  /// Called after the flight: writes the remaining files, such as the truth.
  virtual void finish() {}
  /// Called after the flight: why the images ended too early; empty if they did not.
  [[nodiscard]] virtual std::string fault() const { return {}; }

  CameraModel model;
  bool camera_known = true;                       ///< false: `model` is nominal
  std::optional<double> field_of_view_sigma_rad;  ///< of a nominal `model` from EXIF
  std::size_t frames = 0;                         ///< that the camera will give; 0: unknown
  std::string description;
  std::vector<std::string> notes;  ///< messages about images and measurements before the flight
  int binning = 1;                 ///< pixels of the photographs, in x and in y, that become one
  std::string navigation;          ///< file of the vehicle's measurements; empty: none
  Body body = Body::none;          ///< of the positions; none: not known
};

/// Renders the scenario into OUT/flight and reports the progress on standard error.
void render_scenario(const SourceOptions& options);

/// Opens the source that the options name. Without one it renders the scenario first; a resumed flight uses the images
/// of the earlier start. Throws std::runtime_error or std::invalid_argument that says what is wrong and what was
/// expected.
std::unique_ptr<ImageSource> open_source(const SourceOptions& options);

}  // namespace ilp::sil
