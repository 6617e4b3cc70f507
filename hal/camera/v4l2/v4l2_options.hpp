// Settings of the V4L2 camera, and their text on the command line.
#pragma once

#include <cstdint>

#include "cfg/limits.hpp"
#include "fsw/base/status.hpp"
#include "fsw/base/time.hpp"
#include "hal/camera/v4l2/pixel_format.hpp"

namespace ilp {

struct V4l2Options {
  /// The driver's present setting is not changed.
  static constexpr std::int64_t as_it_is = -1;

  char device[limits::max_path_bytes] = {};  ///< path of the device
  const PixelFormat* format = nullptr;  ///< the null pointer: the first of pixel_formats() that the camera supports
  std::int64_t rate_mhz = as_it_is;     ///< frame rate, mHz
  std::int64_t input = as_it_is;        ///< number of the input of a device with several
  std::int64_t exposure_us = as_it_is;
  std::int64_t gain = as_it_is;  ///< in the driver's own steps
  /// Driver's gain steps that raise the amplification by 1, where the least gain is amplification 1. For exposure
  /// control.
  std::int64_t gain_unit = 16;
  /// Time from the start of exposure to the driver's stamp. as_it_is: 0 for stamps at the start of exposure, a frame
  /// period for stamps at the end of the frame.
  std::int64_t stamp_delay_us = as_it_is;
};

/// Parses `DEVICE[,format=NAME][,rate=HZ][,input=N][,exposure_us=N][,gain=N][,gain_unit=N][,stamp_delay_us=N]`. Returns
/// `parse_error` (first value: offset in `text` at which parsing failed) for other text, and `capacity_exceeded` if the
/// device's path is too long.
Status parse_v4l2_options(const char* text, V4l2Options& options);

}  // namespace ilp
