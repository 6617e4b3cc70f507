#include "fsw/commanding/telecommand_guard.hpp"

#include <algorithm>

namespace ilp {
namespace {

constexpr TimeNs between_updates_ns = 10 * ns_per_s;
constexpr TimeNs longest_wait_ns = 10 * ns_per_s;

bool same(const SequenceMarks& a, const SequenceMarks& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end());
}

}  // namespace

constexpr CheckpointForm TelecommandGuard::checkpoint = checkpoint_form<State>(component_id);

TelecommandGuard::TelecommandGuard(Tables store, PacketRouter& router, Clock& clock, FlightMemory* memory)
    : wiring_{store, router, clock, memory} {}

Status TelecommandGuard::restore() {
  const Status loaded = restore_checkpoint(wiring_.store, checkpoint, cursor_, state_);
  if (wiring_.router.authenticator() == nullptr) return loaded;
  if (restored(loaded)) wiring_.router.authenticator()->resume(state_.marks);
  if (wiring_.memory == nullptr) return loaded;
  SequenceMarks marks;
  for (const SequenceMark& mark : wiring_.memory->content().marks) {
    if (mark.spi != 0) static_cast<void>(marks.push_back(mark));
  }
  wiring_.router.authenticator()->resume(marks);
  return loaded;
}

Status TelecommandGuard::keep_in_store(State& after) {
  StepTransaction transaction(wiring_.store, checkpoint);
  ILP_TRY(transaction.begin());
  return transaction.commit(cursor_, after, cursor_);
}

Status TelecommandGuard::keep_in_memory(const SequenceMarks& marks) {
  if (wiring_.memory == nullptr) return StatusCode::not_ready;
  FlightMemoryContent after = wiring_.memory->content();
  // Those of keys that are not in use now stay.
  for (const SequenceMark& mark : marks) {
    const auto place_where = [&](const auto& fits) {
      return std::find_if(after.marks.begin(), after.marks.end(), fits);
    };
    const auto in_use = [&](const SequenceMark& kept) {
      return std::any_of(marks.begin(), marks.end(), [&](const auto& m) { return m.spi == kept.spi; });
    };
    auto place = place_where([&](const SequenceMark& kept) { return kept.spi == mark.spi; });
    if (place == after.marks.end()) place = place_where([](const SequenceMark& kept) { return kept.spi == 0; });
    if (place == after.marks.end()) place = place_where([&](const SequenceMark& kept) { return !in_use(kept); });
    if (place == after.marks.end()) return {StatusCode::capacity_exceeded, mark.spi};
    *place = {std::max(mark.highest, place->spi == mark.spi ? place->highest : 0U), mark.spi, 0};
  }
  return wiring_.memory->keep(after);
}

Status TelecommandGuard::keep_marks() {
  State after;
  after.marks = wiring_.router.authenticator()->marks();
  if (!workspace_.failing && same(after.marks, state_.marks)) return {};
  const Status in_memory = keep_in_memory(after.marks);
  const Status in_store = keep_in_store(after);
  // Either of them is read at the next start.
  if (!in_memory.ok() && !in_store.ok()) return in_store;
  state_ = after;
  return {};
}

Status TelecommandGuard::go_before(const Status& fault) {
  const TimeNs now = wiring_.clock.now();
  if (!workspace_.failing) workspace_.failing_ns = workspace_.reported_failing_ns = now;
  workspace_.failing = true;
  if (now - workspace_.failing_ns < longest_wait_ns) return fault;
  workspace_.unkept += static_cast<std::int64_t>(wiring_.router.waiting() - wiring_.router.released());
  wiring_.router.release();
  if (workspace_.unkept == 0 || (now - workspace_.reported_failing_ns < between_updates_ns &&
                                 workspace_.reported_failing_ns != workspace_.failing_ns))
    return {};
  const Status event{StatusCode::marks_not_kept, workspace_.unkept, (now - workspace_.failing_ns) / ns_per_s};
  workspace_.unkept = 0;
  workspace_.reported_failing_ns = now;
  return event;
}

Status TelecommandGuard::updates() {
  const std::uint32_t refused = wiring_.router.counts().refused;
  const TimeNs now = wiring_.clock.now();
  if (refused == workspace_.reported_refused ||
      (workspace_.reported && now - workspace_.reported_ns < between_updates_ns))
    return {};
  const Status event{StatusCode::telecommands_refused, refused - workspace_.reported_refused,
                     static_cast<std::int64_t>(wiring_.router.last_refusal().code)};
  workspace_.reported_refused = refused;
  workspace_.reported_ns = now;
  workspace_.reported = true;
  return event;
}

StepResult TelecommandGuard::step() {
  if (!wiring_.router.authenticating()) {
    if (!wiring_.router.authentication_wanted() || workspace_.reported_off) return {};
    workspace_.reported_off = true;
    return {StatusCode::authentication_off, false};
  }
  const Status kept = keep_marks();
  if (!kept.ok()) return {go_before(kept), false};
  workspace_.failing = false;
  wiring_.router.release();
  return {updates(), false};
}

}  // namespace ilp
