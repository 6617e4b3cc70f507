#include "tests/stages/recorded_flight.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <memory>
#include <optional>

#include "fsw/base/crc.hpp"
#include "fsw/executive/frame_timing.hpp"
#include "fsw/records/serial.hpp"
#include "hal/camera/directory/pgm.hpp"
#include "hal/store/ram/ram_store.hpp"
#include "sim/world/render_flight.hpp"
#include "tests/faults/reveal.hpp"
#include "tests/stages/ground_station.hpp"
#include "tests/support/calm_scenario.hpp"
#include "tests/support/flight_kit.hpp"
#include "tests/support/store_records.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp::faults {
ILP_REVEAL(FlightSoftware, components_);
}  // namespace ilp::faults

namespace ilp::test {
namespace {

constexpr std::size_t region_bytes = std::size_t{48} << 20U;
constexpr TimeNs longest_flight_ns = 600 * ns_per_s;
constexpr int rest_frames = 60;
constexpr int image_count = 14;
constexpr TimeNs interval_ns = ns_per_s / 2;

world::Scenario scenario() {
  return calm_scenario(image_count, 160, 120, 137);
}

/// Rendered once for the process.
const std::vector<std::unique_ptr<FrameImage>>& images() {
  static const auto all = [] {
    const TemporaryFolder folder;
    world::render_flight(folder / "", scenario());
    std::vector<std::unique_ptr<FrameImage>> read;
    for (int i = 1; i <= image_count; ++i) {
      char name[32];
      std::snprintf(name, sizeof(name), "images/%04d.pgm", i);
      read.push_back(std::make_unique<FrameImage>());
      EXPECT_TRUE(read_pgm((folder / name).c_str(), *read.back()).ok()) << name;
    }
    return read;
  }();
  return all;
}

/// Stands in the executive's table for a component, and says when it is called.
class Watched final : public Component {
 public:
  Watched(Component& component, std::size_t stage, Recording& recording, std::size_t& at_work, Clock& clock)
      : component_(component), stage_(stage), recording_(recording), at_work_(at_work), clock_(clock) {}

  [[nodiscard]] const char* name() const override { return component_.name(); }
  Status restore() override {
    begin(Event::Kind::restore);
    const Status status = component_.restore();
    at_work_ = nobody;
    return status;
  }
  StepResult step() override {
    begin(Event::Kind::step);
    const StepResult result = component_.step();
    at_work_ = nobody;
    return result;
  }
  [[nodiscard]] LastingMemory lasting() const override { return component_.lasting(); }

 private:
  void begin(Event::Kind kind) {
    recording_.events.push_back({kind, stage_, clock_.now(), {}, {}, {}});
    at_work_ = stage_;
  }

  Component& component_;
  std::size_t stage_;
  Recording& recording_;
  std::size_t& at_work_;
  Clock& clock_;
};

/// A packet link that says what it gives and takes.
class WatchedLink final : public PacketLink {
 public:
  WatchedLink(PacketLink& behind, Channel channel, Recording& recording, const std::size_t& at_work, Clock& clock)
      : behind_(behind), channel_(channel), recording_(recording), at_work_(at_work), clock_(clock) {}

  Status receive(std::span<std::uint8_t> buffer, std::size_t& bytes) override {
    const Status status = behind_.receive(buffer, bytes);
    if (status.ok()) note(Event::Kind::received, buffer.first(bytes));
    return status;
  }
  Status send(std::span<const std::uint8_t> packet) override {
    const Status status = behind_.send(packet);
    if (status.ok()) note(Event::Kind::sent, packet);
    return status;
  }

 private:
  void note(Event::Kind kind, std::span<const std::uint8_t> octets) {
    recording_.events.push_back(
        {kind, at_work_, clock_.now(), {}, channel_, std::vector<std::uint8_t>(octets.begin(), octets.end())});
  }

