#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <limits>
#include <memory>
#include <new>
#include <optional>
#include <stdexcept>
#include <vector>

#include "fsw/base/rng.hpp"
#include "tests/faults/campaigns.hpp"
#include "tests/faults/cut_disk.hpp"
#include "tests/faults/inspection.hpp"
#include "tests/faults/neighbour.hpp"
#include "tests/faults/system_calls.hpp"
#include "tests/faults/tally.hpp"

namespace ilp::faults {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t call_kinds = static_cast<std::size_t>(CallKind::kinds);
constexpr std::size_t file_kinds = static_cast<std::size_t>(FileKind::kinds);
/// Minor frames of a boot in which a fault may begin, and those by which something follows it at most.
constexpr std::int64_t first_frames = 12, later_frames = 20;
constexpr std::size_t block_bytes = 4096;
constexpr std::int64_t always = std::numeric_limits<std::int64_t>::max();

/// Calls of each kind, by file: of a start, and of the minor frames behind it.
struct Calls {
  std::uint32_t at_start[call_kinds][file_kinds];
  std::uint32_t in_flight[call_kinds][file_kinds];
};

enum class Effect : std::uint8_t {
  io_error,     ///< EIO; of a read also ENXIO, which SQLite takes for damage
  no_capacity,  ///< ENOSPC
  full,         ///< ENOSPC for what makes a file longer
  interrupted,  ///< EINTR
  half,         ///< half of the octets
};
constexpr const char* effect_names[] = {"EIO", "ENOSPC", "disk full", "EINTR", "half of it"};

enum class End : std::uint8_t { none, in_order, killed, power_cut };
constexpr const char* end_names[] = {"", ", then an orderly end", ", then killed", ", then a power cut"};

enum class Beside : std::uint8_t { nobody, reader, lock };
constexpr const char* beside_names[] = {"", ", a reader beside", ", a lock held beside"};

enum class Class : std::uint8_t { one, burst, seconds, full, flips };
constexpr const char* class_names[] = {"one", "burst", "seconds", "full", "flips"};

/// The fault of a trial, and what follows it.
struct Fault {
  Class what = Class::one;
  Effect effect = Effect::io_error;
  bool at_start = false;
  std::int64_t frame = 0;  ///< of the boot, from which on calls are counted
  // It begins with this one of the calls of this kind on this file.
  CallKind kind = CallKind::read;
  FileKind file = FileKind::database;
  std::int64_t before = 0;
  std::int64_t calls = 1;  ///< that fail
  TimeNs length_ns = std::numeric_limits<TimeNs>::max();
  bool writes_only = false;
  End end = End::none;
  std::int64_t end_after = 0;  ///< calls (killed, power cut) or minor frames (in order) behind the first failure
  bool end_in_half = false;
  Loss loss = Loss::all;
  Beside beside = Beside::nobody;
  std::int64_t beside_from = 0, beside_until = 0;
};

bool writes(CallKind kind) {
  return kind != CallKind::read && kind != CallKind::open && kind != CallKind::map;
}

/// What the trial tells from the process that the fault meets.
struct Reported {
  bool met = false;
  bool stayed = false;  ///< nobody who should have been beside was refused
  char where[64] = {};
};

/// Lets one boot meet the fault.
class Disturber {
 public:
  Disturber(const Fault& fault, const fs::path& folder, const Traces& traces, const Neighbour* neighbour,
            std::uint64_t seed, Reported& reported)
      : fault_(fault), folder_(folder), traces_(traces), neighbour_(neighbour), rng_(seed, 1), reported_(reported) {}

  Hooks hooks() {
    Hooks hooks;
    hooks.begin = [this] { begin(); };
    hooks.started = [this] { started_ = true; };
    hooks.again = [this] {
      if (neighbour_ != nullptr) static_cast<void>(neighbour_->finish());
    };
    hooks.frame = [this](std::int64_t frame) { look(frame); };
    hooks.ends = [this] {
      return fault_.end == End::in_order && met_ && traces_.frames >= met_frame_ + fault_.end_after;
    };
    return hooks;
  }

 private:
  void begin() {
    disk_.emplace(folder_);
    watch_system_calls(folder_, {[this](const SystemCall& call) { return judge(call); }, [this] { end(); }, &*disk_});
  }

