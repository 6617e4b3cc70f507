// The ground's catalogue of one flight, an SQLite database: the files that came down, in every version that may be
// right, and results computed from them, which are valid until the files change. Every change is a transaction: a run
// may end anywhere, and the next run continues.
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

/// Of the file, in the folder of the results.
inline constexpr const char* catalogue_name = "catalogue.db";

class Catalogue : public TileCache, public ResultCache {
 public:
  /// Opens the catalogue, or creates it. A damaged catalogue, or one of another version, is renamed to NAME.damaged,
  /// and `was_quarantined` says so. `known_valid`: nothing has written to the file since a run ended, so that it need
  /// not be read whole to find damage. Throws std::runtime_error when the file cannot be used at all.
  explicit Catalogue(const std::filesystem::path& file, bool known_valid = false);
  /// The part of a mission in a database on a server (catalogue_database.hpp). `folder`: of the results.
  Catalogue(const std::string& address, const std::string& mission, const std::filesystem::path& folder);
  ~Catalogue() override;
  Catalogue(const Catalogue&) = delete;
  Catalogue& operator=(const Catalogue&) = delete;

  [[nodiscard]] bool was_quarantined() const { return quarantined_; }

  void forget_everything();

  /// On a server, a number that shows whether the mission's part is as the run that kept it has left it; else 0.
  [[nodiscard]] std::uint64_t mark() { return database_->mark(); }
  void keep_mark(std::uint64_t mark) { database_->keep_mark(mark); }

  struct Intake {
    std::size_t files = 0;  ///< in the folder
    std::size_t fresh = 0;  ///< not seen before, or changed
  };
  /// Copies new files of the folder whose content matches their name. A file that does not match is recorded with its
  /// fault, and the version held under its name stays. `progress` gets the number of files looked at and of all files.
  /// Throws when the folder cannot be read, or holds another flight than the catalogue (other_flights.hpp); nothing is
  /// copied then.
  Intake take_in(const std::filesystem::path& folder,
                 const std::function<void(std::size_t, std::size_t)>& progress = {});

  /// All files of the catalogue, whether they are still in the folder or not. A file whose checksum has changed in the
  /// catalogue is deleted from it and gets a fault.
  [[nodiscard]] Outbox outbox();

  /// Whether outbox() has deleted files, which the next run takes in again.
  [[nodiscard]] bool has_lost_files() const { return lost_files_; }

  /// Marks a version that turned out to be damaged when it was decoded: it is never used again, and another version of
  /// the file may be taken in.
  void reject(const ReceivedFile& file);

  [[nodiscard]] std::optional<std::vector<std::uint8_t>> quick_look(std::int64_t keyframe_id, std::uint64_t digest);
  void put_quick_look(std::int64_t keyframe_id, std::uint64_t digest, const std::vector<std::uint8_t>& bytes);

  std::optional<std::vector<std::uint8_t>> summary(const TileKey& key, std::uint64_t digest) override;
  std::optional<std::vector<std::uint8_t>> cells(const TileKey& key, std::uint64_t digest) override;
  void put(const TileKey& key, std::uint64_t digest, std::vector<std::uint8_t> summary,
           std::vector<std::uint8_t> cells) override;

  /// None as well where the bytes have changed in the catalogue.
  std::optional<std::vector<std::uint8_t>> result(std::uint64_t digest) override;
  void put_result(std::uint64_t digest, const std::vector<std::uint8_t>& bytes) override;
  /// As if they had been found.
  void keep_results(const std::set<std::uint64_t>& digests);
  /// Deletes the results that this object has neither found nor put.
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
