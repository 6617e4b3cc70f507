// Where ilp-onboard gets its images from: a camera, and what it needs before the flight.
#pragma once

#include <cstdint>

#include "hal/camera/camera.hpp"
#include "hal/clock/real_clock.hpp"

namespace ilp {

/// How the command line names a kind of source.
struct ImageSourceKind {
  const char* option;
  const char* value;  ///< of the option, in the usage
  const char* help;   ///< of the option: whole lines
  bool needs_real_time;
};

struct ImageSourceContext {
  RealClock& clock;
  bool real_time;
};

/// Each class of sources has its `kind` and a constructor from an ImageSourceContext, and is in the list of
/// image_sources.hpp. `value` is that of its option.
class ImageSource {
 public:
  ImageSource() = default;
  ImageSource(const ImageSource&) = delete;
  ImageSource& operator=(const ImageSource&) = delete;

  /// The size of its pictures, px; a fault if they do not say it.
  virtual Status find_size(const char* value, std::int32_t& width, std::int32_t& height) = 0;
  /// Opens the source for pictures of this size. `image_size_changed` (a, b = size) if they have another one.
  virtual Status open(const char* value, std::int32_t width, std::int32_t height) = 0;
  [[nodiscard]] virtual Camera& camera() = 0;
  /// Mission time was set.
  virtual void follow_clock() {}

 protected:
  ~ImageSource() = default;
};

}  // namespace ilp
