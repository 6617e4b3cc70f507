#include "sim/sil/image_source.hpp"

#include <fcntl.h>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <optional>
#include <sstream>
#include <stdexcept>

#include "fsw/base/status_values.hpp"
#include "fsw/vision/geometry/camera.hpp"
#include "hal/camera/directory/directory_camera.hpp"
#include "hal/camera/y4m/y4m_camera.hpp"
#include "sim/host/camera_file.hpp"
#include "sim/host/image_io.hpp"
#include "sim/host/photograph.hpp"
#include "sim/host/progress.hpp"
#include "sim/host/status_error.hpp"
#include "sim/host/strip.hpp"
#include "sim/host/text_format.hpp"
#include "sim/host/wrong_usage.hpp"
#include "sim/sil/flyable_images.hpp"
#include "sim/sil/navigation_input.hpp"
#include "sim/sil/nominal_camera.hpp"
#include "sim/sil/world_camera.hpp"
#include "sim/world/flight.hpp"
#include "sim/world/render_flight.hpp"

namespace ilp::sil {
namespace fs = std::filesystem;
namespace {

/// The camera as it is given to the flight software.
CameraModel simulated_camera(const SourceOptions& options) {
  const CameraModel& truth = options.scenario.flight.camera;
  return options.camera_known ? world::given_camera(truth, options.scenario.given, options.seed)
                              : nominal_camera(truth, options.seed);
}

/// The flight's event about an image that cannot be read has no name in it.
Status decode_and_report(const char* path, FrameImage& image) {
  const Status status = host::decode_image(path, image);
  if (!status.ok()) std::cerr << "\nilp-sil: image " << path << " is left out: " << host::describe(status) << "\n";
  return status;
}

class StripSource final : public ImageSource {
 public:
  StripSource(const fs::path& index, const CameraModel& camera_model, bool known, std::size_t count, std::string text) {
    model = camera_model;
    camera_known = known;
    frames = count;
    description = std::move(text);
    host::require(camera_.open(index.c_str(), model.width, model.height, decode_and_report),
                  "opening " + index.string());
  }
  Camera& camera() override { return camera_; }

 private:
  DirectoryCamera camera_;
};

class WorldSource final : public ImageSource {
 public:
  explicit WorldSource(const SourceOptions& options)
      : camera_(options.scenario, fs::path(options.out) / "flight",
                {.resume = options.resume, .as_time_passes = options.real_time, .unasked = !options.triggered}),
        threads_(options.threads) {
    model = simulated_camera(options);
    if (options.real_time || !options.triggered) frames = world::Trajectory(options.scenario.flight).exposures().size();
    camera_known = options.camera_known;
  }
  Camera& camera() override { return camera_; }
  void finish() override { camera_.finish(threads_); }

 private:
  WorldCamera camera_;
  std::size_t threads_;
};

/// Why a header is refused, and what to do.
std::string refusal_of(const Y4mCamera& camera, const Status& status, const std::string& file) {
  const std::string convert = ": convert it, for example with ffmpeg -i " + (file == "-" ? "VIDEO" : file) +
                              " -pix_fmt gray -f yuv4mpegpipe - | ilp-sil --y4m - ...";
  const bool refused = status.is(StatusCode::unsupported_format);
  if (refused && camera.bits_per_sample() != 8)
    return "has " + std::to_string(camera.bits_per_sample()) + " bits per sample, 8 expected" + convert;
  if (refused && static_cast<FormatFault>(status.a) == FormatFault::y4m_rate)
    return "states no frame rate: give it with --frame-rate, in frames per second";
  if (refused) return "has a chroma sampling that is not known" + convert;
  if (status.is(StatusCode::image_too_large))
    return "has pictures of " + host::size_text(status.a, status.b) + " pixels, which are too large" + convert;
  return "is no YUV4MPEG2 stream" + convert;
}

class VideoSource final : public ImageSource {
 public:
  /// Without a camera: one with this field of view.
  VideoSource(const SourceOptions& options, const std::optional<CameraModel>& given, std::ostream& messages) {
    const std::string& file = options.y4m;
    description = file == "-" ? "video on standard input" : file;
    descriptor_ = file == "-" ? STDIN_FILENO : open(file.c_str(), O_RDONLY | O_CLOEXEC);
    if (descriptor_ < 0)
      throw std::runtime_error("video " + file + " cannot be read: " + std::strerror(errno) + "; check the path");
    constexpr double millihertz = 1000;
    const Y4mArrival arrival{.live = false,
                             .rate = {std::llround(options.frame_rate_hz * millihertz), std::llround(millihertz)}};
    const Status opened = camera_.open(descriptor_, arrival);
    if (!opened.ok()) throw std::runtime_error("video " + file + " " + refusal_of(camera_, opened, file));
    if (camera_.interlaced())
      messages << "video " << file << " is interlaced: every second line is of another time, and what moves is torn; "
               << "take one field, for example with ffmpeg -vf bwdif\n";
    if (camera_.pixels_are_wide())
      messages << "video " << file << " has pixels that are no squares"
               << (given ? ": the camera file must have two focal lengths that say so\n"
                         : ": without a camera file they are taken as squares; scale it, for example with ffmpeg "
                           "-vf scale=iw*sar:ih,setsar=1\n");
    model = given
                ? host::camera_for_size(*given, camera_.width(), camera_.height(), "video " + file + " has", std::cerr)
                : camera_of_field(camera_.width(), camera_.height(), options.field_of_view_rad);
    camera_known = options.camera_known && given;
  }
  ~VideoSource() override {
    if (descriptor_ > STDIN_FILENO) close(descriptor_);
  }
  Camera& camera() override { return camera_; }
  [[nodiscard]] std::string fault() const override {
    const Status broken = camera_.broken();
    if (broken.ok()) return {};
    return description + (broken.is(StatusCode::truncated)
                              ? " is cut off inside a frame"
                              : " breaks off: no frame begins where its header says (size, sampling or a damage)");
  }

