// What a flight has left, item by item, and how another flight differs from it.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "cfg/limits.hpp"
#include "fsw/records/records.hpp"
#include "hal/store/store.hpp"

namespace ilp::faults {

/// A record by its table and id. Times, counts and other values that depend on when a process was started are no
/// result: is_result says which fields count.
using RecordKey = std::pair<RecordType, std::int64_t>;

/// Checksums of its fields and of its blobs, in their order.
struct Digest {
  std::uint32_t fields = 0;
  std::array<std::uint32_t, limits::max_blob_fields> blobs{};  ///< 0: none, or released

  [[nodiscard]] bool same(RecordType type, const Digest& other) const;
};

/// Files as they came to the ground, by name.
using GroundFiles = std::map<std::string, std::vector<std::uint8_t>>;

struct Results {
  std::map<RecordKey, Digest> records;
  std::map<std::string, std::uint64_t> files;  ///< checksums of products, points, records (results_of(GroundFiles))
  std::set<std::uint16_t> events;              ///< codes
};

/// Whether a flight that is undisturbed but for its restarts leaves the same in this field.
[[nodiscard]] bool is_result(RecordType type, const FieldInfo& field);

/// The results in an undamaged database. std::runtime_error if it is damaged.
[[nodiscard]] Results results_of(const std::filesystem::path& folder);
[[nodiscard]] Results results_of(Store& store);
/// Digest of fields and blobs; the status of a part that could not be read.
Status digest_of(Store& store, const RecordInfo& info, std::int64_t id, Digest& digest);
[[nodiscard]] GroundFiles files_of(const std::filesystem::path& folder);
/// Products with their refinements: a product may come in one file or in several, and is the same. Files of events are
/// left out: they describe the trial.
[[nodiscard]] std::map<std::string, std::uint64_t> results_of(GroundFiles files);

/// How the results of a trial differ from those of the undisturbed flight. Bits are those of RecordType, and one more
/// for the files on the ground.
struct Difference {
  std::uint64_t missing = 0;   ///< tables where something is not there
  std::uint64_t reported = 0;  ///< ... is damaged, and reading it says so
  std::uint64_t changed = 0;   ///< ... is other than it was
  std::uint64_t extra = 0;     ///< ... is there that was not
  std::uint64_t altered =
      0;  ///< of the changed ones: right in the store before the fault, or not on the ground though confirmed
  std::uint64_t gone = 0;  ///< of the missing ones: in the store before the fault
  std::int32_t items = 0;
  char first[80] = {};  ///< one of them, for people

  [[nodiscard]] bool any() const { return (missing | reported | changed | extra) != 0; }
};
inline constexpr unsigned ground_files = 63;
[[nodiscard]] std::string names_of(std::uint64_t tables);

/// `before`: records as they stood when the fault came. `events` receives the codes of the trial's events.
[[nodiscard]] Difference compare(const Results& expected, const std::set<RecordKey>& before, Store& store,
                                 const GroundFiles& files, std::set<std::uint16_t>& events);

}  // namespace ilp::faults
