// A flight that is small enough to be flown ten thousand times: sixteen images of 160 x 120 pixels, half a second
// apart, with everything that flies on board, in virtual time.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "bsp/flight/flight_software.hpp"
#include "bsp/flight/flight_store.hpp"
#include "tests/faults/commit_ledger.hpp"
#include "tests/support/failing_store.hpp"

namespace ilp::faults {

/// Renders the images into `folder`, unless they are there.
void prepare_world(const std::filesystem::path& folder);

/// How a boot of the flight software ended; the exit status of its process.
enum BootEnd : int {
  boot_done = 0,      ///< everything has been worked through, sent and confirmed
  boot_restart = 3,   ///< the database was found damaged: the supervisor starts the software again
  boot_refused = 4,   ///< the flight did not start
  boot_overtime = 5,  ///< the mission time that the trial grants is over
  boot_broken = 6,    ///< the harness itself has failed
  boot_killed = 7,    ///< by the trial
  boot_ended = 8      ///< in order, by the trial's command
};

/// What a process leaves outside its store, however it ends: in memory that it shares with its parent.
struct Traces {
  TimeNs now_ns = 0;            ///< mission time
  std::int64_t frames = 0;      ///< minor frames of this boot
  std::int64_t calls = 0;       ///< of the store
  std::uint32_t updates = 0;    ///< statuses that `statuses` holds
  std::uint16_t statuses[8]{};  ///< reported on standard error at start-up
};

/// Where a boot can be looked at, or harmed. All may be empty.
struct Hooks {
  std::function<void()> begin;               ///< before the database is opened
  std::function<void()> started;             ///< the components are restored
  std::function<void()> again;               ///< the same in the boots behind the one that is harmed
  std::function<void(std::int64_t)> frame;   ///< before each minor frame, with its number in this boot
  std::function<void()> step;                ///< before and after each step of a component
  test::FailingStore::Judge call;            ///< of the store, by the components
  std::function<bool()> ends;                ///< before each minor frame: true ends the boot in order
  CommitLedger* ledger = nullptr;            ///< of what is committed to the disk
  std::function<void(Store&)> without_disk;  ///< at the end of a boot whose store was in memory
};

/// The static memory of the flight.
struct StaticMemory {
  FlightStore* store = nullptr;
  FlightSoftware* software = nullptr;
  MissionParameters* mission = nullptr;
  std::span<std::byte> sqlite;
};
[[nodiscard]] const StaticMemory& static_memory();

enum class Downlinks : std::uint8_t {
  outbox,  ///< whole files in a folder
  packets  ///< telemetry in packets, and files by CFDP
};

/// Once in the process that starts the boots, before the first of them: SQLite gets its arena, the flight its memory.
void prepare_process(Downlinks downlinks);

/// One boot on `folder`/flight.db with the outbox beside it, as ilp-onboard with --fly-on runs it: to be called once
/// in a process of its own. Goes on at traces.now_ns and ends `grace_ns` after everything is done, or at `end_ns`.
BootEnd live(const std::filesystem::path& world, const std::filesystem::path& folder, TimeNs end_ns, Traces& traces,
             const Hooks& hooks);

inline constexpr TimeNs grace_ns = 10 * ns_per_s;

/// The same flight on a store in this process, for trials that branch off between two calls of the store.
[[nodiscard]] MissionParameters tiny_mission();
[[nodiscard]] CameraModel tiny_camera(const std::filesystem::path& world);

}  // namespace ilp::faults