  void look(std::int64_t frame) {
    frame_ = frame;
    if (met_ && traces_.now_ns - met_ns_ >= fault_.length_ns) set_capacity(-1);
    if (neighbour_ == nullptr) return;
    if (frame == fault_.beside_from) {
      reported_.stayed = fault_.beside == Beside::reader ? neighbour_->read() : neighbour_->lock();
    }
    if (frame == fault_.beside_until) static_cast<void>(neighbour_->finish());
  }

  [[nodiscard]] bool armed() const { return fault_.at_start ? !started_ || met_ : started_ && frame_ >= fault_.frame; }

  Answer judge(const SystemCall& call) {
    Answer answer;
    if (!met_) {
      if (!armed() || call.kind != fault_.kind || call.file != fault_.file || fault_.before-- > 0) return answer;
      meet(call);
    }
    answer = fail(call);
    if ((fault_.end == End::killed || fault_.end == End::power_cut) && calls_behind_++ == fault_.end_after) {
      if (fault_.end_in_half) answer.most = std::min(answer.most, call.bytes / 2);
      answer.dies = true;
    }
    return answer;
  }

  void meet(const SystemCall& call) {
    met_ = reported_.met = true;
    met_frame_ = traces_.frames;
    met_ns_ = traces_.now_ns;
    if (fault_.effect == Effect::full) set_capacity(0);
    std::snprintf(reported_.where, sizeof(reported_.where), "%s of the %s", call_name(call.kind), file_name(call.file));
  }

  /// On a full disk: what fits into the room that was given back.
  Answer fill(const SystemCall& call) {
    Answer answer;
    capacity_ += call.frees;
    const std::size_t more = (call.bytes - call.fits + block_bytes - 1) / block_bytes * block_bytes;
    const std::size_t wanted = std::max(more, block_bytes);
    if (!call.grows) return answer;
    if (wanted <= capacity_) {
      capacity_ -= wanted;
    } else if (call.fits > 0) {
      answer.most = call.fits;
    } else {
      answer.error = ENOSPC;
    }
    set_capacity(static_cast<std::int64_t>(capacity_));
    return answer;
  }

  Answer fail(const SystemCall& call) {
    if (fault_.calls <= 0 || traces_.now_ns - met_ns_ >= fault_.length_ns) return {};
    if (fault_.writes_only && !writes(call.kind) && !call.grows) return {};
    Answer answer;
    const bool transfer = call.kind == CallKind::read || call.kind == CallKind::write;
    switch (fault_.effect) {
      case Effect::io_error:
        answer.error = call.kind == CallKind::read && rng_.below(4) == 0 ? ENXIO : EIO;
        break;
      case Effect::no_capacity:
        if (writes(call.kind) || call.grows) answer.error = ENOSPC;
        break;
      case Effect::full:
        answer = fill(call);
        break;
      case Effect::interrupted:
        answer.error = EINTR;
        break;
      case Effect::half:
        if (transfer) answer.most = call.bytes / 2;
        break;
    }
    if (answer.error != 0 || answer.most < call.bytes) --fault_.calls;
    return answer;
  }

  [[noreturn]] void end() {
    SystemCallHooks none;
    forget_system_calls();
    if (fault_.end == End::power_cut) disk_->cut(fault_.loss, rng_);
    _exit(boot_killed);
  }

