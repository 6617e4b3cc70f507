#include "fsw/commanding/telecommand_guard.hpp"

#include <algorithm>

namespace ilp {
namespace {

constexpr TimeNs between_news_ns = 10 * ns_per_s;
constexpr TimeNs longest_wait_ns = 10 * ns_per_s;

bool same(const SequenceMarks& a, const SequenceMarks& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end());
}

}  // namespace

constexpr CheckpointForm TelecommandGuard::checkpoint = checkpoint_form<State>(component_id);

TelecommandGuard::TelecommandGuard(Tables store, PacketRouter& router, Clock& clock, FlightMemory* memory)
    : store_(store), router_(router), clock_(clock), memory_(memory) {}

Status TelecommandGuard::restore() {
  const Status loaded = restore_checkpoint(store_, checkpoint, cursor_, state_);
  if (router_.authenticator() == nullptr) return loaded;
  if (restored(loaded)) router_.authenticator()->resume(state_.marks);
  if (memory_ == nullptr) return loaded;
  SequenceMarks marks;
  for (const SequenceMark& mark : memory_->content().marks) {
    if (mark.spi != 0) static_cast<void>(marks.push_back(mark));
  }
  router_.authenticator()->resume(marks);
  return loaded;
}

Status TelecommandGuard::keep_in_store(const State& after) {
  StepTransaction transaction(store_, checkpoint);
  ILP_TRY(transaction.begin());
  return transaction.commit(cursor_, after, cursor_);
}

Status TelecommandGuard::keep_in_memory(const SequenceMarks& marks) {
  if (memory_ == nullptr) return StatusCode::not_ready;
  FlightMemoryContent after = memory_->content();
  // Those of keys that are not in use now stay.
  for (const SequenceMark& mark : marks) {
    SequenceMark* place = nullptr;
    for (SequenceMark& kept : after.marks) {
      if (kept.spi == mark.spi) place = &kept;
    }
    for (SequenceMark& kept : after.marks) {
      if (place == nullptr && kept.spi == 0) place = &kept;
    }
    for (SequenceMark& kept : after.marks) {
      const bool in_use = std::any_of(marks.begin(), marks.end(), [&](const auto& m) { return m.spi == kept.spi; });
      if (place == nullptr && !in_use) place = &kept;
    }
    if (place == nullptr) return {StatusCode::capacity_exceeded, mark.spi};
    *place = {std::max(mark.highest, place->spi == mark.spi ? place->highest : 0U), mark.spi, 0};
  }
  return memory_->keep(after);
}

Status TelecommandGuard::keep_marks() {
  State after;
  after.marks = router_.authenticator()->marks();
  if (!failing_ && same(after.marks, state_.marks)) return {};
  const Status in_memory = keep_in_memory(after.marks);
  const Status in_store = keep_in_store(after);
  // Either of them is read at the next start.
  if (!in_memory.ok() && !in_store.ok()) return in_store;
  state_ = after;
  return {};
}

Status TelecommandGuard::go_before(const Status& fault) {
  const TimeNs now = clock_.now();
  if (!failing_) failing_ns_ = reported_failing_ns_ = now;
  failing_ = true;
  if (now - failing_ns_ < longest_wait_ns) return fault;
  unkept_ += static_cast<std::int64_t>(router_.waiting() - router_.released());
  router_.release();
  if (unkept_ == 0 || (now - reported_failing_ns_ < between_news_ns && reported_failing_ns_ != failing_ns_)) return {};
  const Status event{StatusCode::marks_not_kept, unkept_, (now - failing_ns_) / ns_per_s};
  unkept_ = 0;
  reported_failing_ns_ = now;
  return event;
}

Status TelecommandGuard::news() {
  const std::uint32_t refused = router_.counts().refused;
  const TimeNs now = clock_.now();
  if (refused == reported_refused_ || (reported_ && now - reported_ns_ < between_news_ns)) return {};
  const Status event{StatusCode::telecommands_refused, refused - reported_refused_,
                     static_cast<std::int64_t>(router_.last_refusal().code)};
  reported_refused_ = refused;
  reported_ns_ = now;
  reported_ = true;
  return event;
}

StepResult TelecommandGuard::step() {
  if (!router_.authenticating()) {
    if (!router_.authentication_wanted() || reported_off_) return {};
    reported_off_ = true;
    return {StatusCode::authentication_off, false};
  }
  const Status kept = keep_marks();
  if (!kept.ok()) return {go_before(kept), false};
  failing_ = false;
  router_.release();
  return {news(), false};
}

}  // namespace ilp
