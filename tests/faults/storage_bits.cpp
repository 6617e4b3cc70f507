#include <fcntl.h>
#include <sqlite3.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <new>
#include <stdexcept>

#include "fsw/base/rng.hpp"
#include "tests/faults/campaigns.hpp"
#include "tests/faults/tally.hpp"

namespace ilp::faults {
namespace fs = std::filesystem;
namespace {

constexpr std::int64_t page_bytes = 4096;
constexpr std::int64_t log_header_bytes = 32, log_frame_header_bytes = 24;

/// Which table each page of a database belongs to, by SQLite's own account.
std::vector<std::string> owners_of_pages(const fs::path& database) {
  std::vector<std::string> owners(static_cast<std::size_t>(fs::file_size(database) / page_bytes), "free pages");
  sqlite3* db = nullptr;
  sqlite3_stmt* statement = nullptr;
  if (sqlite3_open_v2(database.c_str(), &db, SQLITE_OPEN_READONLY, nullptr) == SQLITE_OK &&
      sqlite3_prepare_v2(db, "SELECT name, pageno FROM dbstat", -1, &statement, nullptr) == SQLITE_OK) {
    while (sqlite3_step(statement) == SQLITE_ROW) {
      const auto page = static_cast<std::size_t>(sqlite3_column_int64(statement, 1));
      if (page > owners.size()) owners.resize(page, "free pages");
      owners[page - 1] = reinterpret_cast<const char*>(sqlite3_column_text(statement, 0));
    }
  }
  sqlite3_finalize(statement);
  sqlite3_close(db);
  return owners;
}

void flip(const fs::path& file, std::int64_t bit) {
  const int handle = ::open(file.c_str(), O_RDWR | O_CLOEXEC);
  std::uint8_t octet = 0;
  const off_t place = bit / 8;
  bool done = handle >= 0 && pread(handle, &octet, 1, place) == 1;
  octet = static_cast<std::uint8_t>(octet ^ (1U << (bit % 8)));
  done = done && pwrite(handle, &octet, 1, place) == 1;
  if (handle >= 0) ::close(handle);
  if (!done) throw std::runtime_error("no bit " + std::to_string(bit) + " in " + file.string());
}

std::int64_t size_of(const fs::path& file) {
  std::error_code none;
  const auto bytes = fs::file_size(file, none);
  return none ? 0 : static_cast<std::int64_t>(bytes);
}

/// Whatever has octets and is not the database, its log or the log's index.
std::vector<fs::path> files_beside(const fs::path& database) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(database.parent_path())) {
    const std::string name = entry.path().filename().string();
    const bool other = name != "flight.db" && name != "flight.db-wal" && name != "flight.db-shm";
    if (other && entry.is_regular_file() && entry.file_size() > 0) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

/// Table or part of the file that an octet of the database or its log belongs to.
std::string owner_of(const fs::path& log, bool in_log, std::int64_t place, const std::vector<std::string>& owners) {
  std::int64_t page = place / page_bytes;
  if (in_log) {
    if (place < log_header_bytes) return "log: its header";
    const std::int64_t frame = (place - log_header_bytes) / (log_frame_header_bytes + page_bytes);
    const std::int64_t begin = log_header_bytes + frame * (log_frame_header_bytes + page_bytes);
    if (place - begin < log_frame_header_bytes) return "log: headers of pages";
    std::uint8_t number[4] = {};
    std::ifstream in(log, std::ios::binary);
    in.seekg(begin);
    in.read(reinterpret_cast<char*>(number), 4);
    page = (std::int64_t{number[0]} << 24) + (number[1] << 16) + (number[2] << 8) + number[3] - 1;
  }
  const auto index = static_cast<std::size_t>(page);
  const std::string owner = page >= 0 && index < owners.size() ? owners[index] : "new pages";
  return in_log ? "log: " + owner : owner;
}

/// Tables by what a reader asks for: fields and blobs of the imaging chain apart, all else together.
std::string group_of(const std::string& owner) {
  const bool in_log = owner.rfind("log: ", 0) == 0;
  return (in_log ? "log: " : "") + [&] {
    const std::string name = in_log ? owner.substr(5) : owner;
    if (name == "frame_image" || name == "product_data" || name == "structure_points" || name == "checkpoint_state") {
      return name;
    }
    if (name.rfind("depth_", 0) == 0 || name == "mask_code") return std::string("depth_values, depth_sigma, mask_code");
    if (name == "sqlite_schema" || name == "sqlite_master") return std::string("schema");
    if (name == "free pages" || name == "new pages" || name == "its header" || name == "headers of pages") return name;
    if (name.rfind("flight.db", 0) == 0) return name;
    return std::string("records");
  }();
}

/// Where a bit of the database may flip: anywhere, or in one kind of page, each kind being as likely.
struct Pages {
  std::vector<std::string> owners;
  std::map<std::string, std::vector<std::int64_t>> kinds;
};

Pages pages_of(const fs::path& database) {
  Pages pages{.owners = owners_of_pages(database)};
  for (std::size_t page = 0; page < pages.owners.size(); ++page) {
    pages.kinds[group_of(pages.owners[page])].push_back(static_cast<std::int64_t>(page));
  }
  return pages;
}

/// Number of the bit in the file.
std::int64_t draw_place(const Pages& pages, bool any, std::int64_t file_bytes, Rng& rng) {
  if (any || pages.kinds.empty()) {
    return static_cast<std::int64_t>(rng.uniform() * static_cast<double>(file_bytes * 8));
  }
  auto kind = pages.kinds.begin();
  std::advance(kind, rng.below(static_cast<std::uint32_t>(pages.kinds.size())));
  const std::int64_t page = kind->second[rng.below(static_cast<std::uint32_t>(kind->second.size()))];
  return std::min((page * page_bytes + rng.below(page_bytes)) * 8 + rng.below(8), file_bytes * 8 - 1);
}

/// What the trial has done, as the process that did it reports.
struct Reported {
  char group[64] = "not spoilt";
  char what[120] = {};
};

void fly(const Reference& reference, const CampaignOptions& options, const std::vector<Pages>& pages,
         std::int64_t number, int worker, TrialRecord& record) {
  Rng rng(options.seed, static_cast<std::uint64_t>(number));
  const std::uint32_t snapshot = rng.below(static_cast<std::uint32_t>(pages.size() / 2));
  const std::int64_t begin = snapshot * snapshot_frames;
  const bool in_order = rng.below(2) == 1;
  const bool running = rng.below(2) == 1;
  // One in ten hits what lies beside database and log, where there is anything.
  const std::uint32_t of_file = rng.below(20);
  const std::int64_t spoilt_at = rng.below(12);
  const bool restarted = rng.below(2) == 1;
  const std::int64_t restart_at = spoilt_at + 1 + rng.below(40);
  const bool anywhere = rng.below(2) == 1;
  const Pages& found = pages[2 * snapshot + (in_order ? 1 : 0)];
  const fs::path folder = options.folder / ("worker-" + std::to_string(worker));
  const fs::path database = folder / "flight.db", log = folder / "flight.db-wal";
  copy_snapshot(reference.snapshot(begin, in_order), folder);
  Traces& traces = *static_cast<Traces*>(share(sizeof(Traces)));
  Reported& reported = *new (share(sizeof(Reported))) Reported;

  const auto spoil = [&] {
    const std::vector<fs::path> others = files_beside(database);
    const bool beside = of_file < 2 && !others.empty();
    const bool in_log = !beside && of_file % 2 == 1 && size_of(log) > 0;
    const fs::path file = beside   ? others[rng.below(static_cast<std::uint32_t>(others.size()))]
                          : in_log ? log
                                   : database;
    const std::int64_t at = draw_place(found, anywhere || file != database, size_of(file), rng);
    flip(file, at);
    const std::string owner = beside ? file.filename().string() : owner_of(log, in_log, at / 8, found.owners);
    std::snprintf(reported.group, sizeof(reported.group), "%s", group_of(owner).c_str());
    std::snprintf(reported.what, sizeof(reported.what), "minor frame %lld%s%s, octet %lld bit %lld, %s",
                  static_cast<long long>(begin + (running ? spoilt_at : 0)), in_order ? " after an end in order" : "",
                  running ? " in flight" : "", static_cast<long long>(at / 8), static_cast<long long>(at % 8),
                  owner.c_str());
  };
  Hooks hooks;
  hooks.frame = [&](std::int64_t frame) {
    if (running && frame == spoilt_at) spoil();
    if (restarted && frame == restart_at) _exit(boot_killed);
  };
  if (!running) spoil();
  record.verdict = fly_trial(reference, folder, begin * minor_frame_ns, reference.settled(begin), traces, hooks);
  std::memcpy(record.group, reported.group, sizeof(record.group));
  std::memcpy(record.what, reported.what, sizeof(record.what));
  unshare(&traces, sizeof(traces));
  unshare(&reported, sizeof(reported));
}

}  // namespace

bool bits_in_storage(const Reference& reference, const CampaignOptions& options) {
  std::vector<Pages> pages;
  for (std::int64_t frame = 0; frame < reference.frames; frame += snapshot_frames) {
    for (const bool in_order : {false, true}) {
      pages.push_back(pages_of(reference.snapshot(frame, in_order) / "flight.db"));
    }
  }
  const TableOptions table{.heading = "page of", .list = options.list};
  return run_campaign(options, table, [&](std::int64_t number, int worker, TrialRecord& record) {
    fly(reference, options, pages, number, worker, record);
  });
}

}  // namespace ilp::faults
