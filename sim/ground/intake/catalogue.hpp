// What the ground holds of one flight, in one SQLite database: the files that came, in every version that may be right,
// and what was computed from them, until they change. Every change is whole or not at all, so that a run may be ended
// anywhere; the next one goes on.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "sim/ground/intake/outbox_reader.hpp"
#include "sim/ground/intake/tile_cache.hpp"

struct sqlite3;

namespace ilp::ground {

class Catalogue : public TileCache {
 public:
  /// Begins a new one where there is none. One that is damaged or of another version is set aside under the name
  /// NAME.damaged, with `was_set_aside`. Throws std::runtime_error when the file cannot be used at all.
  explicit Catalogue(const std::filesystem::path& file);
  ~Catalogue() override;
  Catalogue(const Catalogue&) = delete;
  Catalogue& operator=(const Catalogue&) = delete;

  [[nodiscard]] bool was_set_aside() const { return set_aside_; }

  struct Intake {
    std::size_t files = 0;  ///< in the folder
    std::size_t fresh = 0;  ///< not seen before, or changed
  };
  /// Copies what is new in the folder and is what its name says. A file that is not is noted with its fault; what is
  /// held under its name stays. `progress`: files looked at, all. Throws when the folder cannot be read, or holds
  /// another flight than the catalogue (other_flights.hpp): then nothing of it is taken.
  Intake take_in(const std::filesystem::path& folder,
                 const std::function<void(std::size_t, std::size_t)>& progress = {});

  /// Everything held, whatever has become of the folder since. What has another checksum than when it was taken in is
  /// forgotten, and has a fault.
  [[nodiscard]] Outbox outbox();

  /// A version that turned out to be damaged when it was decoded: never used again, and another one of its name is
  /// welcome.
  void reject(const ReceivedFile& file);

  [[nodiscard]] std::optional<std::vector<std::uint8_t>> look(std::int64_t keyframe_id, std::uint64_t digest);
  void put_look(std::int64_t keyframe_id, std::uint64_t digest, const std::vector<std::uint8_t>& bytes);

  std::optional<std::vector<std::uint8_t>> summary(const TileKey& key, std::uint64_t digest) override;
  std::optional<std::vector<std::uint8_t>> cells(const TileKey& key, std::uint64_t digest) override;
  void put(const TileKey& key, std::uint64_t digest, std::vector<std::uint8_t> summary,
           std::vector<std::uint8_t> cells) override;

 private:
  struct Closer {
    void operator()(sqlite3* database) const;
  };
  [[nodiscard]] bool open(const std::filesystem::path& file);
  void forget_file(const std::string& name, std::int64_t crc);
  void refuse_another_flight(const std::vector<std::filesystem::path>& paths);
  [[nodiscard]] bool is_seen(const std::string& name, std::int64_t bytes, std::int64_t modified);
  void take_file(const std::filesystem::path& path, std::int64_t bytes, std::int64_t modified, Intake& intake);

  std::mutex mutex_;
  std::unique_ptr<sqlite3, Closer> database_;
  bool set_aside_ = false;
};

}  // namespace ilp::ground