  PacketLink& behind_;
  Channel channel_;
  Recording& recording_;
  const std::size_t& at_work_;
  Clock& clock_;
};

enum class Links : std::uint8_t { whole_files, packets };

Recording fly(CameraKnown known, Links links = Links::whole_files,
              Authentication authentication = Authentication::none) {
  Recording recording;
  recording.mission.authentication = authentication;
  // No packet waits for the link's rate.
  if (links == Links::packets) recording.mission.link_bytes_per_s = 1e9;
  recording.mission.window_keyframes = 3;
  recording.mission.corners = 300;
  recording.mission.quality_layers = 2;
  // Several rounds of reading, each with places that are saved.
  recording.mission.scrub_bytes_per_s = 20000;
  recording.mission.scrub_period_s = 2;
  recording.mission.camera_known = known == CameraKnown::yes;
  MissionParameters mission = recording.mission;

  std::size_t at_work = nobody;
  StillClock clock;
  std::vector<std::byte> region(region_bytes);
  RamStore ram(region);
  RecordingStore store(ram);
  store.committed = [&](const Writes& writes) {
    recording.events.push_back({Event::Kind::commit, at_work, clock.now(), writes, {}, {}});
  };
  store.blob_is_read = [&](const RecordInfo& info, std::int64_t id) {
    const bool scrubbing = at_work == place_of(ComponentId::scrubber);
    if (info.type == RecordType::frame && !scrubbing) ++recording.image_reads[id];
  };
  RecordedCamera camera;
  ConfirmingLink link;
  const auto station = links == Links::packets ? std::make_unique<GroundStation>(clock, mission) : nullptr;
  std::optional<WatchedLink> packets, files;
  if (station) packets.emplace(station->packets(), Channel::commands, recording, at_work, clock);
  if (station) files.emplace(station->files(), Channel::files, recording, at_work, clock);
  Authenticator keys;
  EXPECT_TRUE(keys.add(station_spi, station_key).ok());
  FlightKit flight({store, camera, link, clock, packets ? &*packets : nullptr, files ? &*files : nullptr}, mission);
  flight->router().authenticate_with(keys);
  auto& components = (*flight).*revealed(faults::FlightSoftware_components_{});
  std::vector<std::unique_ptr<Watched>> watched;
  for (std::size_t i = 0; i < stage_count; ++i) {
    watched.push_back(std::make_unique<Watched>(*components[i], i, recording, at_work, clock));
    components[i] = watched.back().get();
  }
  EXPECT_TRUE(flight.start(scenario().flight.camera).ok());
  int rest = 0;
  for (TimeNs next = 0; clock.now() < longest_flight_ns && rest < rest_frames;) {
    flight->executive().run_minor_frame(next);
    if (station) station->listen();
    rest = flight->drained() && (!station || station->done()) ? rest + 1 : 0;
    next = next_frame_begin(next, clock.now());
    clock.sleep_until(next);
  }
  EXPECT_EQ(rest, rest_frames) << "the flight has not come to its end";
  for (const KeyframeRecord& keyframe : records_of<KeyframeRecord>(store))
    recording.keyframe_frames.push_back(keyframe.frame_id);
  return recording;
}

}  // namespace

bool Write::same(const Write& other, StateBytes states) const {
  const bool same_place = kind == other.kind && type == other.type && id == other.id && field == other.field &&
                          offset == other.offset && bytes.size() == other.bytes.size();
  const bool compared = states == StateBytes::compared || type != RecordType::checkpoint || kind == Kind::erase;
  if (!same_place || compared) return same_place && bytes == other.bytes;
  if (kind == Kind::blob) return true;
  CheckpointRecord is, was;
  std::memcpy(&is, record.data(), sizeof(is));
  std::memcpy(&was, other.record.data(), sizeof(was));
  return is.cursor == was.cursor && is.cursor_second == was.cursor_second && is.generation == was.generation &&
         is.layout == was.layout;
}

std::string Write::name() const {
  constexpr const char* kinds[] = {"put ", "erase ", "blob of "};
  return kinds[static_cast<int>(kind)] + std::string(record_info(type).name) + " " + std::to_string(id) + " " + field;
}

Status RecordingStore::begin() {
  open_.clear();
  return inner_.begin();
}

Status RecordingStore::commit() {
  const Status allowed = before_commit ? before_commit() : Status{};
  if (!allowed.ok()) {
    rollback();
    return allowed;
  }
  ILP_TRY(inner_.commit());
  if (committed) committed(open_);
  open_.clear();
  return {};
}

void RecordingStore::rollback() {
  open_.clear();
  inner_.rollback();
}

Status RecordingStore::put(const RecordInfo& info, const void* record) {
  ILP_TRY(inner_.put(info, record));
  Write write{Write::Kind::put, info.type, 0, {}, 0, {}, {}};
  std::memcpy(&write.id, record, sizeof(write.id));
  write.bytes.resize(serial_bytes(info));
  EXPECT_TRUE(serialize(info, record, write.bytes).ok());
  const auto* bytes = static_cast<const std::uint8_t*>(record);
  write.record.assign(bytes, bytes + info.bytes);
  open_.push_back(std::move(write));
  return {};
}

Status RecordingStore::erase(const RecordInfo& info, std::int64_t id) {
  ILP_TRY(inner_.erase(info, id));
  open_.push_back({Write::Kind::erase, info.type, id, {}, 0, {}, {}});
  return {};
}

Status RecordingStore::write_blob(const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                                  std::span<const std::uint8_t> bytes) {
  ILP_TRY(inner_.write_blob(info, field, id, offset, bytes));
  open_.push_back({Write::Kind::blob, info.type, id, field, offset, {bytes.begin(), bytes.end()}, {}});
  return {};
}

Status RecordingStore::read_blob(const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                                 std::span<std::uint8_t> bytes) {
  if (blob_is_read) blob_is_read(info, id);
  return inner_.read_blob(info, field, id, offset, bytes);
}

Status apply_writes(Store& store, const Writes& writes) {
  Transaction transaction(store);
  ILP_TRY(transaction.begin());
  for (const Write& write : writes) {
    const RecordInfo& info = record_info(write.type);
    switch (write.kind) {
      case Write::Kind::put: {
        alignas(8) std::uint8_t record[limits::max_record_bytes];
        std::memcpy(record, write.record.data(), write.record.size());
        ILP_TRY(store.put(info, record));
        break;
      }
      case Write::Kind::erase:
        ILP_TRY(store.erase(info, write.id));
        break;
      case Write::Kind::blob:
        ILP_TRY(store.write_blob(info, write.field.c_str(), write.id, write.offset, write.bytes));
        break;
    }
  }
  return transaction.commit();
}

Status RecordedCamera::capture(TimeNs now, FrameImage& image, CameraFrame& frame) {
  if (next_ == images().size()) return {StatusCode::end_of_stream, static_cast<std::int64_t>(next_)};
  const TimeNs time = static_cast<TimeNs>(next_) * interval_ns;
  if (time > now) return StatusCode::not_ready;
  const ImageView<std::uint8_t> from = images()[next_]->view();
  ILP_TRY(image.resize(from.width, from.height));
  std::memcpy(image.view().data, from.data, from.area());
  frame = {};
  frame.time_ns = time;
  frame.sequence = static_cast<std::int64_t>(++next_);
  return {};
}

TimeNs RecordedCamera::next_due() const {
  return next_ < images().size() ? static_cast<TimeNs>(next_) * interval_ns : 0;
}

CameraModel recorded_camera() {
  return scenario().flight.camera;
}

Status ConfirmingLink::begin_file(const char* name) {
  open_ = name;
  files_[open_] = {};
  return {};
}

Status ConfirmingLink::write(std::span<const std::uint8_t> bytes) {
  File& file = files_[open_];
  file.bytes += static_cast<std::uint32_t>(bytes.size());
  file.crc = crc32(bytes, file.crc);
  return {};
}

Status ConfirmingLink::acknowledged(const char* name, std::uint32_t& bytes, std::uint32_t& crc32) {
  const auto file = files_.find(name);
  if (file == files_.end() || open_ == name) return StatusCode::not_ready;
  bytes = file->second.bytes;
  crc32 = file->second.crc;
  return {};
}

const Recording& recorded_flight(CameraKnown known) {
  static const Recording with_camera = fly(CameraKnown::yes);
  if (known == CameraKnown::yes) return with_camera;
  static const Recording without_camera = fly(CameraKnown::no);
  return without_camera;
}

const Recording& recorded_operation(Authentication authentication) {
  static const Recording open = fly(CameraKnown::yes, Links::packets);
  if (authentication == Authentication::none) return open;
  static const Recording authenticated = fly(CameraKnown::yes, Links::packets, Authentication::telecommands);
  return authenticated;
}

}  // namespace ilp::test
