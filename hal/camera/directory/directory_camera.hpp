// A camera that plays back a recorded strip: image files listed in an index, each delivered at its time.
#pragma once

#include "cfg/limits.hpp"
#include "hal/camera/camera.hpp"
#include "hal/camera/picture/reduction.hpp"
#include "hal/posix/buffered_reader.hpp"

namespace ilp {

/// Reads an image file; host code may add formats.
using DecodeImage = Status (*)(const char* path, FrameImage& image);

/// The index is a text file with a line per frame, `time_ns name [altitude_m]`, in the order of time; `#` begins a
/// comment. Names are absolute paths, or relative to the folder of the index. The index is read line by line, so that a
/// flight of any length takes the same memory.
class DirectoryCamera final : public Camera {
 public:
  DirectoryCamera() = default;
  ~DirectoryCamera();

  /// Opens an index whose frames have `width` x `height` pixels; 0 accepts any size. With a null `decode` the files are
  /// PGM, and those larger than the flight's images are reduced (find_reduction). Returns `not_found` or `io_error`
  /// (first value: errno) if the index cannot be opened, `capacity_exceeded` if its path is too long.
  Status open(const char* index, std::int32_t width, std::int32_t height, DecodeImage decode);
  /// Reads the size of the first readable PGM image in the index, and closes the index. Returns `not_found` if there is
  /// none.
  Status find_size(const char* index, std::int32_t& width, std::int32_t& height);
  /// Returns, besides the statuses of the interface, the error of a frame that cannot be read; the next call continues
  /// with the frame after it. Returns `parse_error` (first value: line) for a malformed line of the index,
  /// `time_not_monotonic` (first value: frame, second: ns) for a frame that is not later than its predecessor, and
  /// `image_size_changed` for a frame of another size than the flight's.
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
