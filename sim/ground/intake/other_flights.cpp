#include "sim/ground/intake/other_flights.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "fsw/base/status.hpp"
#include "fsw/records/store_epoch_ids.hpp"
#include "sim/ground/intake/ids.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::intake {
namespace {

/// Width, height and intrinsics.
using CameraKey = std::array<double, 2 + CameraNumbers::most>;

struct Moment {
  std::int64_t id = 0;
  TimeNs time_ns = 0;
  auto operator<=>(const Moment&) const = default;
};

template <typename Record>
std::vector<Record> records_in(const RecordFile& file) {
  std::vector<Record> records;
  for (const RecordEntry& entry : file.entries) {
    if (entry.type == record_info<Record>().type) records.push_back(record_of<Record>(entry));
  }
  return records;
}

std::optional<CameraKey> frozen_camera(const RecordFile& file) {
  for (const CameraRecord& record : records_in<CameraRecord>(file)) {
    if (!record.frozen) continue;
    const CameraModel c = camera_model(record);
    CameraKey key{static_cast<double>(c.width), static_cast<double>(c.height)};
    std::ranges::copy(camera_numbers(c).values, key.begin() + 2);
    return key;
  }
  return std::nullopt;
}

std::optional<CameraKey> camera_of_most(const std::vector<const RecordFile*>& files) {
  std::map<CameraKey, std::size_t> counts;
  for (const RecordFile* file : files) {
    if (const auto camera = frozen_camera(*file)) ++counts[*camera];
  }
  const auto most =
      std::max_element(counts.begin(), counts.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  return most == counts.end() ? std::nullopt : std::optional(most->first);
}

/// The longest sequence in which ids rise and times do not fall (patience sorting).
std::set<Moment> longest_flight(const std::set<Moment>& moments) {
  // By id; of one id the latest first, so that a sequence takes one of them.
  std::vector<Moment> sorted(moments.begin(), moments.end());
  std::sort(sorted.begin(), sorted.end(),
            [](const Moment& a, const Moment& b) { return a.id != b.id ? a.id < b.id : a.time_ns > b.time_ns; });
  std::vector<std::size_t> tails, before(sorted.size());
  constexpr auto none = static_cast<std::size_t>(-1);
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    const auto at = std::upper_bound(tails.begin(), tails.end(), sorted[i].time_ns,
                                     [&](TimeNs time, std::size_t tail) { return time < sorted[tail].time_ns; });
    before[i] = at == tails.begin() ? none : *(at - 1);
    if (at == tails.end()) {
      tails.push_back(i);
    } else {
      *at = i;
    }
  }
  std::set<Moment> flight;
  for (std::size_t i = tails.empty() ? none : tails.back(); i != none; i = before[i]) flight.insert(sorted[i]);
  return flight;
}

/// Which store epoch a number of a keyframe belongs to.
class StoreEpochs {
 public:
  explicit StoreEpochs(const std::vector<RecordFile>& files) {
    for (const RecordFile& file : files) {
      for (const EventRecord& event : records_in<EventRecord>(file)) {
        if (event.code == static_cast<std::uint16_t>(StatusCode::life_begun) && is_id(event.b)) begins_.insert(event.b);
      }
    }
  }
  /// The numbers of ordinary store epochs show it themselves; for other store epochs the event with which they began
  /// does.
  [[nodiscard]] std::pair<std::int64_t, std::int64_t> of(std::int64_t keyframe_id) const {
    return {(keyframe_id - 1) / ids_per_store_epoch, std::distance(begins_.begin(), begins_.upper_bound(keyframe_id))};
  }

 private:
  std::set<std::int64_t> begins_;
};

void find_contradictions(const std::vector<const RecordFile*>& files, std::vector<ForeignFile>& foreign) {
  const auto camera = camera_of_most(files);
  std::vector<const RecordFile*> same_camera;
  std::set<Moment> moments;
  for (const RecordFile* file : files) {
    const auto own = frozen_camera(*file);
    if (own && own != camera) {
      foreign.push_back({file->file, "of another flight: its camera is not the one of most files"});
      continue;
    }
    same_camera.push_back(file);
    for (const KeyframeRecord& keyframe : records_in<KeyframeRecord>(*file)) {
      moments.insert({keyframe.id, keyframe.time_ns});
    }
  }
  const std::set<Moment> flight = longest_flight(moments);
  for (const RecordFile* file : same_camera) {
    for (const KeyframeRecord& keyframe : records_in<KeyframeRecord>(*file)) {
      if (flight.contains({keyframe.id, keyframe.time_ns})) continue;
      foreign.push_back({file->file, "of another flight: keyframe " + std::to_string(keyframe.id) + " taken at " +
                                         host::fixed(1e-9 * static_cast<double>(keyframe.time_ns), 1) +
                                         " s does not fit the times of the others"});
      break;
    }
  }
}

}  // namespace

std::vector<ForeignFile> files_of_other_flights(const std::vector<RecordFile>& files) {
  const StoreEpochs store_epochs(files);
  std::map<std::pair<std::int64_t, std::int64_t>, std::vector<const RecordFile*>> of_store_epochs;
  for (const RecordFile& file : files) {
    const std::vector<KeyframeRecord> keyframes = records_in<KeyframeRecord>(file);
    of_store_epochs[store_epochs.of(keyframes.empty() ? 1 : keyframes[0].id)].push_back(&file);
  }
  std::vector<ForeignFile> foreign;
  for (const auto& [store_epoch, own] : of_store_epochs) find_contradictions(own, foreign);
  return foreign;
}

}  // namespace ilp::intake
