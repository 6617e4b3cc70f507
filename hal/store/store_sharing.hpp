// Interface by which processes share a store: each process claims the stages that it runs, and can wait for changes and
// for the disk.
#pragma once

#include <cstdint>

#include "fsw/base/status.hpp"

namespace ilp {

/// A set of stages: bit n stands for component number n + 1 (cfg/schedule.hpp).
using StageMask = std::uint32_t;

/// A shared store implements this interface and Store.
class StoreSharing {
 public:
  StoreSharing() = default;
  StoreSharing(const StoreSharing&) = delete;
  StoreSharing& operator=(const StoreSharing&) = delete;

  /// Reserves stages for this process until it ends or calls release(), because a stage that ran in two processes would
  /// do its work twice. Returns `stage_claimed` (first value: component number of a stage) if another process has one
  /// of them; none is reserved then.
  virtual Status claim(StageMask stages) = 0;
  /// Releases all stages of this process.
  virtual void release() = 0;
  /// False after a fault of the connection. It is then unknown whether the last commit was carried out, and another
  /// process may have claimed the stages. Step no stage until reconnect() has succeeded and every stage has gone back
  /// to its checkpoint.
  [[nodiscard]] virtual bool connected() const = 0;
  /// Connects and claims the same stages again. All tables count as changed.
  virtual Status reconnect() = 0;
  /// Waits until all commits of all processes before this call are on the disk, so that a power cut cannot undo them.
  /// May be called within a transaction. Call it before sending data that was read from the store to the ground.
  virtual Status flush() = 0;
  /// Waits until all commits of this process are on the disk. Must be called outside a transaction. Does nothing in a
  /// store whose commits wait for the disk.
  virtual Status flush_own() { return {}; }
  /// Calls flush(), and returns ok also if the connection is lost or the store is busy. For callers that need not wait,
  /// because a later flush() covers the same commits.
  Status flush_or_later() {
    const Status flushed = flush();
    const bool later =
        flushed.is(StatusCode::store_lost) || flushed.is(StatusCode::store_locked) || flushed.is(StatusCode::not_ready);
    return later ? Status{} : flushed;
  }
  /// Waits until another process may have changed a table, at most for this time.
  virtual void wait(std::int32_t milliseconds) = 0;

 protected:
  ~StoreSharing() = default;
};

}  // namespace ilp
