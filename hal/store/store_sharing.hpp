// What a store offers to a process that shares it with others, each of which runs a part of the stages.
#pragma once

#include <cstdint>

#include "fsw/base/status.hpp"

namespace ilp {

/// A set of stages: bit n is that of the component with the number n + 1 (cfg/schedule.hpp).
using StageMask = std::uint32_t;

/// Beside the Store interface of the same object.
class StoreSharing {
 public:
  StoreSharing() = default;
  StoreSharing(const StoreSharing&) = delete;
  StoreSharing& operator=(const StoreSharing&) = delete;

  /// Reserves stages for this process until it ends or release() is called: a stage that ran in two processes would do
  /// its work twice. `stage_claimed` (a = number of such a stage's component) reserves none of them.
  virtual Status claim(StageMask stages) = 0;
  virtual void release() = 0;
  /// False after a fault of the connection. The last commit may have been carried out or not, and the stages may be
  /// those of another process now: step nothing before reconnect() has succeeded and every stage is back at its
  /// checkpoint.
  [[nodiscard]] virtual bool connected() const = 0;
  /// Connects and claims the same stages again. All tables count as changed.
  virtual Status reconnect() = 0;
  /// What any process has committed before this call outlasts a power cut when it is ok. Within a transaction too. Call
  /// it before telling anything that was read to somebody outside.
  virtual Status flush() = 0;
  /// The same for what this process has committed itself. Outside a transaction. A store whose commits wait for the
  /// disk themselves has nothing to do.
  virtual Status flush_own() { return {}; }
  /// As flush(), where nothing waits for it: ok too if the connection is lost or the store is busy, because a later
  /// call makes up for it.
  Status flush_or_later() {
    const Status flushed = flush();
    const bool later =
        flushed.is(StatusCode::store_lost) || flushed.is(StatusCode::store_locked) || flushed.is(StatusCode::not_ready);
    return later ? Status{} : flushed;
  }
  /// Waits until another process may have changed a table, and for this long at most.
  virtual void wait(std::int32_t milliseconds) = 0;

 protected:
  ~StoreSharing() = default;
};

}  // namespace ilp
