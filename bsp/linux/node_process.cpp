#include "bsp/linux/node_process.hpp"

#include <unistd.h>

#include <cstdio>
#include <new>
#include <optional>

#include "bsp/flight/lock_lease.hpp"
#include "bsp/flight/node.hpp"
#include "bsp/flight/shared_flight_store.hpp"
#include "bsp/linux/board.hpp"
#include "bsp/linux/status_line.hpp"
#include "bsp/memory/flight_heap.hpp"
#include "hal/clock/real_clock.hpp"
#include "hal/nonvolatile/ram_nonvolatile.hpp"

namespace ilp {
namespace {

constexpr int exit_restart = 3;
/// Longest wait for a change when nothing is to be done.
constexpr std::int32_t nap_ms = 50;
constexpr std::int32_t nap_before_primary_ms = 50;
constexpr TimeNs report_period = 2 * ns_per_s;

/// What has no place in a process without camera and links.
class NoCamera final : public Camera {
 public:
  Status capture(TimeNs, FrameImage&, CameraFrame&) override { return StatusCode::not_ready; }
};
class NoLink final : public Link {
 public:
  Status begin_file(const char*) override { return StatusCode::not_ready; }
  Status write(std::span<const std::uint8_t>) override { return StatusCode::not_ready; }
  Status end_file() override { return StatusCode::not_ready; }
  Status acknowledged(const char*, std::uint32_t&, std::uint32_t&) override { return StatusCode::not_ready; }
};

class NodeProcess {
 public:
  NodeProcess(const Options& options, StageMask stages, const FlightPlace& place,
              const volatile std::sig_atomic_t& stop)
      : options_(options), stages_(stages), place_(place), stop_(stop), store_(place.store) {}

  int run();

 private:
  bool ask_for_priority();
  bool wait_for_primary();
  bool start();
  void step();
  void poll_primary();
  void keep_alive();
  bool reconnect();
  int finish();

  bool good(const char* what, const Status& status);
  Store& database() { return leased_ ? static_cast<Store&>(*leased_) : store_.store(); }

