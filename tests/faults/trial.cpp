#include "tests/faults/trial.hpp"

#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <iostream>
#include <memory>
#include <stdexcept>

#include "fsw/base/crc.hpp"
#include "hal/store/sqlite/sqlite_store.hpp"

namespace ilp::faults {
namespace fs = std::filesystem;
namespace {

constexpr int max_boots = 8;
/// Beyond the end of the undisturbed flight: what was lost is sent again after its timeout, more than once.
constexpr TimeNs overtime_ns = 200 * ns_per_s;

/// What a boot leaves that ends in order.
void end_in_order(const fs::path& folder) {
  SqliteStore store;
  StartRecord boot;
  Status status = store.open((folder / "flight.db").c_str());
  if (status.ok()) status = last(store, boot);
  boot.end_ns = boot.alive_ns = std::max<TimeNs>(boot.alive_ns, 1);
  if (status.ok()) status = store.begin();
  if (status.ok()) status = put(store, boot);
  if (status.ok()) status = store.commit();
  store.close();
  if (!status.ok()) throw std::runtime_error("a flight cannot be ended in order");
}

/// Records that only the ground makes: a parameter that is set, a telecommand that waits, an uplinked file.
void write_what_the_ground_sent() {
  Store& store = static_memory().store->store();
  Configuration& configuration = static_memory().software->configuration();
  MissionParameters wanted = configuration.wanted();
  wanted.overdue_passes = 5;
  const std::vector<std::uint8_t> octets(200, 0x5A);
  ScheduledRecord scheduled{.id = 1, .release_ns = 1'000'000 * ns_per_s};
  scheduled.packet.bytes = static_cast<std::uint32_t>(octets.size());
  UplinkRecord uplinked{.id = 1};
  uplinked.data.bytes = static_cast<std::uint32_t>(octets.size());
  uplinked.crc32 = crc32(octets);
  Transaction transaction(store);
  Status status = transaction.begin();
  if (status.ok()) status = configuration.write(wanted, 0);
  if (status.ok()) status = put(store, scheduled);
  if (status.ok()) status = write_blob<ScheduledRecord>(store, "packet", 1, 0, octets);
  if (status.ok()) status = put(store, uplinked);
  if (status.ok()) status = write_blob<UplinkRecord>(store, "data", 1, 0, octets);
  if (status.ok()) status = transaction.commit();
  if (status.ok()) configuration.accept(wanted, Configuration::Way::parameters);
  if (!status.ok()) throw std::runtime_error("the ground's records cannot be written");
}

void add_code(Verdict& verdict, const Reference& reference, std::uint16_t code) {
  if (reference.usual.count(code) != 0) return;
  for (std::uint32_t i = 0; i < verdict.codes; ++i) {
    if (verdict.code[i] == code) return;
  }
  if (verdict.codes < std::size(verdict.code)) verdict.code[verdict.codes++] = code;
}

void look(const Reference& reference, const std::set<RecordKey>& settled, Store& store, const fs::path& folder,
          Verdict& verdict) {
  std::set<std::uint16_t> events;
  verdict.difference = compare(reference.results, settled, store, files_of(folder), events);
  for (const std::uint16_t code : events) add_code(verdict, reference, code);
}

void describe_boot(int boot, bool by_itself, int status, const Traces& traces) {
  std::printf("boot %d: %s %d at %.1f s", boot, by_itself ? "status" : "signal", status,
              1e-9 * static_cast<double>(traces.now_ns));
  for (std::uint32_t n = 0; n < traces.updates; ++n) {
    std::printf("%s%s", n == 0 ? "; told: " : ", ", status_text(static_cast<StatusCode>(traces.statuses[n])));
  }
  std::printf("\n");
}

Outcome judge(const Verdict& verdict, bool noticed) {
  const bool reported = noticed || verdict.codes != 0 || verdict.difference.reported != 0;
  const bool ended = verdict.crashed || verdict.hung;
  if (!verdict.difference.any()) return reported || ended ? Outcome::mended : Outcome::harmless;
  // That a process died says that it died, and not that something it left is wrong. What was right and is now other
  // than it was is wrong, whatever was reported.
  if (!reported || verdict.difference.altered != 0) return Outcome::silent;
  return Outcome::lost;
}

}  // namespace

const char* outcome_name(Outcome outcome) {
  constexpr const char* names[] = {"harmless", "noticed, mended", "noticed, lost", "silent", "locked out", "broken"};
  return names[static_cast<std::size_t>(outcome)];
}

fs::path Reference::snapshot(std::int64_t frame, bool in_order) const {
  return folder / (in_order ? "ended" : "snapshots") / std::to_string(frame / snapshot_frames * snapshot_frames);
}

const std::set<RecordKey>& Reference::settled(std::int64_t frame) const {
  return settled_.at(static_cast<std::size_t>(frame / snapshot_frames));
}

void Reference::settle() {
  for (std::int64_t frame = 0; frame < frames; frame += snapshot_frames) {
    std::set<RecordKey> keys;
    const Results then = results_of(snapshot(frame));
    for (const auto& [key, digest] : then.records) {
      const auto at_end = results.records.find(key);
      if (at_end != results.records.end() && at_end->second.same(key.first, digest)) keys.insert(key);
    }
    settled_.push_back(std::move(keys));
  }
}

void* share(std::size_t bytes) {
  void* const memory = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) throw std::runtime_error("no shared memory");
  return memory;
}

