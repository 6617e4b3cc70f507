// Opens a YUV4MPEG2 stream for the flight.
#pragma once

#include "hal/camera/y4m/y4m_camera.hpp"

namespace ilp {

/// Opens a file, or standard input for `-`. In real time everything but a plain file is live (Y4mArrival). The
/// descriptor stays open until the program ends. Statuses as of Y4mCamera::open(); `io_error`.
Status open_video_stream(const char* file, bool real_time, Y4mCamera& camera);

}  // namespace ilp
