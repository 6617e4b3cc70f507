#include "bsp/flight/node.hpp"

#include <algorithm>
#include <cstring>

#include "cfg/version.hpp"
#include "fsw/base/text.hpp"
#include "fsw/products/product_metadata.hpp"

namespace ilp {

Status Node::begin(const char* host, const MissionParameters& mission) {
  record_ = {};
  record_.id = node_number(stages_);
  copy_text(record_.host, host);
  copy_text(record_.version, software_version);
  record_.parameters = parameters_fingerprint(mission);
  record_.stages = stages_;
  record_.started_ns = record_.seen_ns = clock_.now();
  record_.connections = 1;
  asked_ = false;
  return is_primary(stages_) ? begin_as_primary() : write();
}

/// Processes of an earlier primary may run no more; those that do tell it again. Questions are numbered on, so that no
/// answer to an earlier primary counts for this one.
Status Node::begin_as_primary() {
  Transaction transaction(store_);
  ILP_TRY(transaction.begin());
  NodeRecord before;
  for (std::size_t n = 0; n < stage_count; ++n) {
    const Status found = next(store_, before.id, before);
    if (found.is(StatusCode::not_found)) break;
    if (!found.ok() && !found.is(StatusCode::record_damaged)) return found;
    if (!found.ok()) before.id = found.a;
    if (found.ok() && before.id == record_.id) record_.question = before.question;
    ILP_TRY(store_.erase(record_info<NodeRecord>(), before.id));
  }
  ILP_TRY(put(store_, record_));
  return transaction.commit();
}

Status Node::write() {
  Transaction transaction(store_);
  ILP_TRY(transaction.begin());
  ILP_TRY(put(store_, record_));
  return transaction.commit();
}

Status Node::keep_alive(const Executive& executive, std::uint32_t connections) {
  record_.seen_ns = clock_.now();
  record_.connections = connections;
  record_.overruns = executive.frame_overruns();
  record_.longest_ns = executive.timing().longest_ns;
  record_.steps = 0;
  for (const Stage& stage : schedule) {
    if (has_stage(stages_, stage.component)) record_.steps += executive.stats(stage.component).steps;
  }
  return write();
}

Status Node::question(std::int64_t& number) {
  number = 0;
  NodeRecord head;
  ILP_TRY(find_primary(store_, head));
  if (head.question != record_.question) number = head.question;
  return {};
}

Status Node::answer(std::int64_t number, std::int64_t commits) {
  record_.idle = asked_ && commits == answered_commits_;
  asked_ = true;
  record_.question = number;
  answered_commits_ = commits;
  return write();
}

Result<bool> Node::ask_whether_done(std::int64_t commits) {
  StageMask answered = stages_;
  bool all_idle = asked_ && commits == answered_commits_;
  NodeRecord other;
  // Bounded by the stages, of which every process has one.
  for (std::size_t n = 0; n < stage_count && next(store_, other.id, other).ok(); ++n) {
    if (other.id == record_.id || other.question != record_.question) continue;
    answered |= other.stages;
    all_idle = all_idle && other.idle;
  }
  const bool complete = answered == all_stages;
  if (complete && all_idle) return true;
  if (!complete && asked_) return false;
  ++record_.question;
  asked_ = true;
  answered_commits_ = commits;
  ILP_TRY(write());
  return false;
}

Status Node::report_end() {
  record_.idle = true;
  return write();
}

Status Node::poll_other_nodes(TimeNs silence, Update& updates) {
  updates = {};
  NodeRecord other;
  for (std::size_t n = 0; n < stage_count; ++n) {
    const Status found = next(store_, other.id, other);
    if (found.is(StatusCode::not_found)) return {};
    ILP_TRY(found);
    if (other.id == record_.id) continue;
    Other* known = nullptr;
    for (std::size_t i = 0; i < others_.size(); ++i) {
      if (others_[i].id == other.id) known = &others_[i];
    }
    const TimeNs now = clock_.now();
    const bool received = known == nullptr || known->started_ns != other.started_ns || known->seen_ns != other.seen_ns;
    const bool joined = known == nullptr || known->started_ns != other.started_ns || (known->silent && received);
    if (known == nullptr) {
      if (!others_.push_back({other.id, 0, 0, now, false})) return {};
      known = &others_.back();
    }
    if (received) *known = {other.id, other.started_ns, other.seen_ns, now, false};
    const bool falls_silent = !known->silent && now - known->received_ns > silence;
    known->silent = known->silent || falls_silent;
    if (!joined && !falls_silent) continue;
    updates = {joined ? Change::joined : Change::silent, other};
    return {};
  }
  return {};
}

Status find_primary(Store& store, NodeRecord& head) {
  return get(store, node_number(primary_stages), head);
}

Status check_primary(const NodeRecord& head, StageMask stages, const MissionParameters& mission) {
  const StageMask both = head.stages & stages;
  if (both != 0) return {StatusCode::stage_claimed, node_number(both)};
  if (std::strcmp(head.version, software_version) != 0) return StatusCode::store_build;
  const std::uint32_t own = parameters_fingerprint(mission);
  return head.parameters == own ? Status{} : Status{StatusCode::node_differs, own, head.parameters};
}

Status find_flight(Store& store, StageMask stages, const MissionParameters& mission, NodeRecord& head) {
  const Status found = find_primary(store, head);
  if (found.is(StatusCode::not_found) || (found.ok() && head.idle)) return StatusCode::not_ready;
  ILP_TRY(found);
  ILP_TRY(check_primary(head, stages, mission));
  IdentityRecord identity;
  CameraRecord camera;
  ILP_TRY(get(store, identity.id, identity));
  ILP_TRY(get(store, camera_id, camera));
  store.number_from(identity.keyframe_base, identity.record_base);
  return {};
}

}  // namespace ilp
