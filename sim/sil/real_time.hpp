// What only a flight in real time has: the board's clock, packet links, an end from outside.
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

/// Virtual time from `start` on, or real time once it is set.
class FlightClock final : public Clock {
 public:
  FlightClock(bool real, TimeNs start) : real_(real), virtual_clock_(start) {}

  /// Virtual time never goes back.
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

/// Says on standard error where they listen. std::runtime_error names the address at fault.
std::unique_ptr<PacketLinks> open_links(const FlightOptions& options, Clock& clock);

/// Reads the keys of telecommand authentication. std::runtime_error names what is wrong with the file, or says that the
/// mission needs one.
void read_keys(const FlightOptions& options, const MissionParameters& mission, Authenticator& keys);

/// SIGTERM and SIGINT end the flight in good order.
void catch_stop_signals();
[[nodiscard]] bool stop_requested();

// Notices a flight that does not end.

/// Progress is a new record of any kind but events and housekeeping, or a component's cursor that moves.
class StallGuard {
 public:
  /// `longest`: mission time without progress that is still plausible.
  explicit StallGuard(TimeNs longest) : longest_(longest) {}
  /// Must be called regularly. True if there has been no progress for too long.
  bool stalled(Store& store, TimeNs now);

 private:
  TimeNs longest_;
  std::uint64_t fingerprint_ = 0;
  TimeNs changed_ns_ = -1;
};

// The far end of the link while a flight is simulated: confirms every whole file of the outbox.

class Receiver {
 public:
  Receiver(std::filesystem::path outbox, std::filesystem::path acknowledgements);
  /// Confirms what has arrived since the last call.
  void receive();
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }
  [[nodiscard]] std::size_t files() const { return seen_.size(); }

 private:
  std::filesystem::path outbox_;
  std::filesystem::path acknowledgements_;
  std::set<std::string> seen_;
  std::uint64_t bytes_ = 0;
};

}  // namespace ilp::sil
