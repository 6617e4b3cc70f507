#include <sys/prctl.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <limits>
#include <map>
#include <new>
#include <stdexcept>

#include "fsw/base/rng.hpp"
#include "tests/faults/campaigns.hpp"
#include "tests/faults/ram_flight.hpp"
#include "tests/faults/tally.hpp"

namespace ilp::faults {
namespace fs = std::filesystem;
namespace {

using test::FailingStore;
using test::StoreCall;

constexpr Status broken_disk{StatusCode::store_error, 10, 266};
constexpr Status full_disk{StatusCode::store_full, 1 << 20, 1 << 20};
constexpr TimeNs minute_ns = 60 * ns_per_s;
/// Mission time that a trial may take beyond the undisturbed flight: that of a burst of 512 calls of one component,
/// with the longest pause between any two of them.
constexpr TimeNs overtime_ns = 3600 * ns_per_s;
constexpr std::size_t everybody = stage_count + 1;
/// The third start in a row is with other parameters (docs/getting-back-in.md), and so another flight. No fault lasts
/// that long.
constexpr int most_failed_starts = 2;

constexpr std::uint32_t bit_of(StoreCall kind) {
  return std::uint32_t{1} << static_cast<unsigned>(kind);
}
constexpr std::uint32_t every_kind = bit_of(StoreCall::kinds) - 1;
constexpr std::uint32_t commits = bit_of(StoreCall::commit);
constexpr std::uint32_t writes = bit_of(StoreCall::put) | bit_of(StoreCall::erase) | bit_of(StoreCall::write_blob);
constexpr std::uint32_t reads = every_kind & ~writes & ~commits & ~bit_of(StoreCall::begin);

/// Which calls fail, from one call of the undisturbed flight on.
struct Fault {
  std::int64_t first = 0;  ///< number of the call at which the trial branches off
  std::int64_t calls = 1;  ///< number of calls that fail
  TimeNs length_ns = std::numeric_limits<TimeNs>::max();
  std::size_t component = everybody;
  std::uint32_t kinds = every_kind;
  Status status = broken_disk;
  std::int64_t restart_frame = -1;  ///< the software is started again there, and the fault meets its start
  std::string group;
};

struct Call {
  StoreCall kind;
  std::size_t component;
};

/// The undisturbed flight: every call of its store, and what it leaves.
struct Undisturbed {
  std::vector<Call> calls;
  std::vector<std::int64_t> first_calls;  ///< of each minor frame
  Results results;
  TimeNs end_ns = 0;
};

Undisturbed fly_undisturbed(const World& world) {
  Undisturbed undisturbed;
  RamFlight flight(world);
  flight.store().judge_by([&](const FailingStore::Call& call) {
    undisturbed.calls.push_back({call.kind, flight.at_work()});
    return Status{};
  });
  if (!flight.start()) throw std::runtime_error("the undisturbed flight does not start");
  const std::int64_t most_frames = 4096;
  int rest = 0;
  while (rest < rest_frames) {
    undisturbed.first_calls.push_back(flight.store().calls());
    flight.fly_frame();
    rest = flight.drained() ? rest + 1 : 0;
    if (undisturbed.first_calls.size() > most_frames) throw std::runtime_error("the undisturbed flight does not end");
  }
  undisturbed.end_ns = flight.now();
  undisturbed.results = flight.results();
  return undisturbed;
}

/// The calls of a start of the software in this minor frame: numbers of the first, and their kinds.
std::pair<std::int64_t, std::vector<StoreCall>> calls_of_start(const World& world, std::int64_t frame) {
  RamFlight flight(world);
  std::vector<StoreCall> calls;
  bool started = flight.start();
  for (std::int64_t n = 0; started && n < frame; ++n) flight.fly_frame();
  const std::int64_t first = flight.store().calls();
  flight.store().judge_by([&](const FailingStore::Call& call) {
    calls.push_back(call.kind);
    return Status{};
  });
  if (!started || !flight.start()) throw std::runtime_error("the undisturbed flight does not start again");
  return {first, calls};
}

/// Flies once; at the first call of each fault a process branches off in which that fault happens.
class Walker {
 public:
  Walker(const World& world, const Undisturbed& undisturbed, std::vector<std::pair<const Fault*, TrialRecord*>> plan)
      : undisturbed_(undisturbed), plan_(std::move(plan)), flight_(world) {
    std::stable_sort(plan_.begin(), plan_.end(),
                     [](const auto& a, const auto& b) { return a.first->first < b.first->first; });
    flight_.store().judge_by([this](const FailingStore::Call& call) { return judge(call); });
  }

  /// `restart_frame`: the software is started again there; -1: never.
  void walk(std::int64_t restart_frame) {
    bool started = flight_.start();
    for (std::int64_t frame = 0; started && frame < restart_frame; ++frame) flight_.fly_frame();
    if (started && restart_frame >= 0) started = flight_.start();
    // Nothing branches off any more.
    if (trial_ == nullptr && next_ == plan_.size()) return;
    const bool done = started && flight_.fly_until(undisturbed_.end_ns + overtime_ns);
    if (trial_ == nullptr) return;
    end_trial(started, done);
  }