  Fault fault_;
  fs::path folder_;
  const Traces& traces_;
  const Neighbour* neighbour_;
  Rng rng_;
  Reported& reported_;
  std::optional<CutDisk> disk_;
  bool started_ = false;
  bool met_ = false;
  std::int64_t frame_ = -1;
  std::int64_t met_frame_ = 0;
  TimeNs met_ns_ = 0;
  std::int64_t calls_behind_ = 0;
  std::size_t capacity_ = 0;  ///< on a full disk
};

/// Counts the calls of a start and of the first minor frames behind it.
Calls count_calls(const Reference& reference, const fs::path& snapshot, std::int64_t begin, const fs::path& folder) {
  copy_snapshot(snapshot, folder);
  auto& calls = *new (share(sizeof(Calls))) Calls{};
  auto& traces = *new (share(sizeof(Traces))) Traces;
  traces.now_ns = begin * minor_frame_ns;
  bool started = false;
  Hooks hooks;
  hooks.begin = [&] {
    const auto count = [&](const SystemCall& call) {
      auto& of = started ? calls.in_flight : calls.at_start;
      ++of[static_cast<std::size_t>(call.kind)][static_cast<std::size_t>(call.file)];
      return Answer{};
    };
    watch_system_calls(folder, {count, {}, nullptr});
  };
  hooks.started = [&] { started = true; };
  hooks.ends = [&] { return traces.frames >= first_frames; };
  int status = 0;
  static_cast<void>(run_apart([&] { return live(reference.world, folder, reference.end_ns, traces, hooks); }, status));
  const Calls result = calls;
  unshare(&calls, sizeof(calls));
  unshare(&traces, sizeof(traces));
  return result;
}

/// One pair of those that occur, each as likely, and one of its calls.
void draw_call(const std::uint32_t (&counts)[call_kinds][file_kinds], bool link_too, Rng& rng, Fault& fault) {
  std::vector<std::pair<CallKind, FileKind>> pairs;
  for (std::size_t k = 0; k < call_kinds; ++k) {
    for (std::size_t f = 0; f < file_kinds; ++f) {
      const auto file = static_cast<FileKind>(f);
      if (counts[k][f] == 0 || (file == FileKind::link && !link_too)) continue;
      pairs.emplace_back(static_cast<CallKind>(k), file);
    }
  }
  const auto [kind, file] = pairs[rng.below(static_cast<std::uint32_t>(pairs.size()))];
  fault.kind = kind;
  fault.file = file;
  fault.before = rng.below(counts[static_cast<std::size_t>(kind)][static_cast<std::size_t>(file)]);
}

Effect draw_effect(CallKind kind, Rng& rng) {
  if (kind == CallKind::map) return Effect::io_error;
  const std::uint32_t draw = rng.below(4);
  if (draw == 0) return Effect::interrupted;
  if (draw == 1 && (kind == CallKind::read || kind == CallKind::write)) return Effect::half;
  if (draw == 2 && kind != CallKind::read) return Effect::no_capacity;
  return Effect::io_error;
}

Fault draw_fault(Class what, const Calls& calls, Rng& rng) {
  Fault fault{.what = what, .at_start = rng.below(3) == 0};
  draw_call(fault.at_start ? calls.at_start : calls.in_flight, true, rng, fault);
  fault.effect = draw_effect(fault.kind, rng);
  // The count of calls begins with the boot's first minor frame.
  switch (what) {
    case Class::one:
      break;
    case Class::burst: {
      constexpr std::uint32_t longest[] = {4, 32, 256};
      fault.calls = 2 + rng.below(longest[rng.below(3)]);
      break;
    }
    case Class::seconds:
      fault.effect = rng.below(4) == 0 ? Effect::no_capacity : Effect::io_error;
      fault.calls = always;
      fault.length_ns = (1 + rng.below(50)) * 100 * ns_per_ms;
      fault.writes_only = rng.below(2) == 0;
      break;
    case Class::full:
      fault.effect = Effect::full;
      fault.calls = always;
      fault.length_ns = (1 + rng.below(50)) * 100 * ns_per_ms;
      break;
    case Class::flips:
      break;
  }
  fault.end = static_cast<End>(rng.below(4));
  if (fault.end == End::in_order) {
    fault.end_after = rng.below(later_frames);
  } else {
    constexpr std::uint32_t longest[] = {1, 8, 64, 512};
    fault.end_after = rng.below(longest[rng.below(4)]);
  }
  fault.end_in_half = rng.below(2) == 0;
  fault.loss = static_cast<Loss>(rng.below(3));
  const std::uint32_t beside = rng.below(8);
  fault.beside = beside < 2 ? Beside::reader : beside < 3 ? Beside::lock : Beside::nobody;
  fault.beside_from = rng.below(first_frames);
  // Who reads may stay until the next start.
  fault.beside_until = fault.beside_from + 1 + rng.below(fault.beside == Beside::lock ? 3 : 100);
  return fault;
}

void describe(const Fault& fault, std::int64_t begin, bool in_order, const Reported& reported, TrialRecord& record) {
  std::string group;
  switch (fault.what) {
    case Class::one:
      group = fault.beside == Beside::nobody ? "one " + std::string(call_name(fault.kind)) : "one call";
      break;
    case Class::burst:
      group = "a burst";
      break;
    case Class::seconds:
      group = "every call for seconds";
      break;
    case Class::full:
      group = "disk full for seconds";
      break;
    case Class::flips:
      break;
  }
  if (fault.at_start && fault.beside == Beside::nobody) group += " at a start";
  std::snprintf(record.group, sizeof(record.group), "%s", reported.met ? group.c_str() : "not met");
  std::snprintf(record.what, sizeof(record.what), "minor frame %lld%s, %s (%lld), %s%s%s%s%s",
                static_cast<long long>(begin), in_order ? " after an end in order" : "", reported.where,
                static_cast<long long>(fault.before), effect_names[static_cast<std::size_t>(fault.effect)],
                fault.writes_only ? " of writes" : "", end_names[static_cast<std::size_t>(fault.end)],
                fault.end == End::power_cut ? (fault.loss == Loss::all     ? " (all lost)"
                                               : fault.loss == Loss::parts ? " (parts lost)"
                                                                           : " (nothing lost)")
                                            : "",
                reported.stayed ? ", neighbour in" : "");
}

bool condemns(std::uint16_t code) {
  const auto is = [code](StatusCode other) { return code == static_cast<std::uint16_t>(other); };
  return is(StatusCode::store_set_aside) || is(StatusCode::store_salvaged) || is(StatusCode::log_damaged);
}

/// Looks at the database between the boots of a trial.
class Auditor {
 public:
  Auditor(const fs::path& folder, const Traces& traces, const CommitLedger* ledger)
      : folder_(folder), traces_(traces), ledger_(ledger) {}