  const Options& options_;
  StageMask stages_;
  FlightPlace place_;
  const volatile std::sig_atomic_t& stop_;
  MissionParameters file_;     ///< of the mission file
  MissionParameters mission_;  ///< in force
  ChosenStore& store_;
  int lock_lease_s_ = usual_lock_lease_s;
  std::optional<LeasedStore> leased_;  ///< a server has a lease of its own
  std::optional<SharedFlightStore> shared_;
  RealClock clock_;
  NoCamera no_camera_;
  NoLink no_link_;
  RamNonvolatile no_memory_;
  FlightSoftware* software_ = nullptr;
  std::optional<Node> node_;
  std::int64_t question_ = 0;  ///< that is to be answered
  std::uint32_t connections_ = 1;
  TimeNs reported_ns_ = 0;
  bool ended_ = false;    ///< the primary says that the flight is done
  bool refused_ = false;  ///< the primary is one of another flight
};

bool NodeProcess::good(const char* what, const Status& status) {
  if (!status.ok()) print_status(what, status);
  return status.ok();
}

bool NodeProcess::ask_for_priority() {
  int priority = 0;
  if (!read_priority(options_, priority)) return false;
  // The flight goes on without it.
  if (priority > 0) static_cast<void>(good("--priority", ask_for_real_time(priority)));
  return true;
}

/// The store may not exist yet, and its primary may come later.
bool NodeProcess::wait_for_primary() {
  Status reported;
  bool joined = false;
  while (stop_ == 0) {
    Status status = joined ? Status{} : store_.join(options_, stages_, file_);
    joined = status.ok();
    if (joined && !leased_ && store_.disk() != nullptr) leased_.emplace(store_.store(), lock_lease_s_);
    NodeRecord head;
    RecordMask changed = 0;
    if (joined) status = database().poll(changed);
    if (status.ok()) status = find_flight(database(), stages_, file_, head);
    if (status.ok()) {
      clock_.set(head.seen_ns);
      return true;
    }
    const bool comes = status.is(StatusCode::not_found) || status.is(StatusCode::not_ready) ||
                       status.is(StatusCode::store_in_use) || status.is(StatusCode::store_lost);
    if (!comes) {
      print_status(store_label(options_), status, store_.message());
      return false;
    }
    if (reported.code != status.code) {
      std::fprintf(stderr, "ilp-onboard: waiting for the primary of the flight (%s)\n", status_name(status.code));
    }
    reported = status;
    // A connection that was lost is not found again by asking.
    joined = joined && !status.is(StatusCode::store_lost);
    if (!joined) store_.close();
    static_cast<void>(::usleep(nap_before_primary_ms * 1000));
  }
  return false;
}

bool NodeProcess::start() {
  mission_ = file_;
  shared_.emplace(database());
  node_.emplace(database(), clock_, stages_);
  software_ = new (place_.software) FlightSoftware({.store = *shared_,
                                                    .camera = no_camera_,
                                                    .link = no_link_,
                                                    .clock = clock_,
                                                    .nonvolatile_memory = no_memory_,
                                                    .real_time = true},
                                                   mission_, stages_);
  shared_->follow(file_, mission_, software_->executive());
  if (!good("start", software_->join())) return false;
  Status begun = node_->begin(host_name().c_str(), file_);
  while (begun.is(StatusCode::store_locked) && stop_ == 0) {
    static_cast<void>(wait_for_lock(store_.disk()));
    begun = node_->begin(host_name().c_str(), file_);
  }
  return good("record of the node", begun);
}

void NodeProcess::keep_alive() {
  const TimeNs now = clock_.now();
  if (now - reported_ns_ < report_period) return;
  reported_ns_ = now;
  static_cast<void>(node_->keep_alive(software_->executive(), connections_));
  // So that a power cut costs little work even without a primary.
  const Status flushed = store_.sharing().flush_or_later();
  if (!flushed.ok()) software_->executive().events().report(now, "board", flushed);
  NodeRecord head;
  if (find_primary(database(), head).ok() && head.seen_ns > clock_.now()) {
    // In virtual time the primary's clock is the faster one.
    clock_.set(head.seen_ns);
    reported_ns_ = head.seen_ns;
  }
}

void NodeProcess::step() {
  Executive& executive = software_->executive();
  if (question_ != 0) executive.wake_all();
  const std::int64_t commits = shared_->waking_commits();
  executive.run_minor_frame(clock_.now());
  keep_alive();
  if (!executive.idle()) return;
  if (question_ != 0) {
    if (commits != shared_->waking_commits()) return;
    if (node_->answer(question_, commits).ok()) question_ = 0;
  }
  if (shared_->changed(mask_of(RecordType::node))) poll_primary();
  if (question_ == 0) store_.sharing().wait(nap_ms);
}

void NodeProcess::poll_primary() {
  NodeRecord head;
  const Status found = find_primary(database(), head);
  if (!found.ok()) return;
  refused_ = !good(store_label(options_), check_primary(head, stages_, file_));
  ended_ = head.idle;
  static_cast<void>(node_->question(question_));
}

/// Whatever is in memory may differ from the store, so every stage goes back to its checkpoint.
bool NodeProcess::reconnect() {
  if (!store_.sharing().reconnect().ok()) {
    static_cast<void>(::usleep(nap_before_primary_ms * 1000));
    return false;
  }
  ++connections_;
  shared_->follow(file_, mission_, software_->executive());
  const bool started = software_->executive().start().ok();
  if (started) std::fprintf(stderr, "ilp-onboard: connected to %s again\n", store_label(options_));
  return started;
}

int NodeProcess::finish() {
  if (store_.damaged() || software_->restart_wanted()) {
    std::fprintf(stderr, "ilp-onboard: %s is damaged: start again\n", store_.damaged() ? options_.store : "memory");
    return exit_restart;
  }
  const bool well = software_->executive().end().ok();
  store_.close();
  return well && !refused_ ? 0 : 1;
}

int NodeProcess::run() {
  if (!read_mission(options_, file_) || !read_lock_lease(options_, lock_lease_s_) || !ask_for_priority()) return 1;
  if (!wait_for_primary()) return stop_ != 0 ? 0 : 1;
  if (!start()) return store_.damaged() ? exit_restart : 1;
  std::fprintf(stderr, "ilp-onboard: running %s\n", stage_names(stages_).c_str());
  seal_heap(options_.trap_heap ? HeapTrapMode::strict : HeapTrapMode::report);
  while (stop_ == 0 && !ended_ && !refused_ && !store_.damaged() && !software_->restart_wanted()) {
    if (!store_.sharing().connected() && !reconnect()) continue;
    // Nothing can be done while another process keeps the lock of the database; the primary ends that process.
    if (is_locked(store_.disk()) && wait_for_lock(store_.disk())) continue;
    step();
  }
  return finish();
}

}  // namespace

int run_node(const Options& options, StageMask stages, const FlightPlace& place,
             const volatile std::sig_atomic_t& stop) {
  static NodeProcess process(options, stages, place, stop);
  return process.run();
}

}  // namespace ilp
