// The requested settings of the video device.
#pragma once

#include <cstdint>

#include "cfg/limits.hpp"
#include "fsw/base/status.hpp"
#include "fsw/base/time.hpp"
#include "hal/camera/v4l2/pixel_format.hpp"

namespace ilp {

struct V4l2Options {
  static constexpr std::int64_t as_it_is = -1;

  char device[limits::max_path_bytes] = {};
  const PixelFormat* format = nullptr;  ///< the null pointer: the first of pixel_formats() that the camera supports
  std::int64_t rate_mhz = as_it_is;     ///< frames in 1000 s
  std::int64_t input = as_it_is;        ///< input of a device with several
  std::int64_t exposure_us = as_it_is;
  std::int64_t gain = as_it_is;  ///< in the driver's own steps
  /// Steps of the driver's gain that add once the sensor's own amplification; for exposure control.
  std::int64_t gain_unit = 16;
  /// From the start of exposure to the driver's stamp. as_it_is: 0 for stamps at the start of exposure, a whole frame
  /// period for stamps at the end of the frame.
  std::int64_t stamp_delay_us = as_it_is;
};

/// Parses `DEVICE[,format=NAME][,rate=HZ][,input=N][,exposure_us=N][,gain=N][,gain_unit=N][,stamp_delay_us=N]`.
/// `parse_error`, a = position of the first malformed option; `capacity_exceeded` for a path that is too long.
Status parse_v4l2_options(const char* text, V4l2Options& options);

}  // namespace ilp
