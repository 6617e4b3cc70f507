// A small flight in this process that is recorded: every step of every component, every transaction that it committed,
// and what packet links gave and took.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "bsp/flight/flight_software.hpp"
#include "hal/camera/camera.hpp"
#include "hal/link/link.hpp"
#include "hal/store/forwarding_store.hpp"
#include "tests/support/fake_clock.hpp"

namespace ilp::test {

enum class StateBytes : std::uint8_t { compared, passed_over };

/// One write to the store.
struct Write {
  enum class Kind : std::uint8_t { put, erase, blob } kind = Kind::put;
  RecordType type = RecordType::count;
  std::int64_t id = 0;
  std::string field;                 ///< of a blob
  std::size_t offset = 0;            ///< in the blob
  std::vector<std::uint8_t> bytes;   ///< of a record in its serial form, or of the blob
  std::vector<std::uint8_t> record;  ///< as it lies in memory

  /// The same bytes at the same place. With StateBytes::passed_over only the cursors and the form of a checkpoint
  /// count: after a restart, arrays hold other remains beyond their length, and a link's credit depends on the steps.
  /// What differs in a state otherwise shows in everything that is written after it.
  [[nodiscard]] bool same(const Write& other, StateBytes states) const;
  [[nodiscard]] std::string name() const;
};
using Writes = std::vector<Write>;

/// Notes what is written, and hands it over with the commit.
class RecordingStore final : public ForwardingStore {
 public:
  using ForwardingStore::ForwardingStore;

  std::function<Status()> before_commit;  ///< may refuse it
  std::function<void(const Writes&)> committed;
  std::function<void(const RecordInfo&, std::int64_t)> blob_is_read;

  Status begin() override;
  Status commit() override;
  void rollback() override;
  Status put(const RecordInfo& info, const void* record) override;
  Status erase(const RecordInfo& info, std::int64_t id) override;
  Status write_blob(const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                    std::span<const std::uint8_t> bytes) override;
  Status read_blob(const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                   std::span<std::uint8_t> bytes) override;
  /// A fixed usage: the results must not depend on what the store rolled back earlier.
  StoreUsage usage() override { return {.bytes = 1 << 20}; }

 private:
  Writes open_;
};

Status apply_writes(Store& store, const Writes& writes);

/// Gives the images of a simulated flight at their times.
class RecordedCamera final : public Camera {
 public:
  Status capture(TimeNs now, FrameImage& image, CameraFrame& frame) override;
  [[nodiscard]] TimeNs next_due() const override;
  /// The images from here on are given again.
  void go_to(std::size_t image) { next_ = image; }
  [[nodiscard]] std::size_t given() const { return next_; }

 private:
  std::size_t next_ = 0;
};

/// The camera that took these images.
CameraModel recorded_camera();

/// The far end confirms every file at once.
class ConfirmingLink final : public Link {
 public:
  Status begin_file(const char* name) override;
  Status write(std::span<const std::uint8_t> bytes) override;
  Status end_file() override {
    open_.clear();
    return {};
  }
  Status acknowledged(const char* name, std::uint32_t& bytes, std::uint32_t& crc32) override;

 private:
  struct File {
    std::uint32_t bytes = 0, crc = 0;
  };
  std::map<std::string, File> files_;
  std::string open_;
};

inline constexpr std::size_t nobody = stage_count;

/// What happened, in its order.
struct Event {
  enum class Kind : std::uint8_t { restore, step, commit, received, sent } kind = Kind::step;
  std::size_t stage = nobody;  ///< place in the schedule; `nobody`: the executive, or the start of the flight
  TimeNs time = 0;
  Writes writes;                          ///< of a commit
  Channel channel = Channel::commands;    ///< link of what was received or sent
  std::vector<std::uint8_t> octets = {};  ///< of what was received or sent
};

struct Recording {
  std::vector<Event> events;
  std::map<std::int64_t, int> image_reads;  ///< of a frame's image by the stages, by frame id
  std::vector<std::int64_t> keyframe_frames;
  MissionParameters mission;  ///< that was flown
};

enum class CameraKnown : std::uint8_t { yes, no };

/// Flown once for each kind.
const Recording& recorded_flight(CameraKnown known);
/// With packet links and an operator (ground_station.hpp), once for each kind.
const Recording& recorded_operation(Authentication authentication);

}  // namespace ilp::test
