// A board for FlightSoftware in virtual time, started as ilp-onboard does it: a database and a nonvolatile memory on a
// disk, a packet link to a ground station, keys, a calendar, and a camera that gives nothing.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "bsp/flight/flight_software.hpp"
#include "bsp/flight/flight_store.hpp"
#include "fsw/executive/frame_timing.hpp"
#include "fsw/packets/service_functions.hpp"
#include "fsw/packets/service_parameters.hpp"
#include "fsw/packets/service_verification.hpp"
#include "hal/link/outbox/outbox_link.hpp"
#include "hal/nonvolatile/file_nonvolatile.hpp"
#include "tests/support/fake_clock.hpp"
#include "tests/support/queue_link.hpp"
#include "tests/support/store_records.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp::test {

class NoCamera final : public Camera {
 public:
  Status capture(TimeNs now, FrameImage& image, CameraFrame& frame) override {
    static_cast<void>(now);
    static_cast<void>(image);
    static_cast<void>(frame);
    return StatusCode::not_ready;
  }
};

class FlightBoard {
 public:
  FlightBoard() { mission_file.trial_s = 60; }
  ~FlightBoard() { stop(); }
  FlightBoard(const FlightBoard&) = delete;
  FlightBoard& operator=(const FlightBoard&) = delete;

  /// Starts the flight as main.cpp does; the Status of what failed.
  Status start() {
    mission = mission_file;
    started_s_ = calendar_s;
    started_ns_ = clock.now();
    store = std::make_unique<FlightStore>(sqlite_, memory_region_);
    ILP_TRY(store->open(database().c_str(), StoreTrouble::fly_on, mission));
    nonvolatile_memory = std::make_unique<FileNonvolatile>();
    const Status opened = nonvolatile_memory->open(database().c_str());
    software = std::make_unique<FlightSoftware>(FlightDevices{.store = store->store(),
                                                              .camera = *eye,
                                                              .link = outbox,
                                                              .clock = clock,
                                                              .nonvolatile_memory = *nonvolatile_memory,
                                                              .packets = radio},
                                                mission);
    ILP_TRY(software->prepare({.nonvolatile_memory = opened,
                               .store = store->updates(),
                               .utc = calendar_s * ns_per_s,
                               .epoch = epoch_choice}));
    started_ns_ = software->time().now;
    clock.set(started_ns_);
    keys = Authenticator();
    for (const auto& [spi, key] : key_list) ILP_TRY(keys.add(spi, key));
    software->router().authenticate_with(keys);
    ILP_TRY(software->start(model));
    ILP_TRY(software->record_boot({}, store->start().in_order()));
    next_ = clock.now();
    return {};
  }
  /// Stops the flight as a power cut does, without notice.
  void stop() {
    if (software != nullptr) calendar_s = calendar_now();
    software.reset();
    nonvolatile_memory.reset();
    if (store != nullptr) store->close();
    store.reset();
  }
  Status restart() {
    stop();
    return start();
  }
  /// Mission time goes forward, between two minor frames, as when a calendar has become right.
  void jump_to(TimeNs time) {
    clock.set(time);
    next_ = time;
  }
  [[nodiscard]] std::int64_t calendar_now() { return started_s_ + (clock.now() - started_ns_) / ns_per_s; }
  /// Minor frames; ends where the software asks for a start.
  void fly(double seconds) {
    const TimeNs end = clock.now() + ns_from_seconds(seconds);
    while (clock.now() < end && !configuration().restart_wanted()) {
      software->executive().run_minor_frame(next_);
      next_ = next_frame_begin(next_, clock.now());
      clock.sleep_until(next_);
    }
  }
  /// Likewise, and starts the flight again when it asks for that, as the board's supervisor does.
  void fly_on(double seconds) {
    const TimeNs end = clock.now() + ns_from_seconds(seconds);
    while (clock.now() < end) {
      fly(static_cast<double>(end - clock.now()) / 1e9);
      if (configuration().restart_wanted()) {
        ++restarts;
        ASSERT_TRUE(restart().ok());
      }
    }
  }

