// Where the images of a simulated flight come from: a rendered world, a folder, or a video stream.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "fsw/base/geometry.hpp"
#include "hal/camera/camera.hpp"

namespace ilp::sim {

struct SourceOptions {
  std::string images;
  std::string y4m;
  std::string camera;
  std::string out;
  std::uint64_t seed = 1;
  int max_frames = 0;  ///< 0: the flight's own length
  bool resume = false;
};

/// A camera with its intrinsics, and how many frames it will give (0: unknown).
class ImageSource {
 public:
  ImageSource() = default;
  ImageSource(const ImageSource&) = delete;
  ImageSource& operator=(const ImageSource&) = delete;
  virtual ~ImageSource() = default;
  virtual Camera& camera() = 0;

  CameraModel model;
  std::size_t frames = 0;
  std::string description;
};

/// Renders the default world when no source is named. std::runtime_error says what is wrong and what was expected.
std::unique_ptr<ImageSource> open_source(const SourceOptions& options);

}  // namespace ilp::sim