 private:
  Status judge(const FailingStore::Call& call) {
    if (trial_ != nullptr) return fail(call);
    while (next_ < plan_.size() && plan_[next_].first->first <= call.number) {
      const auto [fault, record] = plan_[next_++];
      if (branch(*record)) {
        trial_ = record;
        fault_ = *fault;
        begin_ns_ = flight_.now();
        std::snprintf(record->what, sizeof(record->what), "call %lld, %s %s, by %s at %.1f s",
                      static_cast<long long>(call.number), store_call_name(call.kind),
                      call.type == RecordType::count ? "" : record_info(call.type).name, flight_.at_work_name(),
                      1e-9 * static_cast<double>(begin_ns_));
        return fail(call);
      }
    }
    return {};
  }

  Status fail(const FailingStore::Call& call) {
    if (flight_.failed_starts() >= most_failed_starts) fault_.calls = 0;
    if (fault_.calls <= 0 || (fault_.kinds & bit_of(call.kind)) == 0) return {};
    if (fault_.component != everybody && fault_.component != flight_.at_work()) return {};
    if (flight_.now() - begin_ns_ >= fault_.length_ns) return {};
    --fault_.calls;
    return fault_.status;
  }

  /// True in the process that is the trial.
  static bool branch(TrialRecord& record) {
    const pid_t child = fork();
    if (child < 0) throw std::runtime_error("no process");
    if (child == 0) {
      prctl(PR_SET_PDEATHSIG, SIGKILL);
      const itimerval limit{{0, 0}, {watchdog_seconds, 0}};
      setitimer(ITIMER_PROF, &limit, nullptr);
      return true;
    }
    int state = 0;
    waitpid(child, &state, 0);
    if (WIFEXITED(state)) return false;
    // Where the store is in memory nothing is left to go on with.
    record.verdict.outcome = Outcome::locked;
    record.verdict.signal = WTERMSIG(state);
    record.verdict.hung = record.verdict.signal == SIGPROF;
    record.verdict.crashed = !record.verdict.hung;
    return false;
  }

  [[noreturn]] void end_trial(bool started, bool done) {
    Verdict& verdict = trial_->verdict;
    std::set<std::uint16_t> events;
    verdict.boots = 1;
    verdict.overtime = !done;
    verdict.difference = flight_.compare_with(undisturbed_.results, events);
    for (const std::uint16_t code : events) {
      const bool usual = undisturbed_.results.events.count(code) != 0;
      if (!usual && verdict.codes < std::size(verdict.code)) verdict.code[verdict.codes++] = code;
    }
    if (!started) {
      verdict.outcome = Outcome::locked;
    } else if (verdict.difference.any()) {
      verdict.outcome = verdict.codes != 0 ? Outcome::lost : Outcome::silent;
    } else {
      verdict.outcome = verdict.codes != 0 ? Outcome::mended : Outcome::harmless;
    }
    _exit(0);
  }

