// The records by which processes that share a flight know of each other (NodeRecord), and how the primary finds out
// that no process has work left.
#pragma once

#include "bsp/flight/stage_set.hpp"
#include "fsw/base/result.hpp"
#include "fsw/executive/executive.hpp"
#include "hal/clock/clock.hpp"
#include "hal/store/store.hpp"

namespace ilp {

/// The primary finds the end of a flight in virtual time by numbered questions. It asks when it has no more work
/// itself. Another process answers when its stages have no work. Its answer is `idle` if its stages have also changed
/// nothing since its previous answer. If all processes answer a question with `idle`, no process changed anything when
/// the question was asked, and every process had seen all changes and had no work: the flight is done.
class Node {
 public:
  /// `store` is the one below SharedFlightStore, so that node records do not count as work.
  Node(Store& store, Clock& clock, StageMask stages) : store_(store), clock_(clock), stages_(stages) {}

  /// Writes the record of this process; a primary erases those of all others. `mission` has only the parameters of the
  /// mission file.
  Status begin(const char* host, const MissionParameters& mission);
  /// Writes the record again, with the present time and counts. `connections` counts the connections to the store. Call
  /// it every second or two.
  Status keep_alive(const Executive& executive, std::uint32_t connections);

  /// For a process that is not the primary: reads the number of the primary's latest question; 0: it is answered.
  Status question(std::int64_t& number);
  /// Answers a question. The caller has let every stage look for work since question() returned, and none has found
  /// any. `commits` is SharedFlightStore::waking_commits().
  Status answer(std::int64_t number, std::int64_t commits);

  /// For the primary, when it has no work: asks a question, or the next one if a process was not idle. Returns true if
  /// the processes that answered `idle` to the latest question run all other stages, and the primary has changed
  /// nothing since. `commits` is SharedFlightStore::waking_commits().
  Result<bool> ask_whether_done(std::int64_t commits);
  /// For the primary: writes that the flight is done, so that the other processes end.
  Status report_end();

  /// What the primary reports about another process: it has begun to run, or has stopped writing its record.
  enum class Change : std::uint8_t { none, joined, silent };
  struct Update {
    Change change = Change::none;
    NodeRecord node;
  };
  /// For the primary: finds a process that has joined since the previous call, or whose record has not changed for
  /// `silence` ns of this process's clock. Finds one change in each call; call it again until there is none.
  Status poll_other_nodes(TimeNs silence, Update& updates);

 private:
  struct Other {
    std::int64_t id = 0;
    TimeNs started_ns = 0, seen_ns = 0;  ///< values in its latest record
    TimeNs received_ns = 0;              ///< when that record was first read, by this process's clock
    bool silent = false;                 ///< was reported as silent
  };

  Status begin_as_primary();
  Status write();

  Store& store_;
  Clock& clock_;
  StageMask stages_;
  NodeRecord record_;
  bool asked_ = false;                 ///< a question was asked, or answered, since begin()
  std::int64_t answered_commits_ = 0;  ///< `commits` of the latest question or answer
  FixedVector<Other, stage_count> others_;
};

/// Reads the primary's record. Returns `not_found` if no primary has begun to share the flight.
Status find_primary(Store& store, NodeRecord& head);
/// Checks whether this process may join the primary. Returns `stage_claimed` (first value: component number) if the
/// primary runs one of `stages`, `store_build` if it has another version of the software, and `node_differs` (first
/// value: fingerprint of `mission`, second: that of the primary's mission) if its mission parameters differ.
Status check_primary(const NodeRecord& head, StageMask stages, const MissionParameters& mission);

/// For a process that is not the primary: finds the primary and sets the store's id_base() to that of the flight.
/// Returns `not_ready` if there is no primary or it has ended, `not_found` if it has not yet written identity and
/// camera, else the Status of check_primary().
Status find_flight(Store& store, StageMask stages, const MissionParameters& mission, NodeRecord& head);

}  // namespace ilp
