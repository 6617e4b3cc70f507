// One trial: a flight whose first boot is harmed, and whose later boots follow as a supervisor would start them; then
// what has become of it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "tests/faults/results.hpp"
#include "tests/faults/tiny_flight.hpp"

namespace ilp::faults {

enum class Outcome : std::uint8_t {
  harmless,  ///< nothing differs, and nothing was reported
  mended,    ///< nothing differs, and the flight reported a fault
  lost,      ///< something is missing or differs, and the flight reported a fault
  silent,    ///< something is missing or differs, and nothing was reported
  locked,    ///< the software cannot be started any more
  broken,    ///< the harness has failed
  kinds
};
[[nodiscard]] const char* outcome_name(Outcome outcome);

struct Verdict {
  Outcome outcome = Outcome::broken;
  std::uint8_t boots = 0;
  bool crashed = false;
  bool hung = false;
  bool overtime = false;
  bool refused_valid = false;   ///< a start refused, mended or quarantined a valid database (file_faults.cpp)
  bool confirmed_lost = false;  ///< what a commit had confirmed, or counts as confirmed by the ground, was not there
  int signal = 0;               ///< of the first crash
  Difference difference;
  std::uint32_t codes = 0;  ///< that the undisturbed flight does not have, in `code`
  std::uint16_t code[12]{};
};

/// The undisturbed flight, and where it stood at the beginning of each of its minor frames.
struct Reference {
  std::filesystem::path world;
  std::filesystem::path folder;
  Results results;
  std::int64_t frames = 0;  ///< minor frames until everything was done
  TimeNs end_ns = 0;
  std::vector<std::int64_t> hooks;  ///< steps and calls of the store in each minor frame
  std::set<std::uint16_t> usual;    ///< events of a flight that is started again now and then

  /// The folder as it stood before a minor frame whose number is a multiple of `snapshot_frames`.
  /// A flight that ended in order leaves no log, and says so; another one is not to be trusted.
  [[nodiscard]] std::filesystem::path snapshot(std::int64_t frame, bool in_order = false) const;
  /// Records of that moment that are as they will be at the end.
  [[nodiscard]] const std::set<RecordKey>& settled(std::int64_t frame) const;
  void settle();

 private:
  std::vector<std::set<RecordKey>> settled_;
};
inline constexpr std::int64_t snapshot_frames = 4;

/// Flies the reference in `folder`, and once more from every snapshot: what differs then is a failure of the harness,
/// and ends the program.
Reference fly_reference(const std::filesystem::path& world, const std::filesystem::path& folder);

/// A copy of the snapshot that may be spoilt.
void copy_snapshot(const std::filesystem::path& from, const std::filesystem::path& to);

/// Runs in a process of its own, with a limit on its processor time that stands for the watchdog. True when it ended by
/// itself, with `status` as its exit status; else `status` is the signal.
bool run_apart(const std::function<int()>& body, int& status);
/// The simulated disk copies a file at every synchronisation, of which a boot with a reader beside it makes hundreds.
inline constexpr int watchdog_seconds = 120;

/// Memory that processes share, zero at first.
[[nodiscard]] void* share(std::size_t bytes);
void unshare(void* memory, std::size_t bytes);

/// For a trial that is repeated alone: prints how each boot ended.
inline bool boots_described = false;

/// Flies `folder` on from `now_ns` with `hooks` in its first boot, to its end.
/// `between` is called after each boot but the last, with the number of boots so far.
Verdict fly_trial(const Reference& reference, const std::filesystem::path& folder, TimeNs now_ns,
                  const std::set<RecordKey>& settled, Traces& traces, const Hooks& hooks,
                  const std::function<void(int)>& between = {});

/// Calls trial(number, worker) for all numbers, in `jobs` processes. Results lie in shared memory.
void run_trials(std::int64_t trials, int jobs, const std::function<void(std::int64_t, int)>& trial);

}  // namespace ilp::faults
