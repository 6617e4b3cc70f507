#include "bsp/linux/shared_flight.hpp"

#include <unistd.h>

#include <cstdio>

#include "bsp/linux/board.hpp"

namespace ilp {
namespace {

constexpr std::int32_t nap_ms = 20;
constexpr std::int32_t nap_without_store_ms = 200;
constexpr TimeNs report_period = 2 * ns_per_s;
/// What nobody waits for is done while the camera is held, and after this many minor frames in any case.
constexpr std::uint32_t most_frames_put_off = 200;
/// In real time a process that tells nothing for this long is reported.
constexpr TimeNs silence = 10 * ns_per_s;

}  // namespace

Status SharedFlight::begin(const MissionParameters& mission) {
  return node_.begin(host_name().c_str(), mission);
}

bool SharedFlight::connected(Executive& executive) {
  if (sharing_.connected()) return true;
  if (!sharing_.reconnect().ok() || !executive.start().ok()) {
    static_cast<void>(::usleep(nap_without_store_ms * 1000));
    return false;
  }
  ++connections_;
  std::fprintf(stderr, "ilp-onboard: connected to the store again\n");
  return true;
}

Status SharedFlight::keep_alive(const Executive& executive) {
  // In virtual time the flight's own clock may stand still.
  const TimeNs now = board_clock_.now();
  if (now - reported_ns_ < report_period) return {};
  reported_ns_ = now;
  static_cast<void>(node_.keep_alive(executive, connections_));
  // A disk that refuses it is reported, because nothing can be sent meanwhile.
  ILP_TRY(sharing_.flush_or_later());
  Node::Update updates;
  if (virtual_time_ || !node_.poll_other_nodes(silence, updates).ok()) return {};
  switch (updates.change) {
    case Node::Change::joined:
      return {StatusCode::node_joined, updates.node.id, static_cast<std::int64_t>(updates.node.stages)};
    case Node::Change::silent:
      return {StatusCode::node_silent, updates.node.id, silence / ns_per_ms};
    case Node::Change::none:
      break;
  }
  return {};
}

void SharedFlight::put_off(Executive& executive, bool late_work) {
  late_work_waits_ = late_work;
  frames_put_off_ = late_work ? frames_put_off_ + 1 : 0;
  executive.put_off(late_work);
}

bool SharedFlight::waited(Executive& executive) {
  if (!virtual_time_) return false;
  const bool stands_still = held_camera_.held() || waits_for_end_;
  const bool waits = stands_still && !late_work_waits_;
  put_off(executive, !stands_still && frames_put_off_ < most_frames_put_off);
  if (waits) sharing_.wait(nap_ms);
  return stands_still;
}

bool SharedFlight::done(Executive& executive) {
  waits_for_end_ = true;
  if (!node_.ask_whether_done(store_.waking_commits()).value()) {
    executive.wake_all();
    return false;
  }
  return node_.report_end().ok();
}

}  // namespace ilp
