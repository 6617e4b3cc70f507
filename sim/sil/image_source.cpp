#include "sim/sil/image_source.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iostream>
#include <stdexcept>

#include "hal/camera/directory/directory_camera.hpp"
#include "hal/camera/y4m/y4m_camera.hpp"
#include "sim/io/colmap_camera.hpp"
#include "sim/io/image_io.hpp"
#include "sim/io/status_error.hpp"
#include "sim/io/strip.hpp"
#include "sim/sil/world_camera.hpp"
#include "sim/world/flight.hpp"
#include "sim/world/render_flight.hpp"

namespace ilp::sim {
namespace fs = std::filesystem;
namespace {

class StripSource final : public ImageSource {
 public:
  StripSource(const fs::path& index, const CameraModel& camera_model, std::size_t count, std::string text) {
    model = camera_model;
    frames = count;
    description = std::move(text);
    require(camera_.open(index.c_str(), model.width, model.height, decode_image), "opening " + index.string());
  }
  Camera& camera() override { return camera_; }

 private:
  DirectoryCamera camera_;
};

class WorldSource final : public ImageSource {
 public:
  explicit WorldSource(const SourceOptions& options)
      : camera_(options.scenario, fs::path(options.out) / "flight", options.resume), threads_(options.threads) {
    model = options.scenario.flight.camera;
  }
  Camera& camera() override { return camera_; }
  void finish() override { camera_.finish(threads_); }

 private:
  WorldCamera camera_;
  std::size_t threads_;
};

class VideoSource final : public ImageSource {
 public:
  VideoSource(const std::string& file, const CameraModel& camera_model) {
    model = camera_model;
    description = file == "-" ? "video on standard input" : file;
    descriptor_ = file == "-" ? STDIN_FILENO : open(file.c_str(), O_RDONLY | O_CLOEXEC);
    if (descriptor_ < 0) throw std::runtime_error("video " + file + " cannot be read");
    require(camera_.open(descriptor_), "video " + file);
    if (camera_.width() != model.width || camera_.height() != model.height) {
      throw std::runtime_error("video " + file + " has " + std::to_string(camera_.width()) + "x" +
                               std::to_string(camera_.height()) + " pixels, the camera file says " +
                               std::to_string(model.width) + "x" + std::to_string(model.height));
    }
  }
  ~VideoSource() override {
    if (descriptor_ > STDIN_FILENO) close(descriptor_);
  }
  Camera& camera() override { return camera_; }

 private:
  int descriptor_ = -1;
  Y4mCamera camera_;
};

CameraModel camera_for(const SourceOptions& options, const fs::path& beside) {
  if (!options.camera.empty()) return read_colmap_camera(options.camera);
  // A strip that brings its own camera.
  for (const fs::path& place : {beside / "colmap" / "cameras.txt", beside.parent_path() / "colmap" / "cameras.txt"}) {
    if (!beside.empty() && fs::exists(place)) return read_colmap_camera(place);
  }
  throw std::runtime_error("--camera cameras.txt is needed: the intrinsics in COLMAP's format");
}

void check_sizes(const std::vector<StripFrame>& strip, const CameraModel& camera) {
  for (const StripFrame& frame : strip) {
    Image<std::uint8_t> image;
    try {
      image = read_gray(frame.file);
    } catch (const std::exception&) {
      continue;  // a damaged first frame is the flight's to report
    }
    if (image.width == camera.width && image.height == camera.height) return;
    throw std::runtime_error(frame.file.string() + " has " + std::to_string(image.width) + "x" +
                             std::to_string(image.height) + " pixels, the camera file says " +
                             std::to_string(camera.width) + "x" + std::to_string(camera.height) +
                             ": use the camera file of these images");
  }
}

std::unique_ptr<ImageSource> open_strip(const SourceOptions& options) {
  const fs::path folder = fs::path(options.images) / "";
  const std::vector<StripFrame> strip = list_strip(folder.parent_path());
  const CameraModel camera = camera_for(options, folder.parent_path());
  check_sizes(strip, camera);
  for (const std::string& warning : strip_warnings(strip)) std::cerr << "ilp-sil: " << warning << "\n";
  const fs::path index = fs::path(options.out) / "frames.txt";
  write_strip_index(index, strip);
  return std::make_unique<StripSource>(index, camera, strip.size(), folder.parent_path().string());
}

std::unique_ptr<ImageSource> open_simulation(const SourceOptions& options) {
  const Scenario& scenario = options.scenario;
  const std::string description =
      "simulated world, scenario " + scenario.name + ", seed " + std::to_string(scenario.world.seed);
  if (options.triggered) {
    auto source = std::make_unique<WorldSource>(options);
    source->description = description + ", triggered camera";
    return source;
  }
  if (!options.resume) render_scenario(options);
  return std::make_unique<StripSource>(fs::path(options.out) / "flight" / "index.txt", scenario.flight.camera,
                                       Trajectory(scenario.flight).exposures().size(), description);
}

}  // namespace

void render_scenario(const SourceOptions& options) {
  const bool shown = isatty(STDERR_FILENO) != 0;
  if (!shown) std::cerr << "Rendering the scenario " << options.scenario.name << "\n";
  const auto show = [shown](int done, int total) {
    if (shown)
      std::cerr << "\r\033[Krendering the world: frame " << done << "/" << total << (done == total ? "\n" : "");
  };
  render_flight(fs::path(options.out) / "flight", options.scenario, show, options.threads);
}

std::unique_ptr<ImageSource> open_source(const SourceOptions& options) {
  if (!options.images.empty() && !options.y4m.empty())
    throw std::runtime_error("--images and --y4m exclude each other");
  if (!options.images.empty()) return open_strip(options);
  if (!options.y4m.empty()) return std::make_unique<VideoSource>(options.y4m, camera_for(options, {}));
  return open_simulation(options);
}

}  // namespace ilp::sim
