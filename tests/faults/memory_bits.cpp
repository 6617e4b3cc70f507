#include <cstdio>
#include <cstring>
#include <new>
#include <stdexcept>

#include "fsw/base/rng.hpp"
#include "tests/faults/campaigns.hpp"
#include "tests/faults/memory_parts.hpp"
#include "tests/faults/tally.hpp"

namespace ilp::faults {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t line_bytes = 64;
constexpr std::size_t most_lines = std::size_t{1} << 23U;
/// A part that is no larger counts whole, its zeros too. Of a larger one those lines count that are not all zero at
/// some time: the images are small, the arrays have room for the largest.
constexpr std::size_t small_part_bytes = 8192;

/// Calls visit(octets, line) for the lines of all parts; lines count on from part to part.
template <typename Visit>
void for_each_line(const std::vector<MemoryPart>& parts, Visit visit) {
  std::size_t line = 0;
  for (std::size_t p = 0; p < parts.size(); ++p) {
    for (const MemoryRegion& region : parts[p].regions) {
      for (std::size_t at = 0; at < region.bytes; at += line_bytes) {
        visit(p, MemoryRegion{region.begin + at, std::min(line_bytes, region.bytes - at)}, line++);
      }
    }
  }
}

std::size_t bytes_of(const MemoryPart& part) {
  std::size_t bytes = 0;
  for (const MemoryRegion& region : part.regions) bytes += region.bytes;
  return bytes;
}

/// What the flight uses of its memory, found in flights of their own and shared with those that fly the trials.
struct Use {
  std::uint32_t parts = 0;
  char names[64][64] = {};
  std::uint64_t bytes[64] = {}, used_bytes[64] = {};
  std::uint8_t lines[most_lines] = {};
};

void mark(Use& use) {
  const std::vector<MemoryPart> parts = memory_parts();
  use.parts = static_cast<std::uint32_t>(parts.size());
  for (std::size_t p = 0; p < parts.size(); ++p) {
    std::snprintf(use.names[p], sizeof(use.names[p]), "%s", parts[p].name.c_str());
    use.bytes[p] = bytes_of(parts[p]);
  }
  for_each_line(parts, [&](std::size_t p, const MemoryRegion& octets, std::size_t line) {
    if (line >= most_lines) throw std::runtime_error("more memory than the campaign has lines for");
    if (use.lines[line] != 0) return;
    bool used = use.bytes[p] <= small_part_bytes;
    for (std::size_t i = 0; i < octets.bytes && !used; ++i) used = octets.begin[i] != std::byte{0};
    if (!used) return;
    use.lines[line] = 1;
    use.used_bytes[p] += octets.bytes;
  });
}

void find_use(const Reference& reference, const fs::path& folder, Use& use) {
  Traces& traces = *static_cast<Traces*>(share(sizeof(Traces)));
  copy_snapshot(reference.snapshot(0), folder);
  Hooks hooks;
  hooks.frame = [&](std::int64_t frame) {
    if (frame % 8 == 3 && frame < reference.frames) mark(use);
  };
  const Verdict flown = fly_trial(reference, folder, 0, reference.settled(0), traces, hooks);
  unshare(&traces, sizeof(traces));
  if (flown.outcome != Outcome::harmless || use.parts == 0) {
    throw std::runtime_error("the flight does not bear to be looked at");
  }
}

bool wanted(const char* part, const CampaignOptions& options) {
  return std::strncmp(part, options.part.c_str(), options.part.size()) == 0;
}

/// When the bit flips: before a minor frame, or after a number of steps and calls of the store in it.
struct Moment {
  std::int64_t frame = 0;
  std::int64_t hook = -1;
};

/// Every second one at the beginning of any minor frame; of the others each step and call of the flight is as likely.
Moment draw_moment(const Reference& reference, Rng& rng) {
  Moment moment;
  if (rng.below(2) == 0) {
    moment.frame = rng.below(static_cast<std::uint32_t>(reference.frames));
    return moment;
  }
  std::int64_t all = 0;
  for (const std::int64_t hooks : reference.hooks) all += hooks;
  moment.hook = rng.below(static_cast<std::uint32_t>(all));
  while (moment.hook >= reference.hooks[static_cast<std::size_t>(moment.frame)]) {
    moment.hook -= reference.hooks[static_cast<std::size_t>(moment.frame++)];
  }
  return moment;
}

struct Reported {
  char group[64] = "not spoilt";
  char what[120] = {};
};

void flip(const Use& use, std::uint32_t part, double place, unsigned bit, const Moment& moment, Reported& reported) {
  const std::vector<MemoryPart> parts = memory_parts();
  const auto wanted = static_cast<std::uint64_t>(place * static_cast<double>(use.used_bytes[part]));
  std::uint64_t passed = 0;
  std::size_t offset = 0;
  bool done = false;
  for_each_line(parts, [&](std::size_t p, const MemoryRegion& octets, std::size_t line) {
    if (p != part || done) return;
    if (use.lines[line] != 0 && wanted < passed + octets.bytes) {
      std::byte& octet = octets.begin[wanted - passed];
      octet ^= std::byte{1} << bit;
      offset += wanted - passed;
      done = true;
      return;
    }
    if (use.lines[line] != 0) passed += octets.bytes;
    offset += octets.bytes;
  });
  std::snprintf(reported.group, sizeof(reported.group), "%s", use.names[part]);
  std::snprintf(reported.what, sizeof(reported.what), "minor frame %lld, hook %lld, octet %zu bit %u",
                static_cast<long long>(moment.frame), static_cast<long long>(moment.hook), offset, bit);
}

void fly(const Reference& reference, const CampaignOptions& options, const Use& use,
         const std::vector<std::uint32_t>& parts, std::int64_t number, int worker, TrialRecord& record) {
  Rng rng(options.seed, static_cast<std::uint64_t>(number));
  const Moment moment = draw_moment(reference, rng);
  // Every part in turn: a state of a few hundred octets is as important as a workspace of many.
  const std::uint32_t part = parts[static_cast<std::size_t>(number) % parts.size()];
  const double place = rng.uniform();
  const unsigned bit = rng.below(8);
  const std::int64_t begin = moment.frame / snapshot_frames * snapshot_frames;
  const fs::path folder = options.folder / ("worker-" + std::to_string(worker));
  copy_snapshot(reference.snapshot(begin), folder);
  Traces& traces = *static_cast<Traces*>(share(sizeof(Traces)));
  Reported& reported = *new (share(sizeof(Reported))) Reported;

  std::int64_t until = -1;  // hooks; -1: not in this minor frame
  const auto pass = [&] {
    if (until >= 0 && until-- == 0) flip(use, part, place, bit, moment, reported);
  };
  Hooks hooks;
  hooks.frame = [&](std::int64_t frame) {
    until = -1;
    if (begin + frame != moment.frame) return;
    if (moment.hook < 0) flip(use, part, place, bit, moment, reported);
    until = moment.hook;
  };
  hooks.step = pass;
  hooks.call = [&](const test::FailingStore::Call&) {
    pass();
    return Status{};
  };
  record.verdict = fly_trial(reference, folder, begin * minor_frame_ns, reference.settled(begin), traces, hooks);
  std::memcpy(record.group, reported.group, sizeof(record.group));
  std::memcpy(record.what, reported.what, sizeof(record.what));
  unshare(&traces, sizeof(traces));
  unshare(&reported, sizeof(reported));
}

}  // namespace

bool bits_in_memory(const Reference& reference, const CampaignOptions& options) {
  Use& use = *new (share(sizeof(Use))) Use;
  find_use(reference, options.folder / "use", use);
  std::vector<std::uint32_t> parts;
  for (std::uint32_t p = 0; p < use.parts; ++p) {
    if (use.used_bytes[p] != 0 && wanted(use.names[p], options)) parts.push_back(p);
  }
  if (parts.empty()) throw std::runtime_error("no such part of the memory is in use");
  TableOptions table{
      .heading = "part of the memory", .ends_are_faults = false, .measured = "workspaces", .list = options.list};
  std::printf("| part of the memory | octets | of these in use |\n|---|---|---|\n");
  for (std::uint32_t p = 0; p < use.parts; ++p) {
    table.order.emplace_back(use.names[p]);
    std::printf("| %s | %llu | %llu |\n", use.names[p], static_cast<unsigned long long>(use.bytes[p]),
                static_cast<unsigned long long>(use.used_bytes[p]));
  }
  return run_campaign(options, table, [&](std::int64_t number, int worker, TrialRecord& record) {
    fly(reference, options, use, parts, number, worker, record);
  });
}

}  // namespace ilp::faults
