// select: lists the images of a strip or video that the flight's overlap checker would keep, with reasons.

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "cfg/limits.hpp"
#include "cfg/mission.hpp"
#include "fsw/base/math.hpp"
#include "hal/camera/y4m/y4m_camera.hpp"
#include "hal/clock/virtual_clock.hpp"
#include "hal/store/ram/ram_store.hpp"
#include "sim/host/image_io.hpp"
#include "sim/host/mission_input.hpp"
#include "sim/host/status_error.hpp"
#include "sim/host/strip.hpp"
#include "sim/host/text_format.hpp"
#include "sim/tools/lab/input_files.hpp"
#include "sim/tools/lab/lab.hpp"
#include "sim/tools/lab/stage_range.hpp"

namespace ilp::lab {
namespace {

// Which images of a strip or video the flight's overlap checker would keep, and why.

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

std::vector<std::filesystem::path> files_of(const std::vector<host::StripFrame>& frames) {
  std::vector<std::filesystem::path> files;
  for (const host::StripFrame& frame : frames) files.push_back(frame.file);
  return files;
}

/// Files in the order of the list, named as the list names them.
class FileSequence final : public ImageSequence {
 public:
  explicit FileSequence(std::vector<host::StripFrame> frames)
      : frames_(std::move(frames)), images_(files_of(frames_)) {}
  Status next(FrameImage& image, std::string& name) override;

 private:
  std::vector<host::StripFrame> frames_;
  StripImages images_;
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
std::string short_name(const FrameChoice& choice) {
  return std::filesystem::path(choice.name).filename().string();
}

// Only what is used becomes real memory: a kilobyte or so of records per image, and a few images.
constexpr std::size_t store_bytes = std::size_t{1} << 30U;
const std::string unrelated_name = name_of(OverlapVerdict::overlap_unknown);
constexpr int most_minor_frames_per_image = 2000;

std::string text_of(const char* format, double value) {
  char text[48];
  std::snprintf(text, sizeof(text), format, value);
  return text;
}

/// Gives one image for every call of advance(), so that what became of it can be read before the next one.
class SteppedCamera final : public Camera {
 public:
  explicit SteppedCamera(ImageSequence& images) : images_(images) {}

  void advance() { waiting_ = true; }
  Status capture(TimeNs now, FrameImage& image, CameraFrame& frame) override {
    if (!waiting_) return ended_ ? StatusCode::end_of_stream : StatusCode::not_ready;
    waiting_ = false;
    const Status status = images_.next(image, name_);
    ended_ = status.is(StatusCode::end_of_stream);
    if (ended_) return status;
    frame = {};
    frame.time_ns = now;
    frame.sequence = ++sequence_;
    const Status usable = status.ok() ? judge(image) : status;
    if (!status.ok()) objection_ = host::status_sentence(status);
    if (usable.ok()) objection_.clear();
    return usable;
  }

  [[nodiscard]] bool ended() const { return ended_; }
  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] std::int64_t sequence() const { return sequence_; }
  /// Why the latest image is of no use; empty when it is.
  [[nodiscard]] const std::string& objection() const { return objection_; }

 private:
  Status judge(const FrameImage& image) {
    const Status refusal = {StatusCode::image_size_changed, image.width(), image.height()};
    const std::string size = host::size_text(image.width(), image.height()) + " pixels, expected ";
    if (std::min(image.width(), image.height()) < limits::min_image_side) {
      objection_ = size + "sides of " + std::to_string(limits::min_image_side) + " at least";
      return refusal;
    }
    if (width_ == 0) {
      width_ = image.width();
      height_ = image.height();
    }
    if (image.width() == width_ && image.height() == height_) return {};
    objection_ = size + host::size_text(width_, height_) + " as the first image has";
    return refusal;
  }

  ImageSequence& images_;
  std::string name_, objection_;
  std::int64_t sequence_ = 0;
  std::int32_t width_ = 0, height_ = 0;
  bool waiting_ = false, ended_ = false;
};

/// False when the stages did not come to rest: the store is full.
bool process_image(Executive& executive, Clock& clock) {
  for (int i = 0; i < most_minor_frames_per_image; ++i) {
    executive.run_minor_frame();
    clock.sleep_until(clock.now() + minor_frame_ns);
    if (executive.idle()) return true;
  }
  return false;
}

/// Reads the checker's records after every image and says in words what they mean.
class Reader {
 public:
  Reader(Store& store, const SteppedCamera& camera, const MissionParameters& mission)
      : store_(store), camera_(camera), mission_(mission) {}

