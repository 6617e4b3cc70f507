// Which images of a strip or video the flight's overlap checker would keep, and why.
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "cfg/mission.hpp"
#include "hal/camera/y4m/y4m_camera.hpp"
#include "sim/host/strip.hpp"

namespace ilp::lab {

/// One image after the other, at no times of their own.
class ImageSequence {
 public:
  ImageSequence() = default;
  ImageSequence(const ImageSequence&) = delete;
  ImageSequence& operator=(const ImageSequence&) = delete;
  virtual ~ImageSequence() = default;

  /// `end_of_stream` after the last image. Any other status but `ok` means an image that cannot be read, and the next
  /// call goes on after it. `name` is set in both cases.
  virtual Status next(FrameImage& image, std::string& name) = 0;
};

/// Files in the order of the list, named as the list names them.
class FileSequence final : public ImageSequence {
 public:
  explicit FileSequence(std::vector<host::StripFrame> frames) : frames_(std::move(frames)) {}
  Status next(FrameImage& image, std::string& name) override;

 private:
  std::vector<host::StripFrame> frames_;
  std::size_t at_ = 0;
};

/// A YUV4MPEG2 file, `-` for standard input. Frames are named frame-000001, frame-000002, ...
class VideoSequence final : public ImageSequence {
 public:
  /// std::runtime_error when it cannot be opened or its header is none.
  explicit VideoSequence(const std::string& path);
  ~VideoSequence() override;
  Status next(FrameImage& image, std::string& name) override;

 private:
  int file_ = -1;
  Y4mCamera video_;
};

enum class Decision : std::uint8_t {
  kept,
  new_strip,    ///< kept, and the first of its strip
  skipped,      ///< comparable and not needed
  rejected,     ///< cannot be compared: dark, blurred, without texture, unrelated
  passed_over,  ///< never reached the overlap checker: unreadable, of another size, a repetition
  count
};
[[nodiscard]] const char* decision_name(Decision decision);
[[nodiscard]] inline bool is_kept(Decision decision) {
  return decision == Decision::kept || decision == Decision::new_strip;
}

struct FrameChoice {
  static constexpr std::size_t none = std::numeric_limits<std::size_t>::max();
  std::string name;  ///< as the sequence has it
  Decision decision = Decision::passed_over;
  std::size_t keyframe = none;  ///< index of the kept image it was compared with; none: with none
  double overlap = 0;           ///< with that image, as are the next two; meaningful where `measured`
  double rotation_rad = 0, scale = 1;
  bool measured = false;
  std::string verdict;     ///< the overlap checker's, empty when it never saw the image
  std::int64_t strip = 0;  ///< of a kept image, from 1
  std::string reason;      ///< in plain words; names other images by short_name
};

/// The name of the image without its folders.
[[nodiscard]] std::string short_name(const FrameChoice& choice);

/// Every image goes through capture clock, acquisition and overlap checker as in flight, whatever capture times the
/// mission names; nothing downstream can end a strip. Memory does not grow with the number of images but for their
/// records. The first readable image gives the size; others are passed over. std::runtime_error when fewer than two
/// images can be used.
[[nodiscard]] std::vector<FrameChoice> select_frames(ImageSequence& images, const MissionParameters& mission);

}  // namespace ilp::lab