bool run_apart(const std::function<int()>& body, int& status) {
  std::cout.flush();
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("no process");
  if (child == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    // Processor time: how busy the machine is must not decide.
    const itimerval limit{{0, 0}, {watchdog_seconds, 0}};
    setitimer(ITIMER_PROF, &limit, nullptr);
    int result = boot_broken;
    try {
      result = body();
    } catch (const std::exception& error) {
      std::fprintf(stderr, "harness: %s\n", error.what());
    }
    _exit(result);
  }
  int state = 0;
  waitpid(child, &state, 0);
  status = WIFEXITED(state) ? WEXITSTATUS(state) : WTERMSIG(state);
  return WIFEXITED(state);
}

void unshare(void* memory, std::size_t bytes) {
  munmap(memory, bytes);
}

void copy_snapshot(const fs::path& from, const fs::path& to) {
  fs::remove_all(to);
  fs::create_directories(to);
  // The database, its log, and what else lies beside it; but no index of the log, which is made again.
  for (const auto& entry : fs::directory_iterator(from)) {
    const std::string name = entry.path().filename().string();
    if (entry.is_regular_file() && name.find("-shm") == std::string::npos) fs::copy(entry.path(), to / name);
  }
  // Files of the outbox and confirmations are never written to again.
  for (const char* name : {"outbox", "acknowledged"}) {
    fs::copy(from / name, to / name, fs::copy_options::recursive | fs::copy_options::create_hard_links);
  }
}

Verdict fly_trial(const Reference& reference, const fs::path& folder, TimeNs now_ns, const std::set<RecordKey>& settled,
                  Traces& traces, const Hooks& hooks, const std::function<void(int)>& between) {
  Verdict verdict;
  Verdict& seen = *static_cast<Verdict*>(share(sizeof(Verdict)));
  const std::unique_ptr<Verdict, void (*)(Verdict*)> keep(&seen, [](Verdict* v) { munmap(v, sizeof(*v)); });
  traces = {};
  traces.now_ns = now_ns;
  bool noticed = false;
  bool ended = false;
  bool examined = false;
  const TimeNs end_ns = reference.end_ns + overtime_ns;
  while (!ended && verdict.boots < max_boots) {
    const bool first = verdict.boots++ == 0;
    Hooks boot_hooks = first ? hooks : Hooks{};
    if (!first) boot_hooks.started = hooks.again;
    boot_hooks.without_disk = [&](Store& store) {
      look(reference, settled, store, folder, seen);
      seen.outcome = Outcome::harmless;
    };
    int status = 0;
    seen = {};
    const bool by_itself = run_apart([&] { return live(reference.world, folder, end_ns, traces, boot_hooks); }, status);
    if (boots_described) describe_boot(verdict.boots, by_itself, status, traces);
    if (by_itself) {
      if (status == boot_broken) return verdict;
      // The trial's own end of a boot is no finding.
      if (status != boot_killed) noticed = noticed || status == boot_restart || status == boot_refused;
      ended = status == boot_done || status == boot_overtime;
      verdict.overtime = status == boot_overtime;
      examined = ended && seen.outcome == Outcome::harmless;
    } else {
      verdict.hung = verdict.hung || status == SIGPROF;
      verdict.crashed = verdict.crashed || status != SIGPROF;
      if (verdict.signal == 0) verdict.signal = status;
    }
    noticed = noticed || traces.updates != 0;
    for (std::uint32_t i = 0; i < traces.updates; ++i) add_code(verdict, reference, traces.statuses[i]);
    if (!ended && between) between(verdict.boots);
  }
  if (!ended) {
    verdict.outcome = Outcome::locked;
    return verdict;
  }
  if (!examined) {
    int status = 0;
    const bool by_itself = run_apart(
        [&] {
          SqliteStore store;
          static_cast<void>(store.open_read_only((folder / "flight.db").c_str()));
          look(reference, settled, store, folder, seen);
          return 0;
        },
        status);
    if (!by_itself || status != 0) return verdict;
  }
  verdict.difference = seen.difference;
  for (std::uint32_t i = 0; i < seen.codes; ++i) add_code(verdict, reference, seen.code[i]);
  verdict.outcome = judge(verdict, noticed);
  return verdict;
}

