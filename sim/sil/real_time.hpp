// Clock, packet links, keys, stop signals, stall detection and the simulated ground receiver of a flight in ilp-sil.
#pragma once

#include <filesystem>
#include <memory>
#include <set>
#include <string>

#include "bsp/flight/packet_links.hpp"
#include "cfg/mission.hpp"
#include "fsw/base/time.hpp"
#include "fsw/packets/authentication.hpp"
#include "hal/clock/real_clock.hpp"
#include "hal/clock/virtual_clock.hpp"
#include "hal/store/store.hpp"
#include "sim/sil/sil_flight.hpp"

namespace ilp::sil {

/// Virtual time from `start` on, or for `real` the board's clock, which must be set first.
class FlightClock final : public Clock {
 public:
  FlightClock(bool real, TimeNs start) : real_(real), virtual_clock_(start) {}

  /// Sets the time. Virtual time never decreases.
  void set(TimeNs time) {
    if (real_) return real_clock_.set(time);
    virtual_clock_.sleep_until(time);
  }

  TimeNs now() override { return clock().now(); }
  void sleep_until(TimeNs time) override { clock().sleep_until(time); }
  TimeNs processor_time() override { return clock().processor_time(); }

 private:
  Clock& clock() { return real_ ? static_cast<Clock&>(real_clock_) : virtual_clock_; }

  bool real_;
  RealClock real_clock_;
  VirtualClock virtual_clock_;
};

/// Opens the packet links of the options and reports their addresses on standard error. Throws std::runtime_error that
/// names the wrong address.
std::unique_ptr<PacketLinks> open_links(const FlightOptions& options, Clock& clock);

/// Reads the keys of telecommand authentication. Throws std::runtime_error if the key file is wrong, or if the mission
/// needs one and none is named.
void read_keys(const FlightOptions& options, const MissionParameters& mission, Authenticator& keys);

/// Makes SIGTERM and SIGINT request an orderly end of the flight, which `stop_requested` reports.
void catch_stop_signals();
[[nodiscard]] bool stop_requested();

// Detects a flight that does not end.

/// Detects a flight without progress. Progress is a new record, except events and housekeeping, or a changed cursor of
/// a component.
class StallGuard {
 public:
  /// `longest`: mission time without progress that is still plausible.
  explicit StallGuard(TimeNs longest) : longest_(longest) {}
  /// Call this regularly. True if there was no progress for more than the longest time.
  bool stalled(Store& store, TimeNs now);

 private:
  TimeNs longest_;
  std::uint64_t fingerprint_ = 0;
  TimeNs changed_ns_ = -1;
};

// Stands for the ground at the other end of the link in a simulated flight: confirms every complete file of the outbox.

class Receiver {
 public:
  Receiver(std::filesystem::path outbox, std::filesystem::path acknowledgements);
  /// Confirms the files that have arrived since the last call.
  void receive();
  /// Bytes and files that were confirmed.
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }
  [[nodiscard]] std::size_t files() const { return seen_.size(); }

 private:
  std::filesystem::path outbox_;
  std::filesystem::path acknowledgements_;
  std::set<std::string> seen_;
  std::uint64_t bytes_ = 0;
};

}  // namespace ilp::sil
