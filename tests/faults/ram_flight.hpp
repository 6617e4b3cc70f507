// The small flight on a store in this process: a trial branches off between any two calls of the store, and needs no
// file.
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hal/camera/camera.hpp"
#include "hal/link/link.hpp"
#include "hal/nonvolatile/ram_nonvolatile.hpp"
#include "hal/store/ram/ram_store.hpp"
#include "tests/faults/packet_ground.hpp"
#include "tests/faults/results.hpp"
#include "tests/faults/tiny_flight.hpp"

namespace ilp::faults {

/// The images of the world, as DirectoryCamera gives them.
class MemoryCamera final : public Camera {
 public:
  explicit MemoryCamera(const std::filesystem::path& world);
  Status capture(TimeNs now, FrameImage& image, CameraFrame& frame) override;
  TimeNs next_due() const override { return next_ < images_.size() ? times_[next_] : 0; }
  /// A new start of the software reads the recording from its beginning.
  void rewind() { next_ = 0; }

 private:
  std::int32_t width_ = 0, height_ = 0;
  std::vector<std::vector<std::uint8_t>> images_;
  std::vector<TimeNs> times_;
  std::size_t next_ = 0;
};

/// The far end holds every file at once, and says so.
class MemoryLink final : public Link {
 public:
  Status begin_file(const char* name) override;
  Status write(std::span<const std::uint8_t> bytes) override;
  Status end_file() override;
  Status acknowledged(const char* name, std::uint32_t& bytes, std::uint32_t& crc32) override;

  GroundFiles files;

 private:
  std::string name_;
  std::vector<std::uint8_t> open_;
};

/// Minor frames after the end: lost events are reported every fiftieth.
inline constexpr int rest_frames = 60;

/// What is flown: the images of a folder, with an outbox or with packets.
struct World {
  std::filesystem::path folder;
  bool packets = false;
};

/// One at a time: the flight software lies in static memory.
class RamFlight {
 public:
  explicit RamFlight(const World& world);
  ~RamFlight();

  /// Component at work; stage_count: the executive itself, or none.
  [[nodiscard]] std::size_t at_work() const { return at_work_; }
  [[nodiscard]] const char* at_work_name() const;
  test::FailingStore& store() { return failing_; }
  [[nodiscard]] TimeNs now() { return clock_.now(); }

  /// Starts the software, as a supervisor would: again where it refuses, at most eight times. False: it
  /// cannot be started.
  bool start();
  /// Number of failed starts in a row, up to now.
  [[nodiscard]] int failed_starts() const { return failed_starts_; }
  /// One minor frame and the pause after it.
  void fly_frame();
  [[nodiscard]] bool drained() const { return software_->drained(); }
  /// Flies to the end: until all work has been done for some seconds, or the mission time is over.
  bool fly_until(TimeNs end_ns);

  [[nodiscard]] Results results();
  [[nodiscard]] Difference compare_with(const Results& expected, std::set<std::uint16_t>& events);

 private:
  class Probe;

  std::vector<std::byte> region_;
  RamStore ram_;
  test::FailingStore failing_{ram_};
  MemoryCamera camera_;
  MemoryLink link_;
  CameraModel model_;
  class Time final : public Clock {
   public:
    TimeNs now() override { return now_; }
    void sleep_until(TimeNs time) override { now_ = time > now_ ? time : now_; }
    TimeNs processor_time() override { return 0; }

   private:
    TimeNs now_ = 0;
  } clock_;
  MissionParameters mission_;
  RamNonvolatile nonvolatile_memory_;
  std::unique_ptr<PacketGround> ground_;  ///< null with an outbox
  FlightSoftware* software_ = nullptr;
  std::vector<Probe> probes_;
  std::size_t at_work_ = stage_count;
  int failed_starts_ = 0;
  TimeNs next_ns_ = 0;
};

}  // namespace ilp::faults