  /// After a boot. `faultless`: it met no fault.
  void look(bool faultless) {
    check_updates(faultless);
    const Inspection seen = inspect(folder_, ledger_);
    if (!seen.done) throw std::runtime_error("a database cannot be inspected");
    // The ledger is that of the first boot.
    ledger_ = nullptr;
    valid_ = seen.valid && (content_ == 0 || seen.content == content_);
    if (boots_described) {
      std::printf("  database %s, a start: %s\n", valid_ ? "valid" : "not valid",
                  seen.start.ok() ? "ok" : status_text(seen.start.code));
    }
    if (valid_ && !seen.start.ok()) note(refused_valid_, "refused: ", seen.start);
    if (seen.missing > 0) {
      note(confirmed_lost_, "missing: ", {StatusCode::not_found, seen.missing_id, seen.missing_type});
    }
  }
  /// The same for the last boot, when nothing starts any more.
  void check_updates(bool faultless) {
    for (; reported_ < traces_.updates; ++reported_) {
      const std::uint16_t code = traces_.statuses[reported_];
      const bool leaves = faultless && code == static_cast<std::uint16_t>(StatusCode::store_in_memory);
      if (valid_ && (condemns(code) || leaves)) note(refused_valid_, "at a start: ", static_cast<StatusCode>(code));
    }
  }
  /// From now on a valid database has this content.
  void expect(std::uint64_t content) { content_ = content; }

  [[nodiscard]] bool refused_valid() const { return refused_valid_; }
  [[nodiscard]] bool confirmed_lost() const { return confirmed_lost_; }
  [[nodiscard]] const std::string& words() const { return words_; }

 private:
  void note(bool& verdict, const char* what, const Status& status) {
    verdict = true;
    words_ += std::string("; ") + what + status_text(status.code);
    if (status.code == StatusCode::not_found) {
      words_ += std::string(" ") + record_info(static_cast<RecordType>(status.b)).name + " " + std::to_string(status.a);
    }
  }