  void read_image() {
    choices_.push_back({});
    FrameChoice& choice = choices_.back();
    choice.name = camera_.name();
    if (!camera_.objection().empty()) {
      choice.reason = camera_.objection();
      return;
    }
    FrameRecord frame;
    const auto latest = static_cast<std::int64_t>(index_of_frame_.size());
    const Status found = next(store_, latest, frame);
    if (found.is(StatusCode::not_found)) {
      choice.reason = "the same bytes as the image before it";
      return;
    }
    host::require(found, "reading the store");
    index_of_frame_.push_back(choices_.size() - 1);
    held_.push_back(frame.id);
    read_overlap(frame.id);
    read_keyframes(frame.id);
    release_images();
  }
  void read_end() { read_keyframes(0); }

  std::vector<FrameChoice>& choices() { return choices_; }
  [[nodiscard]] std::size_t usable() const { return index_of_frame_.size(); }

 private:
  std::size_t index_of(std::int64_t frame_id) const {
    return index_of_frame_.at(static_cast<std::size_t>(frame_id - 1));
  }
  FrameChoice& choice_of(std::int64_t frame_id) { return choices_[index_of(frame_id)]; }

  void read_overlap(std::int64_t frame_id) {
    OverlapRecord record;
    host::require(get(store_, frame_id, record), "the overlap of " + choice_of(frame_id).name);
    FrameChoice& choice = choice_of(frame_id);
    const auto verdict = record.verdict;
    choice.verdict = name_of(verdict);
    if (record.keyframe_id != 0) {
      KeyframeRecord keyframe;
      host::require(get(store_, record.keyframe_id, keyframe), "reading the store");
      choice.keyframe = index_of(keyframe.frame_id);
      choice.measured = verdict == OverlapVerdict::ok;
      choice.overlap = record.overlap;
      choice.rotation_rad = record.rotation_rad;
      choice.scale = record.scale;
    }
    if (record.decision == OverlapDecision::rejected) {
      choice.decision = Decision::rejected;
      choice.reason = rejection(verdict, choice);
    } else {
      choice.decision = Decision::skipped;
      choice.reason = "above the target";
    }
  }

  std::string rejection(OverlapVerdict verdict, const FrameChoice& choice) const {
    const char* const why = verdict == OverlapVerdict::too_dark       ? "too dark"
                            : verdict == OverlapVerdict::blurred      ? "blurred"
                            : verdict == OverlapVerdict::texture_poor ? "too little texture"
                                                                      : "";
    if (choice.keyframe == FrameChoice::none) return std::string(why) + ", no strip begins with it";
    return *why != 0 ? why : "nothing in it matches " + short_name(choices_[choice.keyframe]);
  }

  /// Keyframes chosen since the last call; `frame_id` is the image that made the checker choose, 0 the end.
  void read_keyframes(std::int64_t frame_id) {
    KeyframeRecord keyframe;
    Status found;
    while ((found = next(store_, keyframe_.id, keyframe)).ok()) {
      FrameChoice& choice = choice_of(keyframe.frame_id);
      choice.decision = keyframe.index == 0 ? Decision::new_strip : Decision::kept;
      choice.strip = keyframe.strip_id;
      choice.reason = keyframe.index == 0 ? reason_of_strip(keyframe, frame_id) : reason_of(keyframe, frame_id);
      keyframe_ = keyframe;
    }
    if (!found.is(StatusCode::not_found)) host::require(found, "reading the store");
  }

  std::string reason_of(const KeyframeRecord& keyframe, std::int64_t frame_id) {
    const std::string before = short_name(choice_of(keyframe_.frame_id));
    if (keyframe.frame_id == frame_id && keyframe.overlap < mission_.min_overlap) {
      return "related by features: shares only " + text_of("%.2f", keyframe.overlap) + " with " + before;
    }
    if (keyframe.frame_id == frame_id) return "first at or below the target";
    if (frame_id == 0) return "the end: ground that " + before + " does not show";
    return "last one that can be bridged: " + short_name(choice_of(frame_id)) + " shares less than " +
           text_of("%.2f", mission_.min_overlap) + " with " + before + " or matches nothing of it";
  }

