#include "tests/faults/tally.hpp"

#include <cstdio>
#include <map>
#include <new>

#include "fsw/base/status.hpp"

namespace ilp::faults {
namespace {

struct Row {
  std::int64_t trials = 0, crashed = 0, hung = 0, refused_valid = 0, confirmed_lost = 0;
  std::array<std::int64_t, static_cast<std::size_t>(Outcome::kinds)> outcomes{};

  void add(const Verdict& verdict) {
    ++trials;
    ++outcomes[static_cast<std::size_t>(verdict.outcome)];
    crashed += verdict.crashed ? 1 : 0;
    hung += verdict.hung ? 1 : 0;
    refused_valid += verdict.refused_valid ? 1 : 0;
    confirmed_lost += verdict.confirmed_lost ? 1 : 0;
  }
  void print(const char* name, bool below_the_store) const {
    std::printf("| %s | %lld |", name, static_cast<long long>(trials));
    for (const std::int64_t count : outcomes) std::printf(" %lld |", static_cast<long long>(count));
    std::printf(" %lld | %lld |", static_cast<long long>(crashed), static_cast<long long>(hung));
    if (below_the_store) {
      std::printf(" %lld | %lld |", static_cast<long long>(refused_valid), static_cast<long long>(confirmed_lost));
    }
    std::printf("\n");
  }
};

bool kept(const TrialRecord& record, const TableOptions& options) {
  const Verdict& verdict = record.verdict;
  const std::string row = record.group;
  const bool measured = !options.measured.empty() && row.ends_with(options.measured);
  if (verdict.refused_valid || verdict.confirmed_lost) return false;
  if (options.ends_are_faults && (verdict.crashed || verdict.hung)) return false;
  if (verdict.outcome == Outcome::silent) return measured;
  if (verdict.outcome == Outcome::lost) return !options.losses_are_faults;
  return verdict.outcome == Outcome::harmless || verdict.outcome == Outcome::mended;
}

}  // namespace

void print_trial(std::int64_t number, const TrialRecord& record) {
  const Verdict& verdict = record.verdict;
  std::printf("trial %lld, %s, %s: %s", static_cast<long long>(number), record.group, record.what,
              outcome_name(verdict.outcome));
  if (verdict.crashed) std::printf(", crashed by signal %d", verdict.signal);
  if (verdict.hung) std::printf(", hung");
  if (verdict.refused_valid) std::printf(", a valid database refused");
  if (verdict.confirmed_lost) std::printf(", confirmed data lost");
  if (verdict.overtime) std::printf(", not done in its time");
  std::printf(", %d boots", verdict.boots);
  const Difference& d = verdict.difference;
  if (d.items > 0) std::printf("; %d items, the first: %s", d.items, d.first);
  for (const auto& [tables, word] :
       {std::pair{d.missing, "missing"}, std::pair{d.reported, "unreadable"}, std::pair{d.changed, "changed"},
        std::pair{d.altered, "altered"}, std::pair{d.extra, "extra"}}) {
    if (tables != 0) std::printf("; %s: %s", word, names_of(tables).c_str());
  }
  for (std::uint32_t i = 0; i < verdict.codes; ++i) {
    std::printf("%s%s", i == 0 ? "; told: " : ", ", status_text(static_cast<StatusCode>(verdict.code[i])));
  }
  std::printf("\n");
}

bool print_table(const TrialRecord* records, std::int64_t trials, const TableOptions& options) {
  std::map<std::string, Row> rows;
  Row all;
  std::map<std::uint64_t, std::int64_t> lost;
  std::map<std::uint16_t, std::int64_t> codes;
  bool good = true;
  for (std::int64_t n = 0; n < trials; ++n) {
    const TrialRecord& record = records[n];
    const Verdict& verdict = record.verdict;
    rows[record.group].add(verdict);
    all.add(verdict);
    if (verdict.outcome == Outcome::lost) ++lost[verdict.difference.missing | verdict.difference.reported];
    for (std::uint32_t i = 0; i < verdict.codes; ++i) ++codes[verdict.code[i]];
    if (kept(record, options)) continue;
    good = false;
    if (options.list) print_trial(n, record);
  }
  std::printf("\n| %s | trials |", options.heading);
  for (std::size_t k = 0; k < static_cast<std::size_t>(Outcome::kinds); ++k) {
    std::printf(" %s |", outcome_name(static_cast<Outcome>(k)));
  }
  std::printf(" crashed | hung |%s\n|---|---|---|---|---|---|---|---|---|---|%s\n",
              options.below_the_store ? " valid refused | confirmed lost |" : "",
              options.below_the_store ? "---|---|" : "");
  for (const std::string& name : options.order) {
    const auto row = rows.find(name);
    if (row == rows.end()) continue;
    row->second.print(name.c_str(), options.below_the_store);
    rows.erase(row);
  }
  for (const auto& [name, row] : rows) row.print(name.c_str(), options.below_the_store);
  all.print("all", options.below_the_store);
  std::printf("\n| lost at the end | trials |\n|---|---|\n");
  for (const auto& [tables, count] : lost) {
    const std::string names = names_of(tables);
    std::printf("| %s | %lld |\n", names.empty() ? "nothing, but later results differ" : names.c_str(),
                static_cast<long long>(count));
  }
  std::printf("\n| told | trials |\n|---|---|\n");
  for (const auto& [code, count] : codes) {
    std::printf("| %s | %lld |\n", status_text(static_cast<StatusCode>(code)), static_cast<long long>(count));
  }
  std::fflush(stdout);
  return good;
}

bool run_campaign(const CampaignOptions& options, const TableOptions& table,
                  const std::function<void(std::int64_t, int, TrialRecord&)>& trial) {
  const bool alone = options.only >= 0;
  boots_described = alone;
  const std::int64_t trials = alone ? 1 : options.trials;
  auto* const records = static_cast<TrialRecord*>(share(static_cast<std::size_t>(trials) * sizeof(TrialRecord)));
  for (std::int64_t n = 0; n < trials; ++n) new (records + n) TrialRecord;
  run_trials(trials, alone ? 1 : options.jobs,
             [&](std::int64_t number, int worker) { trial(alone ? options.only : number, worker, records[number]); });
  if (alone) print_trial(options.only, records[0]);
  const bool good = alone ? kept(records[0], table) : print_table(records, trials, table);
  unshare(records, static_cast<std::size_t>(trials) * sizeof(TrialRecord));
  return good;
}

}  // namespace ilp::faults