  fs::path folder_;
  const Traces& traces_;
  const CommitLedger* ledger_;
  bool valid_ = true;
  std::uint64_t content_ = 0;
  std::uint32_t reported_ = 0;
  bool refused_valid_ = false, confirmed_lost_ = false;
  std::string words_;
};

void conclude(const Auditor& auditor, bool may_lose, TrialRecord& record) {
  Verdict& verdict = record.verdict;
  constexpr RecordMask downlink = mask_of(RecordType::downlink);
  verdict.refused_valid = auditor.refused_valid();
  verdict.confirmed_lost = auditor.confirmed_lost() || (verdict.difference.altered & downlink) != 0 ||
                           (!may_lose && verdict.difference.gone != 0);
  const std::size_t length = std::strlen(record.what);
  std::snprintf(record.what + length, sizeof(record.what) - length, "%s", auditor.words().c_str());
}

struct Trial {
  const Reference& reference;
  const CampaignOptions& options;
  const std::vector<Calls>& calls;
};

void fly_with_fault(const Trial& trial, Class what, std::uint64_t seed, Rng& rng, const fs::path& folder,
                    TrialRecord& record) {
  const std::uint32_t snapshot = rng.below(static_cast<std::uint32_t>(trial.calls.size() / 2));
  const std::int64_t begin = snapshot * snapshot_frames;
  const bool in_order = rng.below(2) == 1;
  const Fault fault = draw_fault(what, trial.calls[2 * snapshot + (in_order ? 1 : 0)], rng);
  copy_snapshot(trial.reference.snapshot(begin, in_order), folder);
  auto& traces = *new (share(sizeof(Traces))) Traces;
  auto& reported = *new (share(sizeof(Reported))) Reported;
  auto& ledger = *new (share(sizeof(CommitLedger))) CommitLedger;
  std::optional<Neighbour> neighbour;
  if (fault.beside != Beside::nobody) neighbour.emplace(folder / "flight.db");
  Disturber disturber(fault, folder, traces, neighbour ? &*neighbour : nullptr, seed, reported);
  Hooks hooks = disturber.hooks();
  hooks.ledger = &ledger;
  Auditor auditor(folder, traces, &ledger);
  const auto between = [&](int boots) {
    // Only who reads may stay beyond the boot.
    if (neighbour && (fault.end == End::power_cut || fault.beside == Beside::lock)) neighbour->kill();
    auditor.look(boots > 1);
  };
  record.verdict = fly_trial(trial.reference, folder, begin * minor_frame_ns, trial.reference.settled(begin), traces,
                             hooks, between);
  neighbour.reset();
  if (record.verdict.boots == 1) {
    auditor.look(false);
  } else {
    auditor.check_updates(true);
  }
  describe(fault, begin, in_order, reported, record);
  conclude(auditor, false, record);
  unshare(&traces, sizeof(traces));
  unshare(&reported, sizeof(reported));
  unshare(&ledger, sizeof(ledger));
}

constexpr const char* spoilt_files[] = {"flight.db", "flight.db-wal", "flight.db-sync", "flight.db-shm"};
constexpr const char* spoilt_groups[] = {"flips in the database", "flips in the log", "flips in the mark of the log",
                                         "flips in the index of the log"};

/// One bit; some of a sector; or the whole sector, which is zero then.
std::string spoil(const fs::path& file, Rng& rng) {
  const auto bytes = static_cast<std::uint32_t>(fs::file_size(file));
  const int handle = ::open(file.c_str(), O_RDWR | O_CLOEXEC);
  const std::uint32_t sector = rng.below(bytes) / 512 * 512;
  const std::uint32_t length = std::min<std::uint32_t>(512, bytes - sector);
  std::vector<std::uint8_t> octets(length);
  bool done = handle >= 0 && ::pread(handle, octets.data(), length, sector) == static_cast<ssize_t>(length);
  const std::uint32_t how = rng.below(4);
  const std::uint32_t bits = how < 2 ? 1 : how == 2 ? 2 + rng.below(15) : 0;
  for (std::uint32_t n = 0; n < bits; ++n) {
    octets[rng.below(length)] ^= static_cast<std::uint8_t>(1U << rng.below(8));
  }
  if (bits == 0) std::fill(octets.begin(), octets.end(), std::uint8_t{0});
  done = done && ::pwrite(handle, octets.data(), length, sector) == static_cast<ssize_t>(length);
  if (handle >= 0) ::close(handle);
  if (!done) throw std::runtime_error("cannot write to " + file.string());
  return (bits == 0 ? "all" : std::to_string(bits)) + " bits of the sector at " + std::to_string(sector);
}

/// A boot that ends somehow, then flips in the files, or in a control none, then the next boot.
void fly_with_flips(const Trial& trial, Rng& rng, const fs::path& folder, TrialRecord& record) {
  const std::uint32_t snapshot = rng.below(static_cast<std::uint32_t>(trial.calls.size() / 2));
  const std::int64_t begin = snapshot * snapshot_frames;
  copy_snapshot(trial.reference.snapshot(begin, rng.below(2) == 1), folder);
  auto& traces = *new (share(sizeof(Traces))) Traces;
  const bool killed = rng.below(4) != 0;
  const std::int64_t ended_at = 1 + rng.below(first_frames);
  Hooks hooks;
  hooks.ends = [&] { return !killed && traces.frames >= ended_at; };
  hooks.frame = [&](std::int64_t frame) {
    if (killed && frame >= ended_at) _exit(boot_killed);
  };
  Auditor auditor(folder, traces, nullptr);
  std::string group = "no flip", where;
  const auto between = [&](int boots) {
    if (boots == 1) {
      auditor.expect(inspect(folder, nullptr).content);
      const std::uint32_t draw = rng.below(10);
      const std::size_t which = draw < 3 ? 0 : draw < 6 ? 1 : draw < 7 ? 2 : draw < 8 ? 3 : 4;
      if (which < std::size(spoilt_files) && fs::exists(folder / spoilt_files[which]) &&
          fs::file_size(folder / spoilt_files[which]) > 0) {
        where = spoil(folder / spoilt_files[which], rng);
        group = spoilt_groups[which];
      }
    } else {
      auditor.expect(0);
    }
    auditor.look(boots > 1);
  };
  record.verdict = fly_trial(trial.reference, folder, begin * minor_frame_ns, trial.reference.settled(begin), traces,
                             hooks, between);
  auditor.check_updates(true);
  std::snprintf(record.group, sizeof(record.group), "%s", group.c_str());
  std::snprintf(record.what, sizeof(record.what), "minor frame %lld, %s behind %lld: %s", static_cast<long long>(begin),
                killed ? "killed" : "ended in order", static_cast<long long>(ended_at), where.c_str());
  conclude(auditor, group != "no flip", record);
  unshare(&traces, sizeof(traces));
}

}  // namespace