 private:
  int descriptor_ = -1;
  Y4mCamera camera_;
};

/// Tells what makes the camera improbable by itself.
CameraModel read_camera(const fs::path& file) {
  const CameraModel camera = host::read_camera_file(file);
  const CameraSuspicion suspicion = suspicion_about(camera);
  if (suspicion != CameraSuspicion::none)
    std::cerr << "ilp-sil: the camera is improbable: " << words_of(suspicion) << "\n";
  return camera;
}

/// The intrinsics that are named, or those that a strip brings along.
std::optional<CameraModel> camera_for(const SourceOptions& options, const fs::path& beside) {
  if (!options.camera.empty()) return read_camera(options.camera);
  for (const fs::path& place : {beside / "colmap" / "cameras.txt", beside.parent_path() / "colmap" / "cameras.txt"}) {
    if (!beside.empty() && fs::exists(place)) return read_camera(place);
  }
  return std::nullopt;
}

struct ImageSize {
  fs::path file;
  std::int32_t width = 0, height = 0;
};

/// Size of the first image that can be read; the flight itself reports a damaged one.
std::optional<ImageSize> size_of_images(const std::vector<host::StripFrame>& strip) {
  for (const host::StripFrame& frame : strip) {
    try {
      const host::Raster<std::uint8_t> image = host::read_gray(frame.file);
      return ImageSize{frame.file, image.width, image.height};
    } catch (const std::exception&) {
      continue;
    }
  }
  return std::nullopt;
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

/// Tells where the given camera is not what EXIF states.
void compare_with_exif(const CameraModel& camera, const std::optional<double>& field_of_view_rad) {
  if (!field_of_view_rad) return;
  constexpr double most_apart = 0.2;
  const double stated = camera_of_field(camera.width, camera.height, *field_of_view_rad).fx;
  if (std::fabs(camera.fx / stated - 1) <= most_apart) return;
  std::cerr << "ilp-sil: the camera is improbable: its focal length is " << host::brief(camera.fx)
            << " px, EXIF states " << host::brief(stated) << " px: is it that of another lens, zoom or size?\n";
}

std::string navigation_of(const SourceOptions& options, const std::vector<host::StripFrame>& strip,
                          const std::optional<StripEpoch>& epoch, std::ostream& messages) {
  const fs::path made = fs::path(options.out) / "navigation.csv";
  return prepare_navigation(options.navigation, strip, epoch, made, messages).string();
}

std::unique_ptr<ImageSource> open_strip(const SourceOptions& options, std::ostream& messages) {
  const fs::path folder = fs::path(options.images) / "";
  const std::vector<host::StripFrame> source = host::list_strip(folder.parent_path());
  std::optional<CameraModel> given = camera_for(options, folder.parent_path());
  const auto of_camera = given ? std::optional(host::ImageSize{given->width, given->height}) : std::nullopt;
  const FlyableImages flyable = make_flyable(source, fs::path(options.out) / "images", messages, of_camera);
  const std::vector<host::StripFrame>& strip = flyable.frames;
  // An assumed attitude would be evidence about an unknown camera that there is not.
  const fs::path places = fs::path(options.out) / "exif-positions.csv";
  const PlaceOptions how{.sigma_m = options.exif_sigma_m,
                         .looks_down = given && options.camera_known && !options.exif_oblique};
  const bool placed =
      options.navigation.empty() && options.exif_sigma_m > 0 && write_places(flyable, how, places, messages);
  // The camera file is that of the photographs as they came, or of those that fly.
  if (given && flyable.binning > 1 && of_camera == flyable.source) given = binned_camera(*given, flyable.binning);
  const std::optional<ImageSize> size = size_of_images(strip);
  if (given && size) {
    given = host::camera_for_size(*given, size->width, size->height, size->file.string() + " has", std::cerr);
  }
  if (given) compare_with_exif(*given, flyable.field_of_view_rad);
  // A camera of larger images stays as it is where none is reduced.
  if (strip.empty() || (!size && (!given || !validate(*given).ok()))) {
    throw std::runtime_error("none of the images in " + folder.parent_path().string() +
                             " can be read: what was left out is named above. PNG, PGM, JPEG or TIFF with 8 or 16 bits "
                             "are read; what only the flight can read needs --camera cameras.txt");
  }
  if (!given && flyable.field_of_view_rad) messages << "the field of view is the one that EXIF states\n";
  const CameraModel camera =
      given ? *given
            : camera_of_field(size->width, size->height, flyable.field_of_view_rad.value_or(options.field_of_view_rad));
  for (const std::string& warning : host::strip_warnings(strip, source.front().file.parent_path()))
    messages << warning << "\n";
  const fs::path index = fs::path(options.out) / "frames.txt";
  host::write_strip_index(index, strip);
  auto opened = std::make_unique<StripSource>(index, camera, options.camera_known && given, strip.size(),
                                              folder.parent_path().string());
  opened->binning = flyable.binning;
  // The focal length for film is rounded, and some makers state that of the sensor, some that of the picture.
  constexpr double exif_focal_sigma = 0.04;
  if (!given && flyable.field_of_view_rad)
    opened->field_of_view_sigma_rad = exif_focal_sigma * std::sin(*flyable.field_of_view_rad);
  if (placed) {
    opened->navigation = places.string();
    opened->body = Body::earth;
  }
  if (!options.navigation.empty()) opened->navigation = navigation_of(options, strip, flyable.epoch, messages);
  return opened;
}

std::unique_ptr<ImageSource> open_simulation(const SourceOptions& options) {
  const world::Scenario& scenario = options.scenario;
  const std::string description =
      "simulated world, scenario " + scenario.name + ", seed " + std::to_string(scenario.world.seed);
  if (options.triggered || options.real_time || options.sets_exposure) {
    auto source = std::make_unique<WorldSource>(options);
    source->description = description + (options.real_time   ? ", rendered as time passes"
                                         : options.triggered ? ", triggered camera"
                                                             : ", exposed as the flight says");
    return source;
  }
  if (!options.resume) render_scenario(options);
  return std::make_unique<StripSource>(fs::path(options.out) / "flight" / "index.txt", simulated_camera(options),
                                       options.camera_known, world::Trajectory(scenario.flight).exposures().size(),
                                       description);
}

}  // namespace

void render_scenario(const SourceOptions& options) {
  std::cerr << "Rendering the scenario " << options.scenario.name << "\n";
  host::Progress progress(std::cerr, "Rendering, frame");
  const auto show = [&](int done, int total) {
    progress(static_cast<std::size_t>(done), static_cast<std::size_t>(total));
  };
  world::render_flight(fs::path(options.out) / "flight", options.scenario, show, options.threads);
}

namespace {

std::unique_ptr<ImageSource> open_images(const SourceOptions& options, std::ostream& messages) {
  if (!options.images.empty() && !options.y4m.empty())
    throw host::WrongUsage("--images and --y4m exclude each other: give one");
  if (!options.images.empty()) return open_strip(options, messages);
  if (!options.y4m.empty()) return std::make_unique<VideoSource>(options, camera_for(options, {}), messages);
  return open_simulation(options);
}

}  // namespace

std::unique_ptr<ImageSource> open_source(const SourceOptions& options) {
  std::ostringstream messages;
  const auto report = [&messages] {
    for (const std::string& line : lines_of(messages.str())) std::cerr << "ilp-sil: " << line << "\n";
  };
  std::unique_ptr<ImageSource> source;
  try {
    source = open_images(options, messages);
    if (!options.navigation.empty() && options.images.empty())
      source->navigation = navigation_of(options, {}, {}, messages);
  } catch (...) {
    // What was said explains what is refused.
    report();
    throw;
  }
  report();
  source->notes = lines_of(messages.str());
  const fs::path simulated = fs::path(options.out) / "flight" / "navigation.csv";
  const bool recorded = !options.images.empty() || !options.y4m.empty();
  if (!recorded && options.navigation.empty() && fs::exists(simulated)) {
    source->navigation = simulated.string();
    source->body = world::body_of(options.scenario.navigation);
  }
  return source;
}

}  // namespace ilp::sil
