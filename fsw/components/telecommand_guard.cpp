#include "fsw/components/telecommand_guard.hpp"

#include <algorithm>

namespace ilp {
namespace {

constexpr TimeNs between_news_ns = 10 * ns_per_s;

bool same(const SequenceMarks& a, const SequenceMarks& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end());
}

}  // namespace

constexpr CheckpointForm TelecommandGuard::checkpoint = checkpoint_form<State>(ComponentId::telecommand_guard, 1);

TelecommandGuard::TelecommandGuard(Store& store, PacketRouter& router, Clock& clock)
    : store_(store), router_(router), clock_(clock) {}

Status TelecommandGuard::restore() {
  const Status loaded = restore_checkpoint(store_, checkpoint, cursor_, state_);
  if (!restored(loaded)) return loaded;
  if (router_.authenticator() != nullptr) router_.authenticator()->resume(state_.marks);
  return loaded;
}

Status TelecommandGuard::keep_marks() {
  State after;
  after.marks = router_.authenticator()->marks();
  if (same(after.marks, state_.marks)) return {};
  Transaction transaction(store_);
  ILP_TRY(transaction.begin());
  ILP_TRY(save_checkpoint(store_, checkpoint, cursor_, after));
  ILP_TRY(transaction.commit());
  state_ = after;
  return {};
}

Status TelecommandGuard::news() {
  const std::uint32_t refused = router_.counts().refused;
  const TimeNs now = clock_.now();
  if (refused == told_refused_ || (told_ && now - told_ns_ < between_news_ns)) return {};
  const Status event{StatusCode::telecommands_refused, refused - told_refused_,
                     static_cast<std::int64_t>(router_.last_refusal().code)};
  told_refused_ = refused;
  told_ns_ = now;
  told_ = true;
  return event;
}

StepResult TelecommandGuard::step(TimeNs deadline) {
  static_cast<void>(deadline);
  if (!router_.authenticating()) {
    if (!router_.authentication_wanted() || told_off_) return {};
    told_off_ = true;
    return {StatusCode::authentication_off, false};
  }
  const Status kept = keep_marks();
  router_.release();
  return {kept.ok() ? news() : kept, false};
}

}  // namespace ilp