Reference fly_reference(const fs::path& world, const fs::path& folder) {
  Reference reference;
  reference.world = world;
  reference.folder = folder;
  fs::create_directories(folder / "snapshots");
  fs::create_directories(folder / "outbox");
  fs::create_directories(folder / "acknowledged");
  Traces& traces = *static_cast<Traces*>(share(sizeof(Traces)));
  constexpr std::size_t most_frames = 4096;
  auto* const hooks_of = static_cast<std::int64_t*>(share(most_frames * sizeof(std::int64_t)));
  auto* const frames = static_cast<std::int64_t*>(share(sizeof(std::int64_t)));
  // What the ground has sent is there when the flight begins.
  Hooks before;
  before.started = [] {
    write_what_the_ground_sent();
    _exit(boot_killed);
  };
  int status = 0;
  if (!run_apart([&] { return live(world, folder, most_frames * minor_frame_ns, traces, before); }, status) ||
      status != boot_killed) {
    throw std::runtime_error("the flight cannot be prepared");
  }
  traces = {};
  Hooks hooks;
  hooks.frame = [&](std::int64_t frame) {
    *frames = frame;
    if (frame % snapshot_frames == 0) copy_snapshot(folder, reference.snapshot(frame));
  };
  hooks.step = [&] { ++hooks_of[*frames]; };
  hooks.call = [&](const test::FailingStore::Call&) {
    ++hooks_of[*frames];
    return Status{};
  };
  if (!run_apart([&] { return live(world, folder, most_frames * minor_frame_ns, traces, hooks); }, status) ||
      status != boot_done) {
    throw std::runtime_error("the undisturbed flight ends with " + std::to_string(status));
  }
  reference.end_ns = traces.now_ns;
  reference.frames = (traces.now_ns - grace_ns) / minor_frame_ns;
  reference.hooks.assign(hooks_of, hooks_of + reference.frames);
  reference.results = results_of(folder);
  reference.usual = reference.results.events;
  // This event also comes when a flight goes back a little, because its log was cut short.
  reference.usual.insert(static_cast<std::uint16_t>(StatusCode::frame_late));
  reference.settle();
  for (std::int64_t frame = 0; frame < reference.frames; frame += snapshot_frames) {
    copy_snapshot(reference.snapshot(frame), reference.snapshot(frame, true));
    end_in_order(reference.snapshot(frame, true));
    const fs::path again = folder / "again";
    copy_snapshot(reference.snapshot(frame, frame / snapshot_frames % 2 == 1), again);
    const Verdict verdict = fly_trial(reference, again, frame * minor_frame_ns, reference.settled(frame), traces, {});
    for (std::uint32_t i = 0; i < verdict.codes; ++i) reference.usual.insert(verdict.code[i]);
    if (verdict.outcome == Outcome::harmless) continue;
    if (verdict.outcome == Outcome::mended) continue;
    throw std::runtime_error("a flight started again in minor frame " + std::to_string(frame) +
                             " differs: " + outcome_name(verdict.outcome) + ", " + verdict.difference.first);
  }
  return reference;
}

void run_trials(std::int64_t trials, int jobs, const std::function<void(std::int64_t, int)>& trial) {
  std::vector<pid_t> workers;
  std::cout.flush();
  for (int worker = 0; worker < jobs; ++worker) {
    const pid_t child = fork();
    if (child != 0) {
      workers.push_back(child);
      continue;
    }
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    try {
      for (std::int64_t number = worker; number < trials; number += jobs) trial(number, worker);
    } catch (const std::exception& error) {
      std::fprintf(stderr, "harness: %s\n", error.what());
      _exit(1);
    }
    _exit(0);
  }
  for (const pid_t worker : workers) {
    int state = 0;
    waitpid(worker, &state, 0);
    if (!WIFEXITED(state) || WEXITSTATUS(state) != 0) throw std::runtime_error("a worker of the campaign has failed");
  }
}

}  // namespace ilp::faults
