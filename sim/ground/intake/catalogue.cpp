#include "sim/ground/intake/catalogue.hpp"

#include <span>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "fsw/base/crc.hpp"
#include "sim/host/files.hpp"

namespace ilp::intake {
namespace {
namespace fs = std::filesystem;

using Bytes = std::vector<std::uint8_t>;

/// Versions of one file that are kept; a link that damages files does not fill the disk.
constexpr std::int64_t max_versions = 4;

const char* table_of(TileStage stage) {
  return stage == TileStage::painted ? "tile" : "finished_tile";
}

/// Rolled back unless committed.
class Transaction {
 public:
  explicit Transaction(CatalogueDatabase& database) : database_(&database) { database.begin(); }
  ~Transaction() {
    if (database_ != nullptr) database_->roll_back();
  }
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;
  void commit() {
    database_->commit();
    database_ = nullptr;
  }

 private:
  CatalogueDatabase* database_;
};

std::int64_t modified_at(const fs::path& path) {
  std::error_code error;
  const auto time = fs::last_write_time(path, error);
  return error ? 0 : static_cast<std::int64_t>(time.time_since_epoch().count());
}

// SQLite's integers are signed.
std::int64_t signed_of(std::uint64_t digest) {
  return static_cast<std::int64_t>(digest);
}

std::string fault_of(const fs::path& path, std::int64_t size, Bytes& contents) {
  try {
    if (static_cast<std::uintmax_t>(size) > max_file_bytes)
      throw BadFile("larger than any file of the flight software");
    contents = host::read_file(path);
    check_file(path.filename().string(), contents);
    return "";
  } catch (const std::exception& fault) {
    return fault.what();
  }
}

}  // namespace

Catalogue::~Catalogue() = default;

Catalogue::Catalogue(const fs::path& file, bool known_valid)
    : folder_(fs::absolute(file).parent_path()), database_(open_catalogue_file(file, known_valid)) {
  if (database_) return;
  quarantined_ = true;
  for (const char* part : {"", "-wal", "-shm"}) {
    std::error_code ignored;
    fs::rename(file.string() + part, file.string() + ".damaged" + part, ignored);
  }
  database_ = open_catalogue_file(file, false);
  if (!database_) throw std::runtime_error("catalogue " + file.string() + ": cannot be started over");
}

Catalogue::Catalogue(const std::string& address, const std::string& mission, const fs::path& folder)
    : folder_(fs::absolute(folder)), database_(open_catalogue_server(address, mission)) {}

void Catalogue::forget_everything() {
  const std::lock_guard lock(mutex_);
  Transaction transaction(*database_);
  for (const char* table : {"seen", "file", "look", "result", "tile", "finished_tile"}) {
    database_->prepare(std::string("DELETE FROM ") + table + " WHERE {and}1 = 1")->run();
  }
  transaction.commit();
}

bool Catalogue::is_seen(const std::string& name, std::int64_t bytes, std::int64_t modified) {
  const auto seen = database_->prepare("SELECT 1 FROM seen WHERE {and}name = ? AND bytes = ? AND modified = ?");
  return seen->bind(name).bind(bytes).bind(modified).step();
}

/// Only a file that comes under a name that is already held can show that it belongs to another flight.
void Catalogue::refuse_another_flight(const std::vector<fs::path>& paths) {
  for (const fs::path& path : paths) {
    const std::string name = path.filename().string();
    std::error_code error;
    const auto size = static_cast<std::int64_t>(fs::file_size(path, error));
    if (!name.ends_with(".ilp") || error || is_seen(name, size, modified_at(path))) continue;
    const auto held =
        database_->prepare("SELECT contents FROM file WHERE {and}name = ? AND fault = '' ORDER BY rowid LIMIT 1");
    Bytes contents;
    if (!held->bind(name).step() || !fault_of(path, size, contents).empty()) continue;
    const std::vector<RecordFile> both{{0, parse_record_file(held->bytes(0))}, {1, parse_record_file(contents)}};
    if (files_of_other_flights(both).empty()) continue;
    throw std::runtime_error("the results are of another flight than " + path.string() +
                             ": choose another folder for them, or begin afresh (--afresh)");
  }
}

void Catalogue::take_file(const fs::path& path, std::int64_t bytes, std::int64_t modified, Intake& intake) {
  const std::string name = path.filename().string();
  if (is_seen(name, bytes, modified)) return;
  ++intake.fresh;
  Bytes contents;
  const std::string fault = fault_of(path, bytes, contents);
  database_
      ->prepare(
          "INSERT INTO seen({key}name, bytes, modified, fault) VALUES({value}?, ?, ?, ?) ON CONFLICT({key}name) "
          "DO UPDATE SET bytes = excluded.bytes, modified = excluded.modified, fault = excluded.fault")
      ->bind(name)
      .bind(bytes)
      .bind(modified)
      .bind(fault)
      .run();
  if (!fault.empty()) return;
  const auto versions = database_->prepare("SELECT count(*) FROM file WHERE {and}name = ? AND fault = ''");
  versions->bind(name).step();
  if (versions->integer(0) >= max_versions) return;
  database_
      ->prepare(
          "INSERT INTO file({key}name, crc32, bytes, fault, contents) VALUES({value}?, ?, ?, '', ?) "
          "ON CONFLICT DO NOTHING")
      ->bind(name)
      .bind(std::int64_t{crc32(contents)})
      .bind(bytes)
      .bind(std::span<const std::uint8_t>(contents))
      .run();
}

Catalogue::Intake Catalogue::take_in(const fs::path& folder,
                                     const std::function<void(std::size_t, std::size_t)>& progress) {
  const std::lock_guard lock(mutex_);
  const std::vector<fs::path> paths = files_of(folder);
  refuse_another_flight(paths);
  Intake intake;
  intake.files = paths.size();
  constexpr std::size_t files_at_once = 64;
  for (std::size_t begin = 0; begin < paths.size(); begin += files_at_once) {
    const std::size_t end = std::min(begin + files_at_once, paths.size());
    Transaction transaction(*database_);
    for (std::size_t i = begin; i < end; ++i) {
      std::error_code error;
      const auto size = fs::file_size(paths[i], error);
      if (!error) take_file(paths[i], static_cast<std::int64_t>(size), modified_at(paths[i]), intake);
    }
    transaction.commit();
    if (progress) progress(end, paths.size());
  }
  return intake;
}

Outbox Catalogue::outbox() {
  const std::lock_guard lock(mutex_);
  OutboxBuilder builder(std::make_shared<Spool>(folder_));
  const auto held = database_->prepare(
      "SELECT name, contents, crc32 FROM file WHERE {and}fault = '' ORDER BY name, bytes, crc32", true);
  std::vector<std::pair<std::string, std::int64_t>> damaged;
  while (held->step()) {
    Bytes contents = held->bytes(1);
    if (std::int64_t{crc32(contents)} == held->integer(2)) {
      builder.add(held->text(0), std::move(contents));
    } else {
      damaged.emplace_back(held->text(0), held->integer(2));
    }
  }
  lost_files_ = lost_files_ || !damaged.empty();
  for (const auto& [name, crc] : damaged) {
    forget_file(name, crc);
    ReceivedFile file;
    file.name = name;
    file.fault = "damaged in the catalogue: it is taken in again where it is still there";
    builder.add_fault(std::move(file));
  }
  // What was seen and is not held, unless another version of it is.
  const auto faulty = database_->prepare(
      "SELECT name, bytes, fault FROM seen WHERE {and}fault <> '' AND NOT EXISTS "
      "(SELECT 1 FROM file WHERE {and}file.name = seen.name AND file.fault = '') UNION "
      "SELECT name, bytes, fault FROM file WHERE {and}fault <> '' ORDER BY name");
  while (faulty->step()) {
    ReceivedFile file;
    file.name = faulty->text(0);
    file.bytes = static_cast<std::uint64_t>(faulty->integer(1));
    file.fault = faulty->text(2);
    builder.add_fault(std::move(file));
  }
  return builder.finish();
}

/// As if it had never come.
void Catalogue::forget_file(const std::string& name, std::int64_t crc) {
  Transaction transaction(*database_);
  database_->prepare("DELETE FROM file WHERE {and}name = ? AND crc32 = ?")->bind(name).bind(crc).run();
  database_->prepare("DELETE FROM seen WHERE {and}name = ?")->bind(name).run();
  transaction.commit();
}

void Catalogue::reject(const ReceivedFile& file) {
  const std::lock_guard lock(mutex_);
  database_->prepare("UPDATE file SET fault = ?, contents = NULL WHERE {and}name = ? AND crc32 = ?")
      ->bind(file.fault)
      .bind(file.name)
      .bind(std::int64_t{file.crc32})
      .run();
}

std::optional<Bytes> Catalogue::quick_look(std::int64_t keyframe_id, std::uint64_t digest) {
  const std::lock_guard lock(mutex_);
  const auto found = database_->prepare("SELECT bytes FROM look WHERE {and}keyframe = ? AND digest = ?");
  return found->bind(keyframe_id).bind(signed_of(digest)).step() ? std::optional(found->bytes(0)) : std::nullopt;
}

void Catalogue::put_quick_look(std::int64_t keyframe_id, std::uint64_t digest, const Bytes& bytes) {
  const std::lock_guard lock(mutex_);
  database_
      ->prepare(
          "INSERT INTO look({key}keyframe, digest, bytes) VALUES({value}?, ?, ?) ON CONFLICT({key}keyframe) "
          "DO UPDATE SET digest = excluded.digest, bytes = excluded.bytes")
      ->bind(keyframe_id)
      .bind(signed_of(digest))
      .bind(std::span<const std::uint8_t>(bytes))
      .run();
}

std::optional<Bytes> Catalogue::result(std::uint64_t digest) {
  const std::lock_guard lock(mutex_);
  const auto found = database_->prepare("SELECT crc32, bytes FROM result WHERE {and}digest = ?");
  if (!found->bind(signed_of(digest)).step()) return std::nullopt;
  Bytes bytes = found->bytes(1);
  if (found->integer(0) != std::int64_t{crc32(bytes)}) return std::nullopt;
  results_used_.insert(signed_of(digest));
  return bytes;
}

void Catalogue::put_result(std::uint64_t digest, const Bytes& bytes) {
  const std::lock_guard lock(mutex_);
  results_used_.insert(signed_of(digest));
  database_
      ->prepare(
          "INSERT INTO result({key}digest, crc32, bytes) VALUES({value}?, ?, ?) ON CONFLICT({key}digest) "
          "DO UPDATE SET crc32 = excluded.crc32, bytes = excluded.bytes")
      ->bind(signed_of(digest))
      .bind(std::int64_t{crc32(bytes)})
      .bind(std::span<const std::uint8_t>(bytes))
      .run();
}

void Catalogue::keep_results(const std::set<std::uint64_t>& digests) {
  const std::lock_guard lock(mutex_);
  for (const std::uint64_t digest : digests) results_used_.insert(signed_of(digest));
}

void Catalogue::forget_other_results() {
  const std::lock_guard lock(mutex_);
  std::vector<std::int64_t> others;
  const auto all = database_->prepare("SELECT digest FROM result WHERE {and}1 = 1");
  while (all->step()) {
    if (!results_used_.contains(all->integer(0))) others.push_back(all->integer(0));
  }
  for (const std::int64_t digest : others)
    database_->prepare("DELETE FROM result WHERE {and}digest = ?")->bind(digest).run();
}

std::optional<Bytes> Catalogue::tile_part(const char* column, const TileKey& key, std::uint64_t digest) {
  const auto found = database_->prepare((std::string("SELECT ") + column + " FROM " + table_of(key.stage) +
                                         " WHERE {and}strip = ? AND \"row\" = ? AND \"column\" = ? AND digest = ?"));
  found->bind(key.strip_id).bind(key.place.row).bind(key.place.column).bind(signed_of(digest));
  return found->step() ? std::optional(found->bytes(0)) : std::nullopt;
}

std::optional<Bytes> Catalogue::summary(const TileKey& key, std::uint64_t digest) {
  const std::lock_guard lock(mutex_);
  return tile_part("summary", key, digest);
}

std::optional<Bytes> Catalogue::cells(const TileKey& key, std::uint64_t digest) {
  const std::lock_guard lock(mutex_);
  return tile_part("cells", key, digest);
}

void Catalogue::put(const TileKey& key, std::uint64_t digest, Bytes summary, Bytes cells) {
  const std::lock_guard lock(mutex_);
  database_
      ->prepare(std::string("INSERT INTO ") + table_of(key.stage) +
                "({key}strip, \"row\", \"column\", digest, summary, cells) VALUES({value}?, ?, ?, ?, ?, ?) "
                "ON CONFLICT({key}strip, \"row\", \"column\") DO UPDATE SET digest = excluded.digest, "
                "summary = excluded.summary, cells = excluded.cells")
      ->bind(key.strip_id)
      .bind(key.place.row)
      .bind(key.place.column)
      .bind(signed_of(digest))
      .bind(std::span<const std::uint8_t>(summary))
      .bind(std::span<const std::uint8_t>(cells))
      .run();
}

}  // namespace ilp::intake