  std::string reason_of_strip(const KeyframeRecord& keyframe, std::int64_t frame_id) {
    if (keyframe.strip_id == 1) return "begins the first strip";
    const std::string before = short_name(choice_of(keyframe_.frame_id));
    if (frame_id == 0) return "the end: a strip of its own, because nothing in it matches " + before;
    if (keyframe.frame_id == frame_id) {
      const std::string overlap = text_of("%.2f", choice_of(frame_id).overlap);
      return "begins a new strip: shares only " + overlap + " with " + before +
             ", and too little with it and the keyframe before";
    }
    return "begins a new strip: neither it nor " + short_name(choice_of(frame_id)) + " matches " + before;
  }

  /// All but those that the checker may still read: the latest keyframe, the candidate of lowest overlap with it, and
  /// one that matched nothing.
  void release_images() {
    if (keyframe_.id == 0) return release_all_but({});
    const std::size_t keyframe = index_of(keyframe_.frame_id);
    std::int64_t candidate = 0, unrelated = 0;
    for (const std::int64_t id : held_) {
      const FrameChoice& choice = choice_of(id);
      if (choice.keyframe != keyframe) continue;
      if (choice.decision == Decision::rejected && choice.verdict == unrelated_name) unrelated = id;
      if (choice.decision != Decision::skipped) continue;
      if (candidate == 0 || choice.overlap <= choice_of(candidate).overlap) candidate = id;
    }
    release_all_but({keyframe_.frame_id, candidate, unrelated});
  }

  void release_all_but(const std::vector<std::int64_t>& needed) {
    Transaction transaction(store_);
    host::require(transaction.begin(), "releasing images");
    std::vector<std::int64_t> held;
    for (const std::int64_t id : held_) {
      if (std::find(needed.begin(), needed.end(), id) != needed.end()) {
        held.push_back(id);
        continue;
      }
      FrameRecord frame;
      host::require(get(store_, id, frame), "releasing images");
      frame.image.bytes = 0;
      host::require(put(store_, frame), "releasing images");
    }
    host::require(transaction.commit(), "releasing images");
    held_ = std::move(held);
  }