bool failing_files(const Reference& reference, const CampaignOptions& options) {
  // A neighbour may be gone.
  std::signal(SIGPIPE, SIG_IGN);
  // Nobody waits in virtual time.
  sleep_no_more();
  std::vector<Calls> calls;
  for (std::int64_t frame = 0; frame < reference.frames; frame += snapshot_frames) {
    for (const bool in_order : {false, true}) {
      calls.push_back(count_calls(reference, reference.snapshot(frame, in_order), frame, options.folder / "count"));
    }
  }
  const auto of_database = static_cast<std::size_t>(FileKind::database);
  if (calls[0].at_start[static_cast<std::size_t>(CallKind::read)][of_database] == 0) {
    throw std::runtime_error("SQLite's calls do not pass this layer: is it a static library?");
  }
  const Trial trial{reference, options, calls};
  const TableOptions table{.heading = "what fails", .below_the_store = true, .list = options.list};
  return run_campaign(options, table, [&](std::int64_t number, int worker, TrialRecord& record) {
    Rng rng(options.seed, static_cast<std::uint64_t>(number));
    const std::uint64_t seed = mix64(options.seed + mix64(static_cast<std::uint64_t>(number)));
    const fs::path folder = options.folder / ("worker-" + std::to_string(worker));
    // Each as often as it stands here.
    constexpr Class classes[] = {Class::one,     Class::one,  Class::one,  Class::one,   Class::burst, Class::seconds,
                                 Class::seconds, Class::full, Class::full, Class::flips, Class::flips};
    Class what = classes[rng.below(static_cast<std::uint32_t>(std::size(classes)))];
    for (std::size_t n = 0; n < std::size(class_names); ++n) {
      if (options.part == class_names[n]) what = static_cast<Class>(n);
    }
    if (what == Class::flips) {
      fly_with_flips(trial, rng, folder, record);
    } else {
      fly_with_fault(trial, what, seed, rng, folder, record);
    }
  });
}

}  // namespace ilp::faults
