// The ground's catalogue of one flight, a database. It holds the downlinked files in every version that may be right,
// and results computed from them. Every change is a transaction, so that a run may be interrupted at any time and the
// next run continues.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "sim/ground/intake/catalogue_database.hpp"
#include "sim/ground/intake/outbox_reader.hpp"
#include "sim/ground/intake/result_cache.hpp"
#include "sim/ground/intake/tile_cache.hpp"

namespace ilp::intake {

/// File name of the catalogue in the folder of the results.
inline constexpr const char* catalogue_name = "catalogue.db";

class Catalogue : public TileCache, public ResultCache {
 public:
  /// Opens or creates a catalogue in an SQLite file. A file that is damaged or of another version is renamed to
  /// NAME.damaged; then was_quarantined() is true. `known_valid`: the file has not changed since a run ended, so that
  /// it is not read completely to find damage. Throws std::runtime_error if the file cannot be used at all.
  explicit Catalogue(const std::filesystem::path& file, bool known_valid = false);
  /// Opens the mission's part of a database on a server (catalogue_database.hpp). `folder`: the folder of the results.
  /// Throws std::runtime_error.
  Catalogue(const std::string& address, const std::string& mission, const std::filesystem::path& folder);
  ~Catalogue() override;
  Catalogue(const Catalogue&) = delete;
  Catalogue& operator=(const Catalogue&) = delete;

  [[nodiscard]] bool was_quarantined() const { return quarantined_; }

  void forget_everything();

  /// On a server, the number that keep_mark() stored last: a changed number shows that another run has used the
  /// mission's part. 0 for a file.
  [[nodiscard]] std::uint64_t mark() { return database_->mark(); }
  void keep_mark(std::uint64_t mark) { database_->keep_mark(mark); }

  struct Intake {
    std::size_t files = 0;  ///< files in the folder
    std::size_t fresh = 0;  ///< files that are new or have changed
  };
  /// Copies those new files of the folder whose content matches their name. Records any other new file with its fault;
  /// versions held under its name stay. `progress` gets the number of files checked and of all files. Throws
  /// std::runtime_error, and copies nothing, if the folder cannot be read, or is of another flight than the catalogue
  /// (other_flights.hpp).
  Intake take_in(const std::filesystem::path& folder,
                 const std::function<void(std::size_t, std::size_t)>& progress = {});

  /// Assembles all files of the catalogue, also those that the folder no longer has. A file whose bytes do not match
  /// their checksum is deleted from the catalogue and listed with a fault.
  [[nodiscard]] Outbox outbox();

  /// Whether outbox() has deleted files; the next run takes them in again if the folder still has them.
  [[nodiscard]] bool has_lost_files() const { return lost_files_; }

  /// Marks a version of a file that could not be decoded: it is not used again, and another version may be taken in.
  void reject(const ReceivedFile& file);

  [[nodiscard]] std::optional<std::vector<std::uint8_t>> quick_look(std::int64_t keyframe_id, std::uint64_t digest);
  void put_quick_look(std::int64_t keyframe_id, std::uint64_t digest, const std::vector<std::uint8_t>& bytes);

  std::optional<std::vector<std::uint8_t>> summary(const TileKey& key, std::uint64_t digest) override;
  std::optional<std::vector<std::uint8_t>> cells(const TileKey& key, std::uint64_t digest) override;
  void put(const TileKey& key, std::uint64_t digest, std::vector<std::uint8_t> summary,
           std::vector<std::uint8_t> cells) override;

  /// Returns none also if the bytes do not match their checksum.
  std::optional<std::vector<std::uint8_t>> result(std::uint64_t digest) override;
  void put_result(std::uint64_t digest, const std::vector<std::uint8_t>& bytes) override;
  /// Protects these results from forget_other_results().
  void keep_results(const std::set<std::uint64_t>& digests);
  /// Deletes all results that this object has not found, put or kept.
  void forget_other_results();

 private:
  void forget_file(const std::string& name, std::int64_t crc);
  void refuse_another_flight(const std::vector<std::filesystem::path>& paths);
  [[nodiscard]] bool is_seen(const std::string& name, std::int64_t bytes, std::int64_t modified);
  [[nodiscard]] std::optional<std::vector<std::uint8_t>> tile_part(const char* column, const TileKey& key,
                                                                   std::uint64_t digest);
  void take_file(const std::filesystem::path& path, std::int64_t bytes, std::int64_t modified, Intake& intake);

  std::filesystem::path folder_;
  std::mutex mutex_;
  std::unique_ptr<CatalogueDatabase> database_;
  std::set<std::int64_t> results_used_;
  bool quarantined_ = false, lost_files_ = false;
};

}  // namespace ilp::intake