  Store& store_;
  const SteppedCamera& camera_;
  const MissionParameters& mission_;
  std::vector<FrameChoice> choices_;
  std::vector<std::size_t> index_of_frame_;  ///< of the frame records 1, 2, ...
  std::vector<std::int64_t> held_;           ///< frames whose pixels are in the store
  KeyframeRecord keyframe_;                  ///< the latest, id 0: none
};

void require_two(const std::vector<FrameChoice>& choices, std::size_t usable) {
  if (usable >= 2) return;
  std::string message =
      std::to_string(usable) + " of " + std::to_string(choices.size()) + " images can be used, expected two at least";
  for (const FrameChoice& choice : choices) {
    if (choice.decision != Decision::passed_over) continue;
    message += "; " + short_name(choice) + ": " + choice.reason;
    break;
  }
  throw std::runtime_error(message);
}

const char* decision_name(Decision decision) {
  constexpr std::array names = {"kept", "new strip", "skipped", "rejected", "passed over"};
  static_assert(names.size() == static_cast<std::size_t>(Decision::count));
  return names[static_cast<std::size_t>(decision)];
}

Status FileSequence::next(FrameImage& image, std::string& name) {
  if (at_ == frames_.size()) return StatusCode::end_of_stream;
  const std::filesystem::path& file = frames_[at_++].file;
  name = file.string();
  std::error_code error;
  if (images_.is_plain(file) || !std::filesystem::exists(file, error)) return host::decode_image(name.c_str(), image);
  try {
    const GrayImage read = images_.read(file);
    ILP_TRY(image.resize(read.width, read.height));
    std::copy(read.samples.begin(), read.samples.end(), image.view().data);
    return {};
  } catch (const std::exception&) {
    return StatusCode::parse_error;
  }
}

VideoSequence::VideoSequence(const std::string& path) : file_(STDIN_FILENO) {
  if (path != "-") file_ = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file_ < 0) throw std::runtime_error("video " + path + " cannot be opened");
  const Status status = video_.open(file_);
  if (!status.ok() && file_ != STDIN_FILENO) close(file_);
  host::require(status, "video " + path);
}

VideoSequence::~VideoSequence() {
  if (file_ != STDIN_FILENO) close(file_);
}

Status VideoSequence::next(FrameImage& image, std::string& name) {
  CameraFrame frame;
  const Status status = video_.capture(std::numeric_limits<TimeNs>::max(), image, frame);
  name = frame.name;
  return status;
}

/// Every image goes through capture clock, acquisition and overlap checker as in flight, whatever capture times the
/// mission names; nothing downstream can end a strip. Memory does not grow with the number of images but for their
/// records. The first readable image gives the size; others are passed over. std::runtime_error when fewer than two
/// images can be used.
std::vector<FrameChoice> select_frames(ImageSequence& images, const MissionParameters& mission) {
  MissionParameters every_image = mission;
  every_image.capture_mode = CaptureMode::regular;
  every_image.capture_interval_s = 0;
  const auto region = std::make_unique_for_overwrite<std::byte[]>(store_bytes);
  RamStore store({region.get(), store_bytes});
  SteppedCamera camera(images);
  VirtualClock clock;
  StageRange stages({"capture_clock", "acquisition", "overlap_checker"}, {store, clock, every_image, &camera});
  host::require(stages.executive().start(), "starting the flight software");
  Reader reader(store, camera, every_image);
  for (;;) {
    camera.advance();
    if (!process_image(stages.executive(), clock)) {
      throw std::runtime_error("the store in memory is full after " + std::to_string(camera.sequence()) + " images");
    }
    if (camera.ended()) break;
    reader.read_image();
  }
  reader.read_end();
  require_two(reader.choices(), reader.usable());
  return std::move(reader.choices());
}

struct SelectOptions {
  std::string folder, video, mission;
  double target = 0, minimum = 0;  ///< 0: the mission's
  bool full_turn = false, list = false, json = false;
};

MissionParameters mission_for(const SelectOptions& options) {
  MissionParameters mission = host::read_mission(options.mission);
  if (options.target > 0) mission.target_overlap = options.target;
  if (options.minimum > 0) mission.min_overlap = options.minimum;
  if (options.full_turn) mission.max_rotation_rad = pi;
  if (mission.target_overlap <= mission.min_overlap) {
    char text[120];
    std::snprintf(text, sizeof(text), "target overlap %g: expected more than the minimum overlap, %g",
                  mission.target_overlap, mission.min_overlap);
    throw std::runtime_error(text);
  }
  host::require(validate(mission), "mission parameters");
  return mission;
}

std::unique_ptr<ImageSequence> open_images(const SelectOptions& options) {
  if (options.folder.empty() == options.video.empty()) throw UsageError("expected either DIR or --y4m");
  if (!options.video.empty()) return std::make_unique<VideoSequence>(options.video);
  return std::make_unique<FileSequence>(host::list_strip(options.folder));
}

using Counts = std::array<std::size_t, static_cast<std::size_t>(Decision::count)>;

Counts count_decisions(const std::vector<FrameChoice>& choices) {
  Counts counts{};
  for (const FrameChoice& choice : choices) ++counts[static_cast<std::size_t>(choice.decision)];
  return counts;
}

std::size_t count_of(const Counts& counts, Decision decision) {
  return counts[static_cast<std::size_t>(decision)];
}

double degrees(double radians) {
  return radians * 180 / pi;
}

std::string line_of(const FrameChoice& choice, std::size_t name_width) {
  char numbers[64] = "    -         -      -";
  if (choice.measured) {
    std::snprintf(numbers, sizeof(numbers), "%.3f  %8.2f  %.3f", choice.overlap, degrees(choice.rotation_rad),
                  choice.scale);
  }
  std::string name = short_name(choice);
  name.resize(std::max(name.size(), name_width), ' ');
  char head[48];
  std::snprintf(head, sizeof(head), "  %-11s  ", decision_name(choice.decision));
  char verdict[32];
  std::snprintf(verdict, sizeof(verdict), "  %-15s  ", choice.verdict.empty() ? "-" : choice.verdict.c_str());
  return name + head + numbers + verdict + choice.reason + "\n";
}

std::string summary_of(const Counts& counts, std::size_t images) {
  const std::size_t strips = count_of(counts, Decision::new_strip);
  std::string text = "kept " + std::to_string(count_of(counts, Decision::kept) + strips) + " of " +
                     std::to_string(images) + " images in " + std::to_string(strips) +
                     (strips == 1 ? " strip" : " strips");
  for (const Decision decision : {Decision::skipped, Decision::rejected, Decision::passed_over}) {
    if (count_of(counts, decision) == 0) continue;
    text += ", " + std::to_string(count_of(counts, decision)) + " " + decision_name(decision);
  }
  return text + "\n";
}

std::string table_of(const std::vector<FrameChoice>& choices) {
  std::size_t name_width = 5;
  for (const FrameChoice& choice : choices) name_width = std::max(name_width, short_name(choice).size());
  std::string text =
      "image" + std::string(name_width - 5, ' ') + "  decision     overlap  rot_deg  scale  verdict          reason\n";
  for (const FrameChoice& choice : choices) text += line_of(choice, name_width);
  return text + summary_of(count_decisions(choices), choices.size());
}

std::string list_of(const std::vector<FrameChoice>& choices) {
  std::string text;
  for (const FrameChoice& choice : choices) {
    if (is_kept(choice.decision)) text += choice.name + "\n";
  }
  return text;
}

Json json_of(const std::vector<FrameChoice>& choices, const MissionParameters& mission) {
  const Counts counts = count_decisions(choices);
  Json images = Json::array();
  for (const FrameChoice& choice : choices) {
    const bool compared = choice.keyframe != FrameChoice::none;
    images.push_back({{"name", choice.name},
                      {"decision", decision_name(choice.decision)},
                      {"strip", choice.strip > 0 ? Json(choice.strip) : Json()},
                      {"keyframe", compared ? Json(choices[choice.keyframe].name) : Json()},
                      {"overlap", choice.measured ? Json(choice.overlap) : Json()},
                      {"rotation_deg", choice.measured ? Json(degrees(choice.rotation_rad)) : Json()},
                      {"scale", choice.measured ? Json(choice.scale) : Json()},
                      {"verdict", choice.verdict.empty() ? Json() : Json(choice.verdict)},
                      {"reason", choice.reason}});
  }
  const std::size_t strips = count_of(counts, Decision::new_strip);
  const std::size_t kept = count_of(counts, Decision::kept) + strips;
  return {{"verdict", kept > 0 ? "ok" : "nothing_kept"},
          {"frames", choices.size()},
          {"kept", kept},
          {"skipped", count_of(counts, Decision::skipped)},
          {"rejected", count_of(counts, Decision::rejected)},
          {"passed_over", count_of(counts, Decision::passed_over)},
          {"strips", strips},
          {"target_overlap", mission.target_overlap},
          {"min_overlap", mission.min_overlap},
          {"images", images}};
}

Json run_select(const SelectOptions& options, int repeat) {
  if (repeat > 1) throw UsageError("select does not measure time: leave --repeat out");
  if (options.list && options.json) throw UsageError("expected at most one of --list and --json");
  const MissionParameters mission = mission_for(options);
  const auto images = open_images(options);
  const std::vector<FrameChoice> choices = select_frames(*images, mission);
  if (options.json) return json_of(choices, mission);
  return options.list ? list_of(choices) : table_of(choices);
}

}  // namespace