  const Undisturbed& undisturbed_;
  std::vector<std::pair<const Fault*, TrialRecord*>> plan_;
  RamFlight flight_;
  std::size_t next_ = 0;
  TrialRecord* trial_ = nullptr;
  Fault fault_;
  TimeNs begin_ns_ = 0;
};

const char* component_name(std::size_t component) {
  return component < stage_count ? schedule[component].name : component == stage_count ? "executive" : "all";
}

/// Every `stride`-th call fails once.
void plan_each(const Undisturbed& undisturbed, std::int64_t stride, std::vector<Fault>& faults) {
  for (std::size_t n = 0; n < undisturbed.calls.size(); n += static_cast<std::size_t>(stride)) {
    Fault fault;
    fault.first = static_cast<std::int64_t>(n);
    fault.group = std::string("one ") + store_call_name(undisturbed.calls[n].kind);
    faults.push_back(fault);
  }
}

/// Single calls and bursts, of one component or of all.
void plan_random(const Undisturbed& undisturbed, std::int64_t trials, std::uint64_t seed, std::vector<Fault>& faults) {
  std::vector<std::vector<std::int64_t>> calls_of(everybody + 1);
  for (std::size_t n = 0; n < undisturbed.calls.size(); ++n) {
    calls_of[undisturbed.calls[n].component].push_back(static_cast<std::int64_t>(n));
    calls_of[everybody].push_back(static_cast<std::int64_t>(n));
  }
  for (std::int64_t trial = 0; trial < trials; ++trial) {
    Rng rng(seed, static_cast<std::uint64_t>(trial));
    const auto component = static_cast<std::size_t>(trial) % calls_of.size();
    const std::vector<std::int64_t>& calls = calls_of[component];
    if (calls.empty()) continue;
    Fault fault{.first = calls[rng.below(static_cast<std::uint32_t>(calls.size()))]};
    constexpr std::uint32_t longest[] = {1, 8, 64, 512};
    fault.calls = 1 + rng.below(longest[rng.below(4)]);
    fault.component = component;
    const std::uint32_t kind = rng.below(4);
    if (kind == 1) fault.kinds = reads;
    if (kind == 2) fault.kinds = commits;
    if (kind == 3) {
      fault.kinds = writes;
      fault.status = full_disk;
    }
    fault.group = std::string("bursts, ") + component_name(component);
    faults.push_back(fault);
  }
}

/// A minute of mission time, from the beginning of every `stride`-th minor frame on.
void plan_minutes(const Undisturbed& undisturbed, std::size_t stride, std::vector<Fault>& faults) {
  struct Kind {
    const char* name;
    std::uint32_t kinds;
    Status status;
  };
  const Kind kinds[] = {{"a minute, every call", every_kind, broken_disk},
                        {"a minute, every read", reads, broken_disk},
                        {"a minute, every commit", commits, broken_disk},
                        {"a minute, disk full", writes, full_disk}};
  for (std::size_t frame = 0; frame < undisturbed.first_calls.size(); frame += stride) {
    for (const Kind& kind : kinds) {
      Fault fault;
      fault.first = undisturbed.first_calls[frame];
      fault.calls = std::numeric_limits<std::int64_t>::max();
      fault.length_ns = minute_ns;
      fault.kinds = kind.kinds;
      fault.status = kind.status;
      fault.group = kind.name;
      faults.push_back(fault);
    }
  }
}

/// Every call of a start in turn fails once, and the software goes on or is started again.
void plan_starts(const World& world, std::int64_t frames, std::int64_t stride, std::vector<Fault>& faults) {
  for (std::int64_t frame = stride / 2; frame < frames; frame += stride) {
    const auto [first, calls] = calls_of_start(world, frame);
    for (std::size_t n = 0; n < calls.size(); ++n) {
      Fault fault;
      fault.first = first + static_cast<std::int64_t>(n);
      fault.restart_frame = frame;
      fault.group = std::string("one at a start, ") + store_call_name(calls[n]);
      faults.push_back(fault);
    }
  }
}

/// What one process flies: all faults of a flight without a new start, or those of one new start.
struct Walk {
  std::int64_t restart_frame = -1;
  std::vector<std::pair<const Fault*, TrialRecord*>> plan;
};

std::vector<Walk> walks_of(const std::vector<Fault>& faults, TrialRecord* records, const CampaignOptions& options) {
  std::map<std::int64_t, Walk> walks;
  for (std::size_t n = 0; n < faults.size(); ++n) {
    if (options.only >= 0 && static_cast<std::int64_t>(n) != options.only) continue;
    const std::int64_t frame = faults[n].restart_frame;
    // Flights without a new start are shared out.
    const std::int64_t key = frame >= 0 ? frame : -1 - static_cast<std::int64_t>(n) % options.jobs;
    walks[key].restart_frame = frame;
    walks[key].plan.emplace_back(&faults[n], records + n);
  }
  std::vector<Walk> list;
  for (auto& walk : walks) list.push_back(std::move(walk.second));
  return list;
}

}  // namespace

bool failing_calls(const fs::path& folder, const CampaignOptions& options, bool packets) {
  const World world{folder, packets};
  const Undisturbed undisturbed = fly_undisturbed(world);
  const auto calls = static_cast<std::int64_t>(undisturbed.calls.size());
  std::vector<Fault> faults;
  plan_each(undisturbed, std::max<std::int64_t>(1, calls / options.trials), faults);
  plan_random(undisturbed, options.trials, options.seed, faults);
  plan_minutes(undisturbed, static_cast<std::size_t>(std::max<std::int64_t>(1, 1000 / options.trials)), faults);
  plan_starts(world, static_cast<std::int64_t>(undisturbed.first_calls.size()),
              std::clamp<std::int64_t>(2000 / options.trials, 3, 60), faults);
  const auto trials = static_cast<std::int64_t>(faults.size());
  auto* const records = static_cast<TrialRecord*>(share(faults.size() * sizeof(TrialRecord)));
  TableOptions table{.heading = "what fails", .ends_are_faults = true, .losses_are_faults = true, .list = options.list};
  for (std::size_t n = 0; n < faults.size(); ++n) {
    TrialRecord& record = *new (records + n) TrialRecord;
    std::snprintf(record.group, sizeof(record.group), "%s", faults[n].group.c_str());
    if (std::find(table.order.begin(), table.order.end(), faults[n].group) == table.order.end()) {
      table.order.push_back(faults[n].group);
    }
  }
  std::printf("The undisturbed flight: %zu calls of the store in %zu minor frames\n", undisturbed.calls.size(),
              undisturbed.first_calls.size());
  const std::vector<Walk> walks = walks_of(faults, records, options);
  run_trials(static_cast<std::int64_t>(walks.size()), options.jobs, [&](std::int64_t n, int) {
    const Walk& walk = walks[static_cast<std::size_t>(n)];
    Walker(world, undisturbed, walk.plan).walk(walk.restart_frame);
  });
  bool good = true;
  if (options.only >= 0) {
    print_trial(options.only, records[options.only]);
  } else {
    good = print_table(records, trials, table);
  }
  unshare(records, faults.size() * sizeof(TrialRecord));
  return good;
}

}  // namespace ilp::faults
