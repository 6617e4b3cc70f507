// What a process that shares the flight tells the others about itself (record `node`), and how the primary finds out
// that nobody has anything left to do.
#pragma once

#include "bsp/flight/stage_set.hpp"
#include "fsw/base/result.hpp"
#include "fsw/executive/executive.hpp"
#include "hal/clock/clock.hpp"
#include "hal/store/store.hpp"

namespace ilp {

/// The end of a flight in virtual time is found by questions. The primary asks when it has no more work itself. A
/// process answers when its stages have none; it says `idle` if they have also changed nothing since its previous
/// answer. If all are idle on one question, then nobody changed anything around the moment at which it was asked,
/// everybody had seen all changes and had no work: the flight is done.
class Node {
 public:
  /// `store` is the one below SharedFlightStore, so that these records do not count as work.
  Node(Store& store, Clock& clock, StageMask stages) : store_(store), clock_(clock), stages_(stages) {}

  /// Begins to tell. `mission` has the parameters of the mission file alone.
  Status begin(const char* host, const MissionParameters& mission);
  /// Tells that the process still runs; `connections` counts the connections to the store. Call it every second or two.
  Status keep_alive(const Executive& executive, std::uint32_t connections);

  /// For a process that is not the primary: the number of the primary's question, 0 if it is answered already.
  Status question(std::int64_t& number);
  /// Answers it. Since the question was read every stage has looked for work, and has found none. `commits`:
  /// SharedFlightStore::waking_commits().
  Status answer(std::int64_t number, std::int64_t commits);

  /// For the primary, when it has no work: asks, or asks again if somebody was not idle. True when all others were idle
  /// on the latest question, they run all stages that the primary does not run, and it has changed nothing since.
  Result<bool> ask_whether_done(std::int64_t commits);
  /// For the primary: the flight is done, and the other processes end.
  Status report_end();

  /// The primary tells this of another process.
  enum class Change : std::uint8_t { none, joined, silent };
  struct Update {
    Change change = Change::none;
    NodeRecord node;
  };
  /// For the primary: who has begun to run since the previous call, or has told nothing for `silence` of this process'
  /// time. At most one of them; call it again until there is none.
  Status poll_other_nodes(TimeNs silence, Update& updates);

 private:
  struct Other {
    std::int64_t id = 0;
    TimeNs started_ns = 0, seen_ns = 0;
    TimeNs received_ns = 0;  ///< by this process' clock
    bool silent = false;
  };

  Status begin_as_primary();
  Status write();

  Store& store_;
  Clock& clock_;
  StageMask stages_;
  NodeRecord record_;
  bool asked_ = false;  ///< a question was asked, or answered, since begin()
  std::int64_t answered_commits_ = 0;
  FixedVector<Other, stage_count> others_;
};

/// The primary's record: `not_found` before a primary has begun to share the flight.
Status find_primary(Store& store, NodeRecord& head);
/// `stage_claimed` (a = number) if another process is the one to run a stage of `stages`, `node_differs` (a = this
/// mission's checksum, b = the primary's) for another mission, `store_build` for another version of the software.
Status check_primary(const NodeRecord& head, StageMask stages, const MissionParameters& mission);

/// For a process that is not the primary: `not_ready` while there is no primary, or it has ended, `not_found` while it
/// has not written identity and camera; else as check_primary(). When it is ok, the store numbers new records as the
/// flight does.
Status find_flight(Store& store, StageMask stages, const MissionParameters& mission, NodeRecord& head);

}  // namespace ilp