void add_select_command(Lab& lab) {
  const auto options = std::make_shared<SelectOptions>();
  CLI::App& app =
      lab.add("select", "a table of the images of a strip or video that the flight would keep, and why",
              "images --target-overlap 0.8", [options](int repeat) { return run_select(*options, repeat); });
  app.add_option("DIR", options->folder,
                 "folder of PNG, PGM, JPEG or TIFF images in the order of their names, or of its times.txt");
  app.add_option("--y4m", options->video, "YUV4MPEG2 file that takes the place of the folder, - for standard input");
  app.add_option("--target,--target-overlap", options->target,
                 "an image is kept once its overlap with the last kept image is at or below this")
      ->check(finite_in(0.5, 0.98))
      ->default_str("0.82");
  app.add_option("--minimum", options->minimum, "below this overlap the strip ends")
      ->check(finite_in(0.2, 0.95))
      ->default_str("0.55");
  app.add_flag("--full-turn", options->full_turn, "search every rotation between images (default 0.35 rad)");
  app.add_option("--mission", options->mission, "mission parameters, an .ini file; its capture times are ignored");
  app.add_flag("--list", options->list, "print only the names of the kept images, one per line");
  app.add_flag("--json", options->json, "print one JSON object");
}

}  // namespace ilp::lab