  Octets packet(int service, int subtype, const Octets& data) {
    Telecommand telecommand;
    telecommand.primary.apid = apid;
    telecommand.primary.sequence_count = count_++;
    telecommand.ack_flags = 0x0F;
    telecommand.service = static_cast<std::uint8_t>(service);
    telecommand.subtype = static_cast<std::uint8_t>(subtype);
    telecommand.source = 1;
    telecommand.data = data;
    Octets octets(13 + data.size());
    std::size_t bytes = 0;
    EXPECT_TRUE(encode_telecommand(telecommand, octets, bytes).ok());
    return octets;
  }
  Octets sealed(const Octets& plain, std::uint32_t sequence) {
    Octets out(plain.size() + security_bytes);
    std::size_t bytes = 0;
    EXPECT_TRUE(seal(plain, key_list[0].first, sequence, key_list[0].second, out, bytes).ok());
    return out;
  }
  void send(const Octets& octets) { link.up.push_back(octets); }
  Octets setting(const char* section, const char* key, double value) {
    const std::size_t index = find_parameter(section, key);
    Octets octets(64);
    ByteWriter out(octets);
    out.u16(1);
    out.u16(parameter_info(index).number);
    write_value(parameter_info(index).type, value, out);
    octets.resize(out.size());
    return packet(parameter_management::service, parameter_management::set, octets);
  }
  Octets ping_packet() { return packet(17, 1, {}); }
  /// Whether the octets that were sent are answered: "1.1 1.3 17.2 1.7". Everything else is left out.
  std::string answers(double within_s = 2) {
    link.down.clear();
    fly(within_s);
    std::string text;
    for (const Octets& octets : link.down) {
      const bool own = octets.size() >= 9 && ((octets[0] & 7U) << 8U | octets[1]) == apid;
      if (!own || (octets[7] != 1 && octets[7] != 17)) continue;
      text += (text.empty() ? "" : " ") + std::to_string(octets[7]) + "." + std::to_string(octets[8]);
    }
    return text;
  }
  std::string set(const char* section, const char* key, double value) {
    send(setting(section, key, value));
    return answers(0.3);
  }
  bool ping() {
    send(ping_packet());
    return answers() == "1.1 1.3 17.2 1.7";
  }

  Configuration& configuration() { return software->configuration(); }
  FlightMemory& memory() { return configuration().memory(); }
  [[nodiscard]] std::string database() const { return folder / "flight.db"; }
  std::vector<EventRecord> events(StatusCode code) { return events_of(store->store(), code); }
  [[nodiscard]] double in_force(const char* section, const char* key) const {
    return parameter_value(mission, find_parameter(section, key));
  }

  TemporaryFolder folder;
  MissionParameters mission_file;
  CameraModel model{640, 480, 600, 600, 319.5, 239.5, 0, 0, 0, 0};
  std::int64_t calendar_s = 2'145'916'800 + 1000;
  EpochChoice epoch_choice = EpochChoice::first_start;
  std::uint16_t apid = 239;
  std::vector<std::pair<std::uint16_t, Octets>> key_list;
  int restarts = 0;

  MissionParameters mission;
  StillClock clock;
  QueueLink link;
  PacketLink* radio = &link;
  NoCamera camera;
  Camera* eye = &camera;
  OutboxLink outbox;
  Authenticator keys;
  std::unique_ptr<FlightStore> store;
  std::unique_ptr<FileNonvolatile> nonvolatile_memory;
  std::unique_ptr<FlightSoftware> software;

 private:
  Arena sqlite_;  // of a host: SQLite has the system's heap
  alignas(Arena::alignment) static inline std::byte memory_region_[limits::ram_store_bytes];
  std::int64_t started_s_ = 0;
  TimeNs started_ns_ = 0;
  TimeNs next_ = 0;
  std::uint16_t count_ = 0;
};

}  // namespace ilp::test
