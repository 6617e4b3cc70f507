// Sets controls of vivid, the kernel's test camera, by name, because no header has their numbers.
#pragma once

#include <linux/videodev2.h>
#include <sys/ioctl.h>

#include <cerrno>
#include <cstdint>
#include <cstring>

namespace board {

/// Sets the control of a video device that has this name. Returns false and sets errno on failure; ENOENT means that
/// there is no such control.
inline bool set_control(int device, const char* name, std::int32_t value) {
  v4l2_queryctrl query{};
  query.id = V4L2_CTRL_FLAG_NEXT_CTRL;
  while (ioctl(device, VIDIOC_QUERYCTRL, &query) == 0) {
    if (std::strcmp(reinterpret_cast<const char*>(query.name), name) == 0) {
      v4l2_control control{query.id, value};
      return ioctl(device, VIDIOC_S_CTRL, &control) == 0;
    }
    query.id |= V4L2_CTRL_FLAG_NEXT_CTRL;
  }
  errno = ENOENT;
  return false;
}

}  // namespace board
