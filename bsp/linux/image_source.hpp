// Interface of the sources of images of ilp-onboard: a camera, its option on the command line, and how it is opened.
#pragma once

#include <cstdint>

#include "hal/camera/camera.hpp"
#include "hal/clock/real_clock.hpp"

namespace ilp {

/// A kind of source on the command line.
struct ImageSourceKind {
  const char* option;    ///< name of the option, such as --index
  const char* value;     ///< what the usage shows as the option's value
  const char* help;      ///< what the usage says about the option, in complete lines
  bool needs_real_time;  ///< does not work in virtual time
};

struct ImageSourceContext {
  RealClock& clock;
  bool real_time;
};

/// A derived class has a static member `kind` and a constructor from an ImageSourceContext, and is in the list of
/// image_sources.hpp. `value` is the value of its option.
class ImageSource {
 public:
  ImageSource() = default;
  ImageSource(const ImageSource&) = delete;
  ImageSource& operator=(const ImageSource&) = delete;

  /// Reads the size of the source's pictures, px. Returns an error if the source does not state it.
  virtual Status find_size(const char* value, std::int32_t& width, std::int32_t& height) = 0;
  /// Opens the source for pictures of this size, px. Returns `image_size_changed` (first value: width, second: height)
  /// if the source states another size.
  virtual Status open(const char* value, std::int32_t width, std::int32_t height) = 0;
  [[nodiscard]] virtual Camera& camera() = 0;
  /// Called after mission time was set.
  virtual void follow_clock() {}

 protected:
  ~ImageSource() = default;
};

}  // namespace ilp
