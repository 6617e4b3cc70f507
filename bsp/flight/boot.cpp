#include "bsp/flight/boot.hpp"

#include <algorithm>
#include <cstring>

#include "cfg/limits.hpp"
#include "cfg/version.hpp"
#include "fsw/base/text.hpp"

namespace ilp {
namespace {

StartReason reason_after(const StartRecord& before, const BoardState& board) {
  if (before.end_ns != 0) return StartReason::stopped;
  if (board.watchdog_had_bitten) return StartReason::watchdog;
  const bool same_boot = board.boot[0] != 0 && std::strcmp(board.boot, before.board) == 0;
  return same_boot ? StartReason::process_died : StartReason::board_reset;
}

}  // namespace

Status Boot::begin(const BoardState& board) {
  StartRecord before;
  const Status found = last(store_, before);
  // A damaged record of the previous boot does not prevent the next one.
  const bool damaged = found.is(StatusCode::record_damaged);
  if (!found.ok() && !found.is(StatusCode::not_found) && !damaged) return found;
  record_ = {};
  record_.id = (found.ok() ? before.id : damaged ? found.a : store_.id_base(RecordType::start)) + 1;
  record_.time_ns = clock_.now();
  if (damaged) before = {};
  record_.reason = found.ok() || damaged ? reason_after(before, board) : StartReason::first;
  copy_text(record_.version, software_version);
  copy_text(record_.board, board.boot);
  return go_on();
}

Status Boot::go_on() {
  record_.alive_ns = clock_.now();
  return write();
}

Status Boot::end() {
  // 0 means that it has not ended.
  record_.end_ns = std::max<TimeNs>(clock_.now(), 1);
  record_.alive_ns = record_.end_ns;
  return write();
}

Status Boot::write() {
  Transaction transaction(store_);
  ILP_TRY(transaction.begin());
  ILP_TRY(put(store_, record_));
  const std::int64_t too_old = record_.id - limits::max_starts;
  if (too_old > 0) {
    const Status erased = store_.erase(record_info(RecordType::start), too_old);
    if (!erased.ok() && !erased.is(StatusCode::not_found)) return erased;
  }
  return transaction.commit();
}

}  // namespace ilp
