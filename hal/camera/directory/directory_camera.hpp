// A recorded strip: images of a folder, delivered at their times.
#pragma once

#include "cfg/limits.hpp"
#include "hal/camera/camera.hpp"
#include "hal/camera/picture/reduction.hpp"
#include "hal/posix/buffered_reader.hpp"

namespace ilp {

/// Reads an image file; host code may add formats.
using DecodeImage = Status (*)(const char* path, FrameImage& image);

/// The index is a text file with a line per frame: `time_ns name [altitude_m]`, `#` begins a comment. Names are
/// absolute or relative to the index. It is read line by line, so that a flight of any length takes the same memory.
class DirectoryCamera final : public Camera {
 public:
  DirectoryCamera() = default;
  ~DirectoryCamera();

  /// Frames of another size than `width` x `height` are refused with `image_size_changed`; 0 accepts any size. Without
  /// `decode`, the files are PGM, and larger ones than the flight's images are reduced (find_reduction).
  Status open(const char* index, std::int32_t width, std::int32_t height, DecodeImage decode);
  /// Reads the size of the index's first PGM image that has one, and closes the index. `not_found` without any.
  Status find_size(const char* index, std::int32_t& width, std::int32_t& height);
  /// A frame that cannot be read is reported with its own Status, and the next call takes the frame after it.
  /// `parse_error` (a = line) for a malformed line of the index; `time_not_monotonic` for a frame that is not later
  /// than its predecessor.
  Status capture(TimeNs now, FrameImage& image, CameraFrame& frame) override;
  TimeNs next_due() const override { return waiting_ ? next_.time_ns : 0; }

 private:
  Status read_line();
  Status parse_line();
  Status find_next();

  int file_ = -1;
  BufferedReader reader_;
  DecodeImage decode_ = nullptr;
  std::int32_t width_ = 0, height_ = 0;
  char folder_[limits::max_path_bytes] = {};
  char line_[limits::max_path_bytes] = {};
  char path_[limits::max_path_bytes] = {};
  std::int64_t line_number_ = 0;
  std::int64_t sequence_ = 0;
  TimeNs latest_ns_ = 0;
  bool waiting_ = false;  ///< `next_` is known and not yet due
  bool ended_ = false;
  CameraFrame next_;
  RowReducer rows_;
};

}  // namespace ilp
